//! The one integration binary.

mod gpu;
mod quadrature;
mod random;
mod stats;

mod alias;
mod rng;
mod sampling;
