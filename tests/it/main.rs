//! The one integration binary.

mod builtin;
