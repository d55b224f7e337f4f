//! The budget loop: rounds of samples until the first limit of samples, time or error is met.

mod error;
mod meanwhile;
mod prepared;

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::accel::UnitSpace;
use crate::device::layout::{FilmPixel, FirstHitPixel, SAMPLES_A_GROUP};
use crate::device::{self, Context};
use crate::film::sums::{FilmSums, PixelSums, SAMPLES_A_FLUSH};
use crate::film::{Attribute, Layer, Picture, Region};
use crate::integrator::{
    Choice, FirstSubspaces, Integrator, Method, RayCounts, Strategy, SubmissionLimit, View,
};
use crate::scene::{self, Scene, SceneFeatures};
use crate::subspace::{Model, TrainingReport};
use crate::training::{OnlineTraining, Training};

pub use error::RenderError;
pub use prepared::{Prepared, Uploaded};

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
/// Time between two estimates of the error, in times that one takes.
const ESTIMATES_APART: u32 = 20;
/// A round ends after about this time, so that progress shows and an interrupt is soon heard.
const ROUND: Duration = Duration::from_millis(300);

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    pub view: View,
    /// Index into the scene's cameras.
    pub camera: usize,
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
            view: View::default(),
            camera: 0,
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
    /// Of a moment ago, at times: it takes no more than a small part of the time.
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
    pub round_losses: Vec<f64>,
    /// Samples a pixel that were there when a lesson came, where learning goes on while rendering.
    pub round_samples: Vec<u32>,
    /// What nobody asked for, and why it is so.
    pub choices: Vec<Choice>,
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

impl Report {
    /// For [`Picture::metadata`].
    pub fn metadata(&self, origin: &Origin) -> Vec<(String, Attribute)> {
        let text = |name: &str, value: String| (name.to_string(), Attribute::Text(value));
        let number = |name: &str, value: f64| (name.to_string(), Attribute::Number(value));
        vec![
            text("renderer", concat!("Halfway ", env!("CARGO_PKG_VERSION")).into()),
            text("integrator", origin.method.name().into()),
            number("spp", f64::from(self.samples)),
            number("seconds", self.seconds),
            number("preprocessingSeconds", self.preprocessing_seconds),
            text("seed", origin.seed.to_string()),
            text("device", origin.device.clone()),
            text("sceneHash", format!("{:016x}", origin.scene_hash)),
            text("biased", "no".into()),
            number("nonFiniteSamples", self.non_finite as f64),
            text("commandLine", origin.command_line.clone()),
        ]
    }
}

/// A scene made ready for one device: renders can be continued and looked at.
pub struct Renderer {
    context: Context,
    /// What `Method::SpcBpt` connects by.
    pub model: Option<Arc<Model>>,
    integrator: Box<dyn Integrator>,
    options: RenderOptions,
    scene_hash: u64,
    sums: FilmSums,
    learning: Option<OnlineTraining>,
    /// Samples before which no lesson is heard.
    next_round: u32,
    /// As soon as somebody asks.
    first_hits: Option<Vec<FirstHitPixel>>,
    samples: u32,
    elapsed: Duration,
    radiance_scale: f64,
    unit: UnitSpace,
    report: Report,
}

impl Renderer {
    /// Builds everything that the scene requires, and learns where the method has to and nothing is learnt yet;
    /// [`Prepared`] does so in steps.
    ///
    /// # Errors
    /// No such camera, a picture without pixels, or what the layers below report.
    pub fn new(context: &Context, scene: &Scene, options: RenderOptions) -> Result<Self, RenderError> {
        Prepared::new(context, scene, options)?.renderer()
    }

    /// Starts anew with another seed, and with one strategy of a bidirectional method alone (or all of them). Learning
    /// ends where it is.
    ///
    /// # Errors
    /// A lost device.
    pub fn restart(&mut self, seed: u64, strategy: Option<Strategy>) -> Result<(), RenderError> {
        self.integrator.wavefront_mut().choose(seed, strategy);
        self.learning = None;
        self.next_round = 0;
        self.begin()
    }

