//! The one integration binary.

#![allow(clippy::unwrap_used, reason = "a test ends where its preparation fails")]

mod against_judge;
mod alias;
mod bidirectional;
mod bsdf;
mod bsdf_f64;
mod builtin;
mod closed_forms;
mod command;
mod compare;
mod degenerate;
mod determinism;
mod device;
mod environment;
mod film;
mod film_sums;
mod float_probe;
mod fuzz;
mod gltf_file;
mod gpu;
mod judge;
mod judge_bidirectional;
mod layers;
mod layout;
mod loader;
mod loader_bad;
mod loader_materials;
mod metamorphic;
mod metric;
mod public_scenes;
mod quadrature;
mod random;
mod reference;
mod respawn;
mod rng;
mod sampling;
mod shots;
mod specialised;
mod stats;
mod subspace_gamma;
mod traversal;
mod twins;
mod watertight;
