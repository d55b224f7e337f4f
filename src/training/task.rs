//! Learning before rendering: where the paths come from, and what is made of them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use serde::Serialize;

use crate::device::layout::{
    Batch, Camera, LIGHT_ENVIRONMENT, LIGHT_TRIANGLE, Light, PunctualLight, TRIANGLE_FLIPPED, Triangle,
};
use crate::device::scene::DeviceScene;
use crate::device::{Context, DeviceError};
use crate::math::rng::seed_key;
use crate::render::RenderError;
use crate::subspace::settings::MOST_FOLLOWED;
use crate::subspace::{self, LightSample, LightSourceInfo, Model, SourceKind, TrainingSet};

use super::{guided, pretrace};
use crate::integrator::wavefront::Wavefront;
use crate::integrator::{Choice, Settings};

/// Light paths for Q: more do not lower the error (`prototype.md`, 5).
pub(super) const LIGHT_PATHS: u32 = 200_000;
/// A camera path that is learnt from, in those that are shown: it has more light paths, its vertices are written down,
/// and the host works on them.
const COST_OF_A_PATH: f64 = 2.0;
/// Lessons at most, where nobody asks for more and nobody knows that the render is long enough for them.
pub(super) const DEFAULT_ROUNDS: u32 = 5;
/// Lessons at most, where nobody asks for more; later ones have no more connections to learn from.
pub const LONG_RENDER_ROUNDS: u32 = 7;
/// Vertices of the longest path to learn from.
const LONGEST_PATH: u32 = 64;
/// Sets the numbers of these paths apart from those of every render.
const TRAINING_STREAM: u32 = 0x2545_f491;

/// What to learn from, how, and for how long.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Training {
    /// So many full paths, found by path tracing before anything else, as published; `None`: paths that connections by
    /// subspaces find, by what earlier ones taught.
    pub paths: Option<u32>,
    pub settings: subspace::Settings,
    /// Where it learns from its own connections: models made one after the other, at most; `None`: as many as pay.
    pub lessons: Option<u32>,
    /// Where the last two lessons lowered the loss by a smaller share on average, there is no other; 0: that is no reason.
    pub least_gain: f64,
    /// Camera paths and time of the render to come, learning included, where they are known: there is no other lesson
    /// either where it would take a larger share of the render than it is likely to lower the picture's variance by.
    pub render_paths: Option<u64>,
    pub render_time: Option<Duration>,
    /// Before the first sample, or while the picture is rendered; `None`: as the device and the budget suggest.
    pub when: Option<When>,
}

/// When learning takes place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize)]
pub enum When {
    /// Before the first sample: the same seed makes the same picture.
    First,
    /// On a thread of its own, while it renders by what it knows so far; earlier samples then weigh less, and which
    /// sample is by which lesson is up to the clock.
    Meanwhile,
}

impl std::fmt::Display for When {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.pad(match self {
            Self::First => "first",
            Self::Meanwhile => "meanwhile",
        })
    }
}

impl Training {
    /// So many lessons, whatever they are worth.
    pub fn with_rounds(self, lessons: u32) -> Self {
        Self { lessons: Some(lessons), least_gain: 0.0, ..self }
    }

    /// Lessons at most, and where more of them pay.
    pub(super) fn most_rounds(&self) -> (u32, u32) {
        let knows_the_render = self.render_paths.is_some() || self.render_time.is_some();
        let long = if knows_the_render { LONG_RENDER_ROUNDS } else { DEFAULT_ROUNDS };
        self.lessons.map_or((DEFAULT_ROUNDS, long), |lessons| (lessons, lessons))
    }

    /// Share of the render that `paths` more camera paths would take, at `pace` of time each.
    pub(super) fn share_of_render(&self, paths: u64, pace: Duration) -> f64 {
        let by_paths = self.render_paths.map(|all| COST_OF_A_PATH * paths as f64 / all as f64);
        let by_time = self.render_time.map(|all| pace.as_secs_f64() * paths as f64 / all.as_secs_f64());
        by_paths.unwrap_or(0.0).max(by_time.unwrap_or(0.0))
    }
}

impl Default for Training {
    fn default() -> Self {
        Self {
            paths: None,
            settings: subspace::Settings::default(),
            lessons: None,
            least_gain: 0.03,
            render_paths: None,
            render_time: None,
            when: None,
        }
    }
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
    /// A lesson is over: what it taught.
    Round(Arc<Model>),
    /// The loss after the last lesson over that before it, as paths say that were found since.
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
    /// Of learning from its own connections: the loss after each lesson over that before it, as paths say that the next
    /// iteration found. (Nobody knows it of a last lesson that has none.)
    pub losses: Vec<f64>,
    pub choices: Vec<Choice>,
    /// For another lesson about the same scene, seen by another camera.
    pub known: Option<WarmStart>,
}

/// What was learnt of a scene before: to begin with, and what does not depend on where the camera is.
#[derive(Clone)]
pub struct WarmStart {
    pub model: Arc<Model>,
    pub(super) lights: Arc<Vec<LightSample>>,
    pub(super) light_paths: u32,
}

