//! The one integration binary.

mod bsdf_f64;
mod gpu;
mod quadrature;
mod random;
mod reference;
mod stats;

mod alias;
mod builtin;
mod device;
mod environment;
mod film;
mod judge;
mod layers;
mod loader;
mod rng;
mod sampling;
