//! The one integration binary.

mod builtin;
mod device;
mod film;
mod gpu;
mod loader;
