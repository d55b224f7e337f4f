//! The one integration binary.

mod gpu;
mod quadrature;
mod random;
mod stats;

mod alias;
mod builtin;
mod device;
mod rng;
mod sampling;
mod film;
mod gpu;
