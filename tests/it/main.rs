//! The one integration binary.

mod film;
