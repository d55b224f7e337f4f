//! The one integration binary.

mod against_judge;
mod alias;
mod bsdf;
mod bsdf_f64;
mod builtin;
mod device;
mod environment;
mod film;
mod float_probe;
mod fuzz;
mod gltf_file;
mod gpu;
mod judge;
mod layers;
mod layout;
mod loader;
mod loader_bad;
mod loader_materials;
mod quadrature;
mod random;
mod reference;
mod rng;
mod sampling;
mod stats;
mod traversal;
mod watertight;
