//! What a render did, for people and for the picture's file.

use serde::Serialize;

use super::Stop;
use crate::device::Traversal;
use crate::film::Attribute;
use crate::integrator::{Choice, Method, RayCounts};
use crate::scene::SceneFeatures;
use crate::subspace::TrainingReport;

/// Names of [`Report::estimated_error`] and [`Report::denoised_error`] in a picture's file.
pub const ERROR: &str = "estimatedError";
pub const DENOISED_ERROR: &str = "estimatedErrorDenoised";

/// What a render did, for reports.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub stop: Stop,
    pub samples: u32,
    /// Seconds of rendering; of building the BVH; of uploading; of compiling.
    pub seconds: f64,
    pub accel_seconds: f64,
    pub upload_seconds: f64,
    /// Of uploading, what the environment's map and table took.
    pub environment_seconds: f64,
    pub compile_seconds: f64,
    /// Of learning before the first sample: tracing, and all of it.
    pub pretracing_seconds: f64,
    pub preprocessing_seconds: f64,
    pub estimated_error: Option<f64>,
    /// Of the denoised picture, where there is one; and why it is not known, where it is not.
    pub denoised_error: Option<f64>,
    pub denoised_error_unknown: Option<String>,
    pub rays: RayCounts,
    pub non_finite: u64,
    pub triangles: usize,
    pub dropped_triangles: usize,
    pub lights: usize,
    pub features: SceneFeatures,
    /// What traced the rays.
    pub traversal: Traversal,
    /// What is not shown as the scene's file has it, a line each.
    pub warnings: Vec<String>,
    /// What the method does not show of this scene, or does not know of its own error; a line each.
    pub caveats: Vec<String>,
    /// Of the model that was learnt or given.
    pub training: Option<TrainingReport>,
    /// The loss after each round over that before it, as far as it is known.
    pub round_losses: Vec<f64>,
    /// Samples per pixel that were there when a round ended, where learning goes on while rendering.
    pub round_samples: Vec<u32>,
    /// What was chosen without being asked for, and why.
    pub choices: Vec<Choice>,
    /// Kernels that were compiled, in order; again where one has several forms.
    pub compiled: Vec<String>,
    /// Bytes by buffer.
    pub memory: Vec<(String, u64)>,
    /// Seconds and dispatches by kernel, where timed.
    pub kernels: std::collections::BTreeMap<String, (f64, u64)>,
}

/// What a picture's file says of how it was made, beside the report.
#[derive(Clone, Debug)]
pub struct Origin {
    pub method: Method,
    pub seed: u64,
    pub scene_hash: u64,
    /// As [`Context::describe`] says it.
    pub device: String,
    pub command_line: String,
}

/// Behind the device's name, where its ray queries traced.
const BY_HARDWARE: &str = ", traversal by hardware";

/// What made samples, as files name it: a device, and what of it traced the rays. Samples of two that differ are of one
/// picture, and may be merged; a render goes on with its own.
pub fn made_by(device: &str, traversal: Traversal) -> String {
    match traversal {
        Traversal::Hardware => format!("{device}{BY_HARDWARE}"),
        Traversal::Compute | Traversal::Auto => device.into(),
    }
}

/// The device of [`made_by`], and what traced.
pub fn maker(made_by: &str) -> (&str, Traversal) {
    match made_by.strip_suffix(BY_HARDWARE) {
        Some(device) => (device, Traversal::Hardware),
        None => (made_by, Traversal::Compute),
    }
}

impl Report {
    /// For [`Picture::metadata`]. `warnings` and `caveats` are there only where there are any, errors where they are known.
    pub fn metadata(&self, origin: &Origin) -> Vec<(String, Attribute)> {
        let text = |name: &str, value: String| (name.to_string(), Attribute::Text(value));
        let number = |name: &str, value: f64| (name.to_string(), Attribute::Number(value));
        let mut metadata = vec![
            text("renderer", concat!("Halfway ", env!("CARGO_PKG_VERSION")).into()),
            text("integrator", origin.method.name().into()),
            number("spp", f64::from(self.samples)),
            number("seconds", self.seconds),
            number("preprocessingSeconds", self.preprocessing_seconds),
            text("seed", origin.seed.to_string()),
            text("device", made_by(&origin.device, self.traversal)),
            text("sceneHash", format!("{:016x}", origin.scene_hash)),
            text("biased", "no".into()),
            number("nonFiniteSamples", self.non_finite as f64),
            text("commandLine", origin.command_line.clone()),
        ];
        for (name, error) in [(ERROR, self.estimated_error), (DENOISED_ERROR, self.denoised_error)] {
            metadata.extend(error.map(|error| number(name, error)));
        }
        for (name, lines) in [("warnings", &self.warnings), ("caveats", &self.caveats)] {
            if !lines.is_empty() {
                metadata.push(text(name, lines.join("\n")));
            }
        }
        metadata
    }
}
