//! From a scene and options to a picture: what comes before the first sample, the loop over rounds of samples, reports.

mod auto;
mod budget;
mod caveats;
mod checkpoint;
mod error;
mod glossy;
mod halves;
mod layers;
mod meanwhile;
mod memory;
mod options;
mod prepared;
mod published;
pub mod rays;
mod renderer;
mod report;
mod seen;
pub mod tracing;

pub use crate::film::state::pixel_sums;
pub use auto::{Automatic, for_surfaces};
pub use budget::{Budget, Estimate, Progress, Stop, TimeLimit};
pub use checkpoint::{Keeping, picture_of, rays_of, take_up};
pub use error::RenderError;
pub use halves::NoHalves;
pub use memory::PictureMemory;
pub use options::RenderOptions;
pub use prepared::{Prepared, Uploaded};
pub use published::LIGHT_PATHS_PER_PIXEL as PUBLISHED_LIGHT_PATHS_PER_PIXEL;
pub use renderer::{LearningTime, MIN_SAMPLES_FOR_ERROR, Renderer};
pub use report::{DENOISED_ERROR, ERROR, Origin, Report, made_by, maker};
pub use seen::SeenLayers;
