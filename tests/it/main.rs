//! The one integration binary.

mod builtin;
mod layers;
