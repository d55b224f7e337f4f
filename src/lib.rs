//! # Halfway
//!
//! A light-transport renderer on Vulkan compute shaders.
//!
//! ```text
//! glTF file -> scene -> accel (BVH and flat arrays) -> device (buffers, kernels)
//!           -> integrator (one iteration) -> film (sums) -> EXR / PNG
//! ```
//!
//! Layers, top may use lower, never the reverse:
//! `main`, `cli`, `preview` > `bench` > `render` > `training` > `integrator` > `subspace`, `film` > `device` > `accel` >
//! `scene` > `picture_file` > `math` > `fault`, `stdout`.

pub mod accel;
pub mod bench;
pub mod cli;
pub mod device;
pub mod fault;
pub mod film;
pub mod integrator;
pub mod math;
pub mod picture_file;
#[cfg(feature = "preview")]
pub mod preview;
pub mod render;
pub mod scene;
pub mod stdout;
pub mod subspace;
pub mod training;
