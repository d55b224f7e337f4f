//! The judge: a naive renderer in f64, written from the definitions and not for speed, by which the renderer's
//! pictures are judged. It shares the scene's data types with the renderer, and `bsdf_f64` with the tests of
//! the BSDF; everything else (intersection, sampling, lights, random numbers) is its own.
//!
//! The estimator is a path tracer that weighs its two ways to find a light (a direction drawn from the BSDF, a point
//! drawn on the light) by the balance heuristic: the contribution of a path, divided by the sum of the densities with
//! which the two ways would have found it.

//!
//! Beside it stands path space itself: f(path), the densities p_{s,t}(path) of every way to make it from both ends, and
//! their weights, written from the definitions, for any full path; and a bidirectional renderer that is nothing but
//! these.

pub mod bidirectional;
pub mod camera;
pub mod geometry;
mod light;
pub mod path_space;
pub mod picks;
mod random;
pub mod texture;
mod tracer;
mod world;

pub use tracer::{Options, Render, render};
