//! The budget loop: rounds of samples until the first limit of samples, time or error is met.

pub mod efficiency;
mod prepared;
pub mod reference;
pub mod trade;

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::device::Context;
use crate::device::layout::{FilmPixel, FirstHitPixel};
use crate::error::RenderError;
use crate::film::sums::{FilmSums, PixelSums, SAMPLES_A_FLUSH};
use crate::film::{Layer, Picture};
use crate::integrator::{Choice, FirstSubspaces, Integrator, Method, RayCounts, Region, Strategy, Training};
use crate::scene::{Scene, SceneFeatures};
use crate::subspace::{Model, TrainingReport};

pub use prepared::Prepared;

/// When to stop: the first limit that is met.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Samples a pixel.
    pub samples: Option<u32>,
    /// Rendering time, pre-processing included; loading and shader compilation are not.
    pub time: Option<Duration>,
    /// Estimated error of the picture, see [`FilmSums::estimated_error`].
    pub error: Option<f64>,
}

/// Below this many samples a pixel an error estimate is not trusted to stop a render: light that has not been found
/// is not in it.
const MIN_SAMPLES_FOR_ERROR: u32 = 64;
/// Samples that the layers albedo, normal and depth are averaged over.
const FIRST_HIT_SAMPLES: u32 = 16;
/// A round ends after about this time, so that progress shows and an interrupt is soon heard.
const ROUND: Duration = Duration::from_millis(300);

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// The whole picture, pixels.
    pub width: u32,
    pub height: u32,
    /// The part to render; `None` for the whole.
    pub crop: Option<Region>,
    /// Index into the scene's cameras.
    pub camera: usize,
    pub max_depth: Option<u32>,
    pub seed: u64,
    pub method: Method,
    /// Of a bidirectional method, show this strategy only.
    pub strategy: Option<Strategy>,
    pub budget: Budget,
    /// Layers for albedo, normal and depth.
    pub first_hit_layers: bool,
    /// Time every kernel.
    pub timing: bool,
    /// What `Method::SpcBpt` has learnt before; `None`: it learns from `training` first.
    pub model: Option<Arc<Model>>,
    pub training: Training,
    /// Features to compile for; `None` takes those of the scene (tests force others).
    pub features: Option<SceneFeatures>,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 256,
            height: 256,
            crop: None,
            camera: 0,
            max_depth: None,
            seed: 0,
            method: Method::default(),
            strategy: None,
            budget: Budget::default(),
            first_hit_layers: false,
            timing: false,
            model: None,
            training: Training::default(),
            features: None,
        }
    }
}

/// Where a render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    pub samples: u32,
    pub elapsed: Duration,
    pub estimated_error: Option<f64>,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    Samples,
    Time,
    Error,
    Interrupted,
}

/// What a render did, for reports.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub stop: Stop,
    pub samples: u32,
    /// Seconds of rendering; of building the BVH; of uploading; of compiling.
    pub seconds: f64,
    pub accel_seconds: f64,
    pub upload_seconds: f64,
    pub compile_seconds: f64,
    /// Of learning before the first sample: tracing, and all of it.
    pub pretracing_seconds: f64,
    pub preprocessing_seconds: f64,
    pub estimated_error: Option<f64>,
    pub rays: RayCounts,
    pub non_finite: u64,
    pub triangles: usize,
    pub dropped_triangles: usize,
    pub lights: usize,
    pub features: SceneFeatures,
    /// Of the model that was learnt or given.
    pub training: Option<TrainingReport>,
    /// The loss after each lesson over that before it, as far as it is known.
    pub lesson_losses: Vec<f64>,
    /// What nobody asked for, and why it is so.
    pub choices: Vec<Choice>,
    /// Bytes by buffer.
    pub memory: Vec<(String, u64)>,
    /// Seconds and dispatches by kernel, where timed.
    pub kernels: std::collections::BTreeMap<String, (f64, u64)>,
}

/// A scene made ready for one device: renders can be continued and looked at.
pub struct Renderer<'a> {
    context: &'a Context,
    /// What `Method::SpcBpt` connects by.
    pub model: Option<Arc<Model>>,
    integrator: Box<dyn Integrator>,
    options: RenderOptions,
    sums: FilmSums,
    first_hits: Vec<FirstHitPixel>,
    samples: u32,
    elapsed: Duration,
    radiance_scale: f64,
    /// Length of a unit of unit space in scene units.
    length_scale: f64,
    report: Report,
}

impl<'a> Renderer<'a> {
    /// Builds everything that the scene requires, and learns where the method has to and nothing is learnt yet;
    /// [`Prepared`] does so in steps.
    ///
    /// # Errors
    /// No such camera, a picture without pixels, or what the layers below report.
    pub fn new(context: &'a Context, scene: &Scene, options: RenderOptions) -> Result<Self, RenderError> {
        Prepared::new(context, scene, options)?.renderer()
    }

    /// Starts anew with another seed, and with one strategy of a bidirectional method alone (or all of them).
    ///
    /// # Errors
    /// A lost device.
    pub fn restart(&mut self, seed: u64, strategy: Option<Strategy>) -> Result<(), RenderError> {
        self.integrator.wavefront_mut().choose(seed, strategy);
        self.integrator.wavefront_mut().reset(self.context)?;
        self.sums = FilmSums::new(self.sums.width, self.sums.height);
        self.samples = 0;
        self.elapsed = Duration::ZERO;
        Ok(())
    }

    /// Renders to another budget from now on.
    pub fn set_budget(&mut self, budget: Budget) {
        self.options.budget = budget;
    }

