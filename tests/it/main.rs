//! The one integration binary.

mod bsdf_f64;
mod gpu;
mod quadrature;
mod random;
mod reference;
mod stats;

mod alias;
mod bsdf;
mod builtin;
mod device;
mod film;
mod environment;
mod film;
mod gpu;
mod film;
mod judge;
mod layers;
mod loader;
mod rng;
mod sampling;
