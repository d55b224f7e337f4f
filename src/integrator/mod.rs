//! Integrators: what one iteration dispatches.

mod path;
pub mod ray_bench;
mod wavefront;

pub use path::PathIntegrator;
pub use wavefront::{RayCounts, Region};

/// Settings that every integrator understands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The whole picture, pixels.
    pub width: u32,
    pub height: u32,
    /// The part that is rendered.
    pub region: Region,
    /// Paths end after this many surfaces; `None` leaves their end to roulette.
    pub max_depth: Option<u32>,
    /// The user's seed.
    pub seed: u64,
    /// Prepare for [`Wavefront::first_hits`](wavefront::Wavefront::first_hits).
    pub first_hit: bool,
    /// Time every kernel with the device's timestamps.
    pub timing: bool,
}
