//! Integrators: what one iteration dispatches.

pub(crate) mod bidirectional;
pub mod kernels;
pub mod method;
mod path;
pub mod plan;
mod view;
pub(crate) mod wavefront;

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::device::layout::Camera;
use crate::device::scene::DeviceScene;
use crate::device::{Context, DeviceError};
use crate::film::Region;
use crate::subspace::Model;

pub use bidirectional::settings::*;
pub use method::{Descriptor, METHODS, Method};
pub use plan::{LightPaths, Plan, Selector, Weights};
pub use view::{DEFAULT_ROULETTE_CAP, View};
pub use wavefront::submission::SubmissionLimit;
pub use wavefront::{RayCounts, Wavefront};

pub use crate::subspace::{Connections, MAX_CONNECTIONS};

/// What was chosen without being asked for, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    pub what: Cow<'static, str>,
    pub value: String,
    pub reason: String,
}

impl Choice {
    pub fn new(what: &'static str, value: impl ToString, reason: impl Into<String>) -> Self {
        Self { what: what.into(), value: value.to_string(), reason: reason.into() }
    }
}

/// One of the ways to find a path: by `s` light and `t` eye vertices (the camera is one).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Strategy {
    pub s: u32,
    pub t: u32,
    /// As its share of all strategies, or taken alone.
    pub weighted: bool,
}

/// Settings that every integrator understands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub view: View,
    pub method: Method,
    /// Of a bidirectional integrator, show this strategy only.
    pub strategy: Option<Strategy>,
    /// Prepare for [`Wavefront::first_hits`].
    pub first_hit: bool,
    /// The environment is a light, and not to be seen.
    pub transparent: bool,
    /// Albedo and normal are those of what is seen in mirrors and through smooth glass.
    pub through_mirrors: bool,
    /// Time every kernel with the device's timestamps.
    pub timing: bool,
}

/// What a camera ray meets first, as connections by subspaces see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstSubspaces {
    /// Eye and light subspace; `None` where the ray meets nothing, or a light.
    pub labels: Option<[u32; 2]>,
    /// Unit vector of the ray.
    pub world_direction: [f32; 3],
    /// What it meets, in unit space.
    pub position: [f32; 3],
}

impl FirstSubspaces {
    /// 1 where the ray meets a surface of that normal straight on, 0 at grazing angles.
    pub fn facing(&self, world_normal: [f32; 3]) -> f32 {
        glam::Vec3::from(self.world_direction).dot(world_normal.into()).abs()
    }
}

/// An integrator on a device, with the scene.
pub trait Integrator: Send {
    /// Traces samples `first_sample .. first_sample + samples` of every pixel into the film on the device.
    ///
    /// # Errors
    /// A lost device, or a buffer that would have to grow beyond the device's limits.
    fn render(&mut self, context: &Context, first_sample: u32, samples: u32) -> Result<(), DeviceError>;

    /// Samples that rounds had best be made of, counted from the first: fewer leave queues empty. The picture is the same
    /// bit for bit.
    fn samples_at_once(&self) -> u32 {
        1
    }

    /// Another view, of no more pixels than the first; what there is of the last has to be reset.
    ///
    /// # Errors
    /// A lost device, a buffer that does not fit.
    fn aim(&mut self, context: &Context, camera: &Camera, region: Region) -> Result<(), DeviceError> {
        self.wavefront_mut().aim(context, camera, region)
    }

    /// Connects by another model from now on, where it connects by one.
    ///
    /// # Errors
    /// A buffer that does not fit.
    fn set_model(&mut self, context: &Context, model: &Model) -> Result<(), DeviceError> {
        let _ = (context, model);
        Ok(())
    }

    /// What the integrator chose for this scene and picture.
    fn choices(&self) -> Vec<Choice> {
        Vec::new()
    }

    /// What users have to know before they trust the picture, a line each.
    fn caveats(&self) -> Vec<String> {
        Vec::new()
    }

    /// Runs every kernel once on next to nothing; the film is dirty afterwards.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    fn warm_up(&mut self, context: &Context) -> Result<(), DeviceError>;

    /// The subspaces of what one camera ray per pixel meets first, pixel by pixel; `None` where none are learnt. For
    /// pictures of them, after the render: it counts rays.
    ///
    /// # Errors
    /// A lost device.
    fn first_subspaces(&mut self, context: &Context) -> Result<Option<Vec<FirstSubspaces>>, DeviceError> {
        let _ = context;
        Ok(None)
    }

    fn wavefront(&self) -> &Wavefront;
    fn wavefront_mut(&mut self) -> &mut Wavefront;
}

/// Makes the integrator that the settings ask for. `model`: what it connects by, where the method learns.
///
/// # Errors
/// A kernel that does not compile, a buffer that does not fit.
pub fn integrator(
    context: &Context,
    scene: DeviceScene,
    camera: &Camera,
    settings: Settings,
    model: Option<&Model>,
) -> Result<Box<dyn Integrator>, DeviceError> {
    if settings.method.plan().light_paths == LightPaths::None {
        return Ok(Box::new(path::PathIntegrator::new(context, scene, camera, settings)?));
    }
    let purpose = bidirectional::Purpose::Picture;
    Ok(Box::new(bidirectional::Bidirectional::new(context, scene, camera, settings, model, purpose)?))
}
