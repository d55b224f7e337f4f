//! The budget loop: rounds of samples until the first limit of samples, time or error is met.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::budget::{Budget, Estimate, Progress, Stop};
use super::layers::{FIRST_HIT_SAMPLES, first_hit_layers, pixel_sums};
use super::{RenderError, RenderOptions, Report};
use crate::accel::UnitSpace;
use crate::device::layout::{FirstHitPixel, SAMPLES_A_GROUP};
use crate::device::{self, Context};
use crate::film::sums::{FilmSums, SAMPLES_A_FLUSH};
use crate::film::{Picture, Region};
use crate::integrator::{Choice, FirstSubspaces, Integrator, Strategy, SubmissionLimit};
use crate::scene;
use crate::subspace::Model;
use crate::training::OnlineTraining;

/// Below this many samples per pixel an error estimate is not trusted to stop a render: light that has not been found
/// is not in it.
const MIN_SAMPLES_FOR_ERROR: u32 = 64;
/// A round ends after about this time, so that progress shows and an interrupt is soon heard.
const ROUND: Duration = Duration::from_millis(300);

/// What learning before the first sample took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LearningTime {
    /// Of tracing on the device.
    pub tracing: Duration,
    /// All of it.
    pub total: Duration,
}

/// A scene made ready for one device: renders can be continued and looked at.
pub struct Renderer {
    pub(super) context: Context,
    /// What `Method::SpcBpt` connects by.
    pub model: Option<Arc<Model>>,
    pub(super) integrator: Box<dyn Integrator>,
    pub(super) options: RenderOptions,
    pub(super) scene_hash: u64,
    pub(super) sums: FilmSums,
    pub(super) learning: Option<OnlineTraining>,
    /// Samples before which no other model is taken.
    pub(super) next_round: u32,
    /// Once they were asked for.
    pub(super) first_hits: Option<Vec<FirstHitPixel>>,
    pub(super) samples: u32,
    pub(super) elapsed: Duration,
    pub(super) learning_time: LearningTime,
    pub(super) radiance_scale: f64,
    pub(super) unit: UnitSpace,
    pub(super) report: Report,
}

impl Renderer {
    /// Starts again with another seed, and with one strategy of a bidirectional method alone (or all of them). Learning
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

    /// Looks from another camera from now on, at a picture of so many pixels (no more than at first), and starts again.
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
    pub fn limit_submissions(&mut self, limit: SubmissionLimit) {
        self.integrator.wavefront_mut().limit_submissions(limit);
    }

    /// Name and buffer of all that it has on the device, the scene included.
    pub fn buffers(&self) -> impl Iterator<Item = (&String, &wgpu::Buffer)> {
        self.integrator.wavefront().buffers.iter()
    }

    /// Of the scene's content.
    pub fn scene_hash(&self) -> u64 {
        self.scene_hash
    }

    /// Samples per pixel so far.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Time of rendering so far.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }

    /// Time of learning before the first sample.
    pub fn learning_time(&self) -> LearningTime {
        self.learning_time
    }

    /// Samples that belong together, see [`Integrator::samples_at_once`].
    pub fn samples_at_once(&self) -> u32 {
        self.integrator.samples_at_once()
    }

    /// Renders `most` samples or a few less, so that pictures never depend on how a render is cut: whole iterations, but
    /// for the end of the budget. Returns how many.
    ///
    /// # Errors
    /// A lost device; [`DeviceError::Abandoned`], after which only starting again helps.
    pub fn step(&mut self, most: u32) -> Result<u32, RenderError> {
        let start = Instant::now();
        let at_once = self.integrator.samples_at_once();
        // Models change between groups.
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
            if let Some(limit) = budget.time {
                let time = limit.for_rendering(self.learning_time.total);
                let left = time.as_secs_f64() - self.elapsed.as_secs_f64();
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
            picture.layers.extend(first_hit_layers(&hits, &self.unit));
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
        report.pretracing_seconds = self.learning_time.tracing.as_secs_f64();
        report.preprocessing_seconds = self.learning_time.total.as_secs_f64();
        let wavefront = self.integrator.wavefront();
        report.rays = wavefront.ray_counts(&self.context)?;
        report.non_finite = sums.non_finite() + report.rays.non_finite_vertices;
        report.kernels = wavefront.kernel_times();
        report.compiled = wavefront.compiled().to_vec();
        report.memory = wavefront.buffers.sizes();
        if self.learning.is_some() {
            let reason = "the render ended before learning did";
            report.choices.push(Choice::new("rounds", report.round_samples.len(), reason));
        }
        Ok(report)
    }
}