    /// Looks from another camera from now on, at a picture of so many pixels (no more than at first), and starts anew.
    ///
    /// # Errors
    /// A part of a picture, or one without pixels or with too many; a lost device.
    pub fn aim(&mut self, camera: &scene::Camera, width: u32, height: u32) -> Result<(), RenderError> {
        let region = Region::whole(width, height);
        let (most, part) = (self.options.view.region(), self.options.view.crop.is_some());
        if part || region.pixels() == 0 || region.pixels() > most.pixels() {
            let part = format!("0,0,{width},{height}");
            return Err(RenderError::BadRegion { part, width: most.width, height: most.height });
        }
        let camera = device::layout::Camera::new(&self.unit, camera, width, height);
        self.integrator.aim(&self.context, &camera, region)?;
        self.sums = FilmSums::new(width, height);
        self.first_hits = None;
        self.begin()
    }

    fn begin(&mut self) -> Result<(), RenderError> {
        self.integrator.wavefront_mut().reset(&self.context)?;
        self.sums = FilmSums::new(self.sums.width, self.sums.height);
        self.report.round_samples.clear();
        self.samples = 0;
        self.elapsed = Duration::ZERO;
        Ok(())
    }

    /// Leaves the device to others in between, from now on.
    pub fn limit_submissions(&mut self, courtesy: SubmissionLimit) {
        self.integrator.wavefront_mut().limit_submissions(courtesy);
    }

    /// Name and buffer of all that it has on the device, the scene included.
    pub fn buffers(&self) -> impl Iterator<Item = (&String, &wgpu::Buffer)> {
        self.integrator.wavefront().buffers.iter()
    }

    /// Of the scene's content.
    pub fn scene_hash(&self) -> u64 {
        self.scene_hash
    }

    /// Samples a pixel so far.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Time of rendering so far.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }

    /// Samples that belong together, see [`Integrator::samples_at_once`].
    pub fn samples_at_once(&self) -> u32 {
        self.integrator.samples_at_once()
    }

    /// Renders `most` samples or a few less, so that pictures never depend on how a render is cut: whole iterations, but
    /// for the end of the budget. Returns how many.
    ///
    /// # Errors
    /// A lost device; [`DeviceError::Abandoned`], after which only starting anew helps.
    pub fn step(&mut self, most: u32) -> Result<u32, RenderError> {
        let start = Instant::now();
        let at_once = self.integrator.samples_at_once();
        // Lessons come between groups.
        let unit = if self.learning.is_some() { SAMPLES_A_GROUP } else { SAMPLES_A_FLUSH };
        let samples = most.min(unit - self.samples % unit);
        let rest = (self.samples + samples) % at_once;
        let samples = if rest < samples { samples - rest } else { samples };
        self.integrator.render(&self.context, self.samples, samples)?;
        self.context.wait()?;
        self.integrator.wavefront_mut().collect_times(&self.context)?;
        self.samples += samples;
        self.poll_training()?;
        if self.samples.is_multiple_of(SAMPLES_A_FLUSH) {
            let taken = self.integrator.wavefront().take_film(&self.context)?;
            self.sums.add(taken.iter().map(pixel_sums));
        }
        self.elapsed += start.elapsed();
        Ok(samples)
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
        let mut estimate = Estimate::default();
        let stop = loop {
            if budget.samples.is_some_and(|samples| self.samples >= samples) {
                break Stop::Samples;
            }
            let to_end = budget.samples.map_or(u32::MAX, |samples| samples - self.samples);
            let round_start = Instant::now();
            let samples = self.step(round.min(to_end))?;
            if estimate.is_due() {
                estimate.renew(|| self.estimated_error())?;
            }
            let error = estimate.error;
            self.elapsed = before + start.elapsed();
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
            sums.add(self.integrator.wavefront().film(&self.context)?.iter().map(pixel_sums));
        }
        Ok(sums)
    }

    /// The picture so far, with its layers.
    ///
    /// # Errors
    /// A lost device.
    pub fn picture(&mut self) -> Result<Picture, RenderError> {
        let mut picture = self.radiance()?;
        if self.options.first_hit_layers {
            let hits = match self.first_hits.take() {
                Some(hits) => hits,
                None => self.integrator.wavefront_mut().first_hits(&self.context, FIRST_HIT_SAMPLES)?,
            };
            picture.layers.extend(self.first_hit_layers(&hits));
            self.first_hits = Some(hits);
        }
        Ok(picture)
    }

