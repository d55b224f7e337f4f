//! The one integration binary.

mod gpu;
mod quadrature;
mod random;
mod stats;

mod alias;
mod builtin;
mod device;
mod environment;
mod film;
mod gpu;
mod layers;
mod loader;
mod rng;
mod sampling;
