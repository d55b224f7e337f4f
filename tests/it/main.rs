//! The one integration binary.

mod bsdf_f64;
mod gpu;
mod quadrature;
mod random;
mod stats;

mod alias;
mod bsdf;
mod builtin;
mod device;
mod film;
mod layers;
mod loader;
mod rng;
mod sampling;
