//! What is to be learnt of a scene, and what comes of it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Training;
use super::TrainingError;
use crate::device::Context;
use crate::device::layout::{Batch, Camera};
use crate::device::scene::DeviceScene;
use crate::integrator::{Choice, Settings, Wavefront};
use crate::math::rng::seed_key;
use crate::subspace::settings::MOST_FOLLOWED;
use crate::subspace::{self, Connections, FirstConnections, LightSample, Model, TrainingInput, TrainingSet};

/// Light paths for Q. Five times as many lower the error of a picture by less than a hundredth.
pub(super) const LIGHT_PATHS: u32 = 200_000;
/// Vertices of the longest path to learn from.
const LONGEST_PATH: u32 = 64;
/// Sets the numbers of these paths apart from those of every render.
const TRAINING_STREAM: u32 = 0x2545_f491;

/// What there is to learn; on the device it shares the scene's buffers.
pub struct TrainingTask {
    pub(super) context: Context,
    pub(super) scene: DeviceScene,
    pub(super) camera: Camera,
    /// Of the render to come.
    pub(super) settings: Settings,
    pub(super) scene_hash: u64,
    pub(super) training: Training,
    pub(super) warm_start: Option<WarmStart>,
}

/// What was learnt of a scene before: to begin with, and what does not depend on where the camera is.
#[derive(Clone)]
pub struct WarmStart {
    pub model: Arc<Model>,
    pub(super) lights: Arc<Vec<LightSample>>,
    pub(super) light_paths: u32,
}

/// How far learning is; where a share is known, of what is wanted.
#[derive(Clone)]
pub enum TrainingProgress {
    /// Full paths for Gamma.
    TrainingPaths(f64),
    /// Light paths for Q.
    LightPaths(f64),
    /// Trees and Gamma, on the host: asked before, not meanwhile.
    Fitting,
    /// A round is over: the model that it made.
    Round(Arc<Model>),
    /// The loss after the last round over that before it, on paths that were found since.
    Loss(f64),
}

/// A trained model with what it took.
#[derive(Clone)]
pub struct TrainingResult {
    pub model: Arc<Model>,
    /// Of tracing on the device, and of the rest.
    pub tracing: Duration,
    pub learning: Duration,
    /// Camera paths that it took to find the training paths.
    pub camera_paths: u64,
    /// Of learning from its own connections: the loss after each round over that before it, on the paths that the next
    /// iteration found. (A last round without a next iteration has none.)
    pub losses: Vec<f64>,
    pub choices: Vec<Choice>,
    /// To learn more of the same scene, seen by another camera.
    pub warm_start: Option<WarmStart>,
}

impl TrainingTask {
    /// `settings` are those of the render to come.
    pub fn new(
        context: &Context,
        scene: &DeviceScene,
        camera: &Camera,
        settings: Settings,
        scene_hash: u64,
        training: &Training,
    ) -> Self {
        Self {
            context: context.clone(),
            scene: scene.clone(),
            camera: *camera,
            settings: Settings {
                strategy: None,
                timing: false,
                first_hit: false,
                through_mirrors: false,
                transparent: false,
                ..settings
            },
            scene_hash,
            training: training.clone(),
            warm_start: None,
        }
    }

    /// Begins with what is known of the scene, however it was seen.
    pub fn starting_from(self, warm_start: Option<WarmStart>) -> Self {
        Self { warm_start, ..self }
    }

    /// Connections of an eye vertex in the render to come.
    pub(super) fn connections(&self) -> Connections {
        self.settings.method.plan().connections
    }

    /// What a model is made of.
    pub(super) fn input<'a>(
        &'a self,
        set: &'a TrainingSet,
        light_samples: &'a [LightSample],
        light_paths: u32,
    ) -> TrainingInput<'a> {
        TrainingInput {
            set,
            light_samples,
            light_paths: light_paths.into(),
            lights: &self.scene.lights,
            scene_hash: self.scene_hash,
            connections: self.connections(),
            seed: self.settings.view.seed,
        }
    }

    /// Learns a model, which wants so many connections of first vertices.
    ///
    /// # Errors
    /// Settings out of range, no light.
    pub(super) fn fit(
        &self,
        input: &TrainingInput,
        first_connections: Option<FirstConnections>,
    ) -> Result<Arc<Model>, TrainingError> {
        let model = subspace::train(input, self.training.settings.clone())?;
        Ok(Arc::new(Model { first_connections, ..model }))
    }
}

/// Time by purpose.
pub(super) struct Clock {
    start: Instant,
    pub learning: Duration,
}

impl Clock {
    pub fn new() -> Self {
        Self { start: Instant::now(), learning: Duration::ZERO }
    }

    /// Counts as learning.
    pub fn learn<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.learning += start.elapsed();
        result
    }

    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Time for each of so many camera paths.
    pub fn time_per_path(&self, camera_paths: u64) -> Duration {
        self.elapsed().div_f64(camera_paths.max(1) as f64)
    }

    pub fn result(self, model: Arc<Model>, camera_paths: u64) -> TrainingResult {
        let tracing = self.elapsed() - self.learning;
        let mut choices = Vec::new();
        if model.settings.subspaces.is_none() {
            let reason = format!(
                "as many as the {} connections that were found can teach, up to {MOST_FOLLOWED}",
                model.report.counts.nodes
            );
            choices.push(Choice::new("subspaces", model.subspaces, reason));
        }
        if model.settings.light_guide {
            let density = model.report.guide_gain.exp();
            let wanted = "times as dense where their light is wanted";
            choices.push(match model.guide {
                Some(_) => Choice::new("light paths", "guided", format!("they are {density:.2} {wanted}")),
                None => {
                    let reason = format!("they would be only {density:.2} {wanted}");
                    Choice::new("light paths", "not guided", reason)
                }
            });
        }
        TrainingResult {
            model,
            tracing,
            learning: self.learning,
            camera_paths,
            losses: Vec::new(),
            choices,
            warm_start: None,
        }
    }
}

/// A sample of the pixels that no render has, neither its eye paths nor its light paths.
pub(super) fn training_batch(wavefront: &Wavefront, sample: u32) -> Batch {
    let template = wavefront.batches(sample, 1)[0];
    let seed = seed_key(wavefront.settings.view.seed).wrapping_add(TRAINING_STREAM);
    Batch {
        seed,
        light_seed: template.light_seed.wrapping_add(TRAINING_STREAM),
        max_depth: template.max_depth.min(LONGEST_PATH),
        ..template
    }
}
