//! The one integration binary.

mod builtin;
mod layers;
mod device;
mod film;
mod gpu;
