//! The one integration binary.

mod builtin;
mod device;
mod environment;
mod film;
mod gpu;
