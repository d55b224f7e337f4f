//! The one integration binary.

mod builtin;
mod device;
mod film;
mod fuzz;
mod gltf_file;
mod gpu;
mod loader;
mod loader_bad;
mod loader_materials;