    /// Renders until a limit of the budget is met or `interrupted` says so; it is asked after every round.
    ///
    /// # Errors
    /// A lost device.
    pub fn run(&mut self, mut interrupted: impl FnMut(&Progress) -> bool) -> Result<Stop, RenderError> {
        let start = Instant::now();
        let before = self.elapsed;
        let budget = self.options.budget;
        let at_once = self.integrator.samples_at_once();
        let mut round = at_once;
        let stop = loop {
            if budget.samples.is_some_and(|samples| self.samples >= samples) {
                break Stop::Samples;
            }
            let to_flush = SAMPLES_A_FLUSH - self.samples % SAMPLES_A_FLUSH;
            let to_end = budget.samples.map_or(u32::MAX, |samples| samples - self.samples);
            let samples = round.min(to_flush).min(to_end);
            let rest = (self.samples + samples) % at_once;
            let samples = if rest < samples { samples - rest } else { samples };
            let round_start = Instant::now();
            self.integrator.render(self.context, self.samples, samples)?;
            self.context.wait()?;
            self.samples += samples;
            self.elapsed = before + start.elapsed();
            if self.samples.is_multiple_of(SAMPLES_A_FLUSH) {
                let taken = self.integrator.wavefront().take_film(self.context)?;
                self.sums.add(taken.iter().map(pixel_sums), 1.0);
            }
            let error = self.current_sums()?.estimated_error();
            let progress = Progress { samples: self.samples, elapsed: self.elapsed, estimated_error: error };
            if interrupted(&progress) {
                break Stop::Interrupted;
            }
            let reached = |wanted: f64| error.is_some_and(|error| error <= wanted);
            if self.samples >= MIN_SAMPLES_FOR_ERROR && budget.error.is_some_and(reached) {
                break Stop::Error;
            }
            let a_sample = round_start.elapsed().as_secs_f64() / f64::from(samples);
            let next = (ROUND.as_secs_f64() / a_sample) as u32;
            round = next.clamp(at_once, round.max(at_once) * 4);
            if let Some(time) = budget.time {
                let used = self.elapsed.as_secs_f64() + self.report.preprocessing_seconds;
                let left = time.as_secs_f64() - used;
                if left <= 0.5 * a_sample {
                    break Stop::Time;
                }
                round = round.min(((left / a_sample) as u32).max(1));
            }
        };
        self.report.stop = stop;
        Ok(stop)
    }

    /// Host sums and what the device has not handed over yet.
    fn current_sums(&self) -> Result<FilmSums, RenderError> {
        let mut sums = self.sums.clone();
        if !self.samples.is_multiple_of(SAMPLES_A_FLUSH) {
            sums.add(self.integrator.wavefront().film(self.context)?.iter().map(pixel_sums), 1.0);
        }
        Ok(sums)
    }

    /// The picture so far, with its layers.
    ///
    /// # Errors
    /// A lost device.
    pub fn picture(&self) -> Result<Picture, RenderError> {
        let mut picture = self.current_sums()?.picture(self.radiance_scale);
        if self.options.first_hit_layers {
            picture.layers.extend(self.first_hit_layers());
        }
        Ok(picture)
    }

    /// As [`Integrator::first_subspaces`].
    ///
    /// # Errors
    /// A lost device.
    pub fn first_subspaces(&mut self) -> Result<Option<Vec<FirstSubspaces>>, RenderError> {
        Ok(self.integrator.first_subspaces(self.context)?)
    }

    /// What was done so far.
    ///
    /// # Errors
    /// A lost device.
    pub fn report(&self) -> Result<Report, RenderError> {
        let sums = self.current_sums()?;
        let mut report = self.report.clone();
        report.samples = self.samples;
        report.seconds = self.elapsed.as_secs_f64();
        report.estimated_error = sums.estimated_error();
        let wavefront = self.integrator.wavefront();
        report.rays = wavefront.ray_counts(self.context)?;
        report.non_finite = sums.non_finite() + report.rays.non_finite_vertices;
        report.kernels = wavefront.kernel_times();
        report.memory = wavefront.buffers.sizes();
        Ok(report)
    }

    fn first_hit_layers(&self) -> [Layer; 3] {
        let samples = FIRST_HIT_SAMPLES as f32;
        let layer = |name: &str, channels: [&str; 3], of: fn(&FirstHitPixel) -> [f32; 3]| Layer {
            name: name.into(),
            channels: (0..3)
                .map(|c| {
                    let values = self.first_hits.iter().map(|pixel| of(pixel)[c] / samples).collect();
                    (channels[c].to_string(), values)
                })
                .collect(),
        };
        // Depth is the mean over the samples that met a surface; infinite where none did.
        let depth = |pixel: &FirstHitPixel| match pixel.hits {
            0 => f32::INFINITY,
            hits => (f64::from(pixel.depth) / f64::from(hits) * self.length_scale) as f32,
        };
        let depths = self.first_hits.iter().map(depth).collect();
        [
            layer("albedo", ["R", "G", "B"], |pixel| pixel.albedo),
            layer("normal", ["X", "Y", "Z"], |pixel| pixel.normal),
            Layer { name: "depth".into(), channels: vec![("Z".into(), depths)] },
        ]
    }
}

/// A pixel of the film as the device hands it over.
pub fn pixel_sums(pixel: &FilmPixel) -> PixelSums {
    let mut sums = PixelSums {
        sum: pixel.sum.map(f64::from),
        sum_sq: pixel.sum_sq.map(f64::from),
        count: u64::from(pixel.count),
        groups: u64::from(pixel.open_groups >> 8),
        non_finite: u64::from(pixel.non_finite),
        weight: f64::from(pixel.count),
    };
    sums.add_group(pixel.open.map(f64::from), u64::from(pixel.open_groups & 0xff));
    sums
}