/// What learning has to know of a scene; on the device it shares the scene's buffers.
pub struct TrainingTask {
    pub(super) context: Context,
    pub(super) scene: DeviceScene,
    pub(super) camera: Camera,
    /// Of the render to come.
    pub(super) settings: Settings,
    pub(super) scene_hash: u64,
    pub(super) training: Training,
    pub(super) sources: Vec<LightSourceInfo>,
    known: Option<WarmStart>,
}

impl TrainingTask {
    /// `settings` are those of the render to come.
    ///
    /// # Errors
    /// A lost device.
    pub fn new(
        context: &Context,
        scene: &DeviceScene,
        camera: &Camera,
        settings: Settings,
        scene_hash: u64,
        training: &Training,
    ) -> Result<Self, DeviceError> {
        Ok(Self {
            context: context.clone(),
            scene: scene.clone(),
            camera: *camera,
            settings: Settings { strategy: None, timing: false, first_hit: false, ..settings },
            scene_hash,
            training: training.clone(),
            sources: sources(context, scene)?,
            known: None,
        })
    }

    /// Begins with what is known of the scene, however it was seen.
    pub fn after(self, known: Option<WarmStart>) -> Self {
        Self { known, ..self }
    }

    pub(super) fn known(&self) -> Option<&WarmStart> {
        self.known.as_ref()
    }
}

/// Learns how to connect in a picture, until `interrupted` says so; it is asked several times a second.
///
/// # Errors
/// A lost device, a scene without light to connect to, [`RenderError::Interrupted`].
pub fn train(
    lesson: &TrainingTask,
    mut interrupted: impl FnMut(TrainingProgress) -> bool,
) -> Result<TrainingResult, RenderError> {
    let go_on =
        |step: TrainingProgress| if interrupted(step) { Err(RenderError::Interrupted) } else { Ok(()) };
    match lesson.training.paths {
        Some(paths) => pretrace::train(lesson, paths, go_on),
        None => guided::train(lesson, go_on),
    }
}

/// The paths that one iteration of connections by `model` finds, as [`train`] learns from them.
///
/// # Errors
/// As [`train`].
pub fn find_training_paths(lesson: &TrainingTask, model: &Model) -> Result<TrainingSet, RenderError> {
    guided::find_paths(lesson, model)
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
    pub fn pace(&self, camera_paths: u64) -> Duration {
        self.elapsed().div_f64(camera_paths.max(1) as f64)
    }

    pub fn trained(self, model: Arc<Model>, camera_paths: u64) -> TrainingResult {
        let tracing = self.elapsed() - self.learning;
        let mut choices = Vec::new();
        if model.settings.subspaces.is_none() {
            let reason = format!(
                "as many as the {} connections that were found can teach, up to {MOST_FOLLOWED}",
                model.report.counts.nodes
            );
            choices.push(Choice::new("subspaces", model.subspaces, reason));
        }
        TrainingResult {
            model,
            tracing,
            learning: self.learning,
            camera_paths,
            losses: Vec::new(),
            choices,
            known: None,
        }
    }
}

/// A sample of the pixels that no render has, neither its eye paths nor its light paths.
pub(super) fn training_batch(wavefront: &Wavefront, sample: u32) -> Batch {
    let template = wavefront.batches(sample, 1)[0];
    let seed = seed_key(wavefront.settings.seed).wrapping_add(TRAINING_STREAM);
    Batch {
        seed,
        light_seed: template.light_seed.wrapping_add(TRAINING_STREAM),
        max_depth: template.max_depth.min(LONGEST_PATH),
        ..template
    }
}

/// The lights as the grouping of their points sees them.
fn sources(context: &Context, scene: &DeviceScene) -> Result<Vec<LightSourceInfo>, DeviceError> {
    let buffers = &scene.buffers;
    if scene.light_count == 0 {
        return Ok(Vec::new());
    }
    let lights: Vec<Light> = buffers.read_elements(context, "lights", scene.light_count as u32)?;
    let triangles: Vec<Triangle> = buffers.read_all(context, "triangles")?;
    let punctual: Vec<PunctualLight> = match scene.features.punctual_lights {
        true => buffers.read_all(context, "punctual_lights")?,
        false => Vec::new(),
    };
    let source = |light: &Light| match light.kind {
        LIGHT_TRIANGLE => {
            let triangle = &triangles[light.index as usize];
            let [a, b, c] = [triangle.v0, triangle.v1, triangle.v2].map(Vec3::from);
            let cross = (b - a).as_dvec3().cross((c - a).as_dvec3());
            let flip = if triangle.material_flags & TRIANGLE_FLIPPED != 0 { -1.0 } else { 1.0 };
            SourceKind::Triangle {
                position: (a + b + c) / 3.0,
                normal: (flip * cross.normalize_or_zero()).as_vec3(),
                area: 0.5 * cross.length() as f32,
            }
        }
        LIGHT_ENVIRONMENT => SourceKind::Environment,
        _ => {
            let light = &punctual[light.index as usize];
            SourceKind::Punctual { position: light.position.into(), direction: light.direction.into() }
        }
    };
    Ok(lights
        .iter()
        .map(|light| LightSourceInfo { kind: source(light), power: f64::from(light.pdf_select) })
        .collect())
}