    /// As [`picture`](Self::picture), with nothing but radiance and what the samples say of it.
    ///
    /// # Errors
    /// A lost device.
    pub fn radiance(&self) -> Result<Picture, RenderError> {
        Ok(self.current_sums()?.picture(self.radiance_scale))
    }

    /// The [`radiance`](Self::radiance), and the [`report`](Self::report) without its estimate, which takes longest.
    ///
    /// # Errors
    /// A lost device.
    pub fn glance(&self) -> Result<(Picture, Report), RenderError> {
        let sums = self.current_sums()?;
        Ok((sums.picture(self.radiance_scale), self.status(&sums)?))
    }

    /// Samples of each pixel that were left out because they were not finite.
    ///
    /// # Errors
    /// A lost device.
    pub fn non_finite(&self) -> Result<Vec<u64>, RenderError> {
        Ok(self.current_sums()?.non_finite_by_pixel())
    }

    /// As [`Integrator::first_subspaces`].
    ///
    /// # Errors
    /// A lost device.
    pub fn first_subspaces(&mut self) -> Result<Option<Vec<FirstSubspaces>>, RenderError> {
        Ok(self.integrator.first_subspaces(&self.context)?)
    }

    /// What was done so far.
    ///
    /// # Errors
    /// A lost device.
    pub fn report(&self) -> Result<Report, RenderError> {
        let sums = self.current_sums()?;
        Ok(Report { estimated_error: sums.estimated_error(), ..self.status(&sums)? })
    }

    /// As [`FilmSums::estimated_error`].
    ///
    /// # Errors
    /// A lost device.
    pub fn estimated_error(&self) -> Result<Option<f64>, RenderError> {
        Ok(self.current_sums()?.estimated_error())
    }

    fn status(&self, sums: &FilmSums) -> Result<Report, RenderError> {
        let mut report = self.report.clone();
        report.samples = self.samples;
        report.seconds = self.elapsed.as_secs_f64();
        let wavefront = self.integrator.wavefront();
        report.rays = wavefront.ray_counts(&self.context)?;
        report.non_finite = sums.non_finite() + report.rays.non_finite_vertices;
        report.kernels = wavefront.kernel_times();
        report.memory = wavefront.buffers.sizes();
        if self.learning.is_some() {
            let reason = "the render ended before learning did";
            report.choices.push(Choice::new("lessons", report.round_samples.len(), reason));
        }
        Ok(report)
    }

    fn first_hit_layers(&self, hits: &[FirstHitPixel]) -> [Layer; 3] {
        let samples = FIRST_HIT_SAMPLES as f32;
        let layer = |name: &str, channels: [&str; 3], of: fn(&FirstHitPixel) -> [f32; 3]| Layer {
            name: name.into(),
            channels: (0..3)
                .map(|c| {
                    let values = hits.iter().map(|pixel| of(pixel)[c] / samples).collect();
                    (channels[c].to_string(), values)
                })
                .collect(),
        };
        // Depth is the mean over the samples that met a surface; infinite where none did.
        let depth = |pixel: &FirstHitPixel| match pixel.hits {
            0 => f32::INFINITY,
            hits => self.unit.world_length(f64::from(pixel.depth) / f64::from(hits)) as f32,
        };
        let depths = hits.iter().map(depth).collect();
        [
            layer("albedo", ["R", "G", "B"], |pixel| pixel.albedo),
            layer("normal", ["X", "Y", "Z"], |pixel| pixel.normal),
            Layer { name: "depth".into(), channels: vec![("Z".into(), depths)] },
        ]
    }
}

/// What is estimated of a picture that grows, again and again but for a small part of the time.
#[derive(Default)]
pub struct Estimate {
    pub error: Option<f64>,
    /// When it was made last, and how long that took.
    last: Option<(Instant, Duration)>,
}

impl Estimate {
    pub fn is_due(&self) -> bool {
        self.last.is_none_or(|(end, took)| end.elapsed() >= ESTIMATES_APART * took)
    }

    /// # Errors
    /// Those of `make`.
    pub fn renew(
        &mut self,
        make: impl FnOnce() -> Result<Option<f64>, RenderError>,
    ) -> Result<(), RenderError> {
        let start = Instant::now();
        self.error = make()?;
        self.last = Some((Instant::now(), start.elapsed()));
        Ok(())
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
    };
    sums.add_group(pixel.open.map(f64::from), u64::from(pixel.open_groups & 0xff));
    sums
}
