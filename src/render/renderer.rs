//! The budget loop: rounds of samples until the first limit of samples, time or error is met.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::budget::{Budget, Estimate, Progress, Stop};
use super::halves::{HalvesInProgress, NoHalves};
use super::layers::{FIRST_HIT_SAMPLES, first_hit_layers};
use super::seen::Seen;
use super::{RenderError, RenderOptions, Report};
use crate::accel::UnitSpace;
use crate::device::layout::{FilmPixel, FirstHitPixel, SAMPLES_A_GROUP};
use crate::device::{self, Context, DeviceError};
use crate::film::halves::{HalfSums, Halves};
use crate::film::state::{Group, group_of, open_group_of, pixel_sums};
use crate::film::sums::{FilmSums, SAMPLES_A_FLUSH};
use crate::film::{Picture, Region};
use crate::integrator::{Choice, FirstSubspaces, Integrator, RayCounts, Strategy, SubmissionLimit};
use crate::scene;
use crate::subspace::Model;
use crate::training::OnlineTraining;

/// Below this many samples per pixel an error estimate is not trusted to stop a render: light that has not been found
/// is not in it.
pub const MIN_SAMPLES_FOR_ERROR: u32 = 64;
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
    pub(super) seen: Option<Seen>,
    /// The sample that the next round begins with, and the one that the render began with.
    pub(super) samples: u32,
    pub(super) first: u32,
    /// Of the block that the render began in, where that was not with the block.
    pub(super) groups: BTreeMap<u32, Group>,
    /// Where the options want them and they can be had.
    pub(super) halves: Option<HalvesInProgress>,
    /// What was done before the render went on from a checkpoint.
    pub(super) rays_before: RayCounts,
    pub(super) elapsed: Duration,
    /// The longest time of a sample of the last group, where a picture has more pixels than the queues hold.
    pub(super) longest_sample: Duration,
    /// The last round was left unfinished.
    pub(super) was_cut: bool,
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
        (self.samples, self.first) = (0, 0);
        self.groups.clear();
        self.halves = HalvesInProgress::begin(&self.options, self.sums.pixels.len());
        self.rays_before = RayCounts::default();
        if let Some(seen) = &mut self.seen {
            seen.forget();
        }
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

    /// See [`Integrator::samples_at_once`].
    pub fn samples_at_once(&self) -> u32 {
        self.integrator.samples_at_once()
    }

    /// Renders `most` samples or a few less: what the host takes over is taken over whole, and queues are filled. Returns how
    /// many. Pictures never depend on how a render is cut.
    ///
    /// # Errors
    /// A lost device; [`DeviceError::Abandoned`], after which only starting again helps.
    pub fn step(&mut self, most: u32) -> Result<u32, RenderError> {
        let start = Instant::now();
        let at_once = self.integrator.samples_at_once();
        // Models change between groups.
        let is_apart = self.is_apart();
        let by_groups = is_apart || self.halves.is_some();
        let unit = if self.learning.is_some() || by_groups { SAMPLES_A_GROUP } else { SAMPLES_A_FLUSH };
        let samples = most.min(unit - self.samples % unit);
        let rest = (self.samples + samples) % at_once;
        let samples = if rest < samples { samples - rest } else { samples };
        let samples = self.trace(samples)?;
        self.context.wait()?;
        self.integrator.wavefront_mut().collect_times(&self.context)?;
        self.samples += samples;
        if samples > 0 && by_groups && self.samples.is_multiple_of(SAMPLES_A_GROUP) {
            self.take_group(is_apart)?;
        }
        self.poll_training()?;
        if samples > 0 && !is_apart && self.samples.is_multiple_of(SAMPLES_A_FLUSH) {
            self.flush()?;
        }
        self.elapsed += start.elapsed();
        Ok(samples)
    }

    /// Takes the group over that has just ended.
    fn take_group(&mut self, is_apart: bool) -> Result<(), RenderError> {
        let mut group = Vec::new();
        self.integrator.wavefront().take_film(&self.context, |_, page| group.extend(group_of(&page)))?;
        let index = self.samples / SAMPLES_A_GROUP - 1;
        if let Some(halves) = &mut self.halves {
            halves.add(index, &group, is_apart);
        }
        if is_apart {
            self.groups.insert(index, group);
        }
        Ok(())
    }

    /// Its samples are kept in halves.
    pub fn keeps_halves(&self) -> bool {
        self.halves.is_some()
    }

    /// The halves of the picture so far.
    ///
    /// # Errors
    /// A lost device.
    pub fn halves(&self) -> Result<Result<Halves, NoHalves>, RenderError> {
        let Some(halves) = &self.halves else { return Ok(Err(NoHalves::NotKept)) };
        if self.samples - self.first <= SAMPLES_A_GROUP {
            return Ok(Err(NoHalves::OneGroup));
        }
        let pictures =
            |first: &HalfSums| self.look_at_sums(|sums| Ok(first.pictures(sums, self.radiance_scale)));
        let open = self.samples / SAMPLES_A_GROUP;
        if self.samples.is_multiple_of(SAMPLES_A_GROUP) || !HalfSums::takes(open) {
            return pictures(&halves.first);
        }
        let mut first = halves.first.clone();
        first.add(&open_group_of(&self.integrator.wavefront().film(&self.context)?));
        pictures(&first)
    }

    /// Takes the device's sums over, and those of its groups that were taken one by one.
    pub(super) fn flush(&mut self) -> Result<(), RenderError> {
        if let Some(halves) = &mut self.halves {
            halves.end_block(&mut self.sums);
            return Ok(());
        }
        let sums = &mut self.sums;
        let visit = |first, page: Vec<FilmPixel>| sums.add_from(first, page.par_iter().map(pixel_sums));
        Ok(self.integrator.wavefront().take_film(&self.context, visit)?)
    }

    /// Traces samples into the film on the device. Returns how many: fewer, and `was_cut` is set, where the deadline or an
    /// interrupt ended a round; what was unfinished is dropped.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    fn trace(&mut self, samples: u32) -> Result<u32, RenderError> {
        let pixels = self.options.view.region().pixels();
        let wavefront = self.integrator.wavefront();
        if wavefront.shares_device() {
            self.integrator.render(&self.context, self.samples, samples)?;
            return Ok(samples);
        }
        if pixels <= wavefront.slice {
            // Each batch has all pixels, so whatever has reached the film is whole.
            self.integrator.wavefront_mut().accumulated = 0;
            let rendered = self.integrator.render(&self.context, self.samples, samples);
            return self.finish_or_drop(rendered, samples, None);
        }
        let grace = self.context.grace();
        let is_long = |time: Duration| grace.is_some_and(|grace| 3 * time > grace);
        for done in 0..samples {
            let start = Instant::now();
            let film = match (self.samples + done).is_multiple_of(SAMPLES_A_FLUSH) {
                true => Some(Vec::new()),
                false if is_long(self.longest_sample) => {
                    Some(self.integrator.wavefront().film(&self.context)?)
                }
                // Samples take no longer than the longest of the group before them: this one will not be cut.
                false => None,
            };
            self.integrator.wavefront_mut().hold(film.is_none());
            let rendered = self.integrator.render(&self.context, self.samples + done, 1);
            self.integrator.wavefront_mut().hold(false);
            let finished = self.finish_or_drop(rendered, 1, film.as_deref())?;
            if finished == 0 {
                return Ok(done);
            }
            self.context.wait()?;
            // Those that begin a group may trace the light paths of all of it.
            let begins = (self.samples + done).is_multiple_of(SAMPLES_A_GROUP);
            self.longest_sample =
                start.elapsed().max(if begins { Duration::ZERO } else { self.longest_sample });
        }
        Ok(samples)
    }

    /// Of samples that were to be `rendered` those that are whole are kept, where they were cut; where parts of them may have
    /// reached the film, none: it becomes what it was, `film`.
    fn finish_or_drop(
        &mut self,
        rendered: Result<(), DeviceError>,
        samples: u32,
        film: Option<&[FilmPixel]>,
    ) -> Result<u32, RenderError> {
        match rendered {
            Err(DeviceError::Abandoned) => {
                self.was_cut = true;
                let pixels = u64::from(self.options.view.region().pixels());
                let wavefront = self.integrator.wavefront_mut();
                wavefront.drop_unfinished(&self.context, film)?;
                Ok(if film.is_some() { 0 } else { (wavefront.accumulated / pixels) as u32 })
            }
            rendered => rendered.map(|()| samples).map_err(RenderError::Device),
        }
    }

    /// Renders to another budget from now on.
    pub fn set_budget(&mut self, budget: Budget) {
        self.options.budget = budget;
    }

    /// Ends for a reason that is none of its budget.
    pub fn end(&mut self, stop: Stop) {
        self.report.stop = stop;
    }

    /// Renders until a limit of the budget is met or `interrupted` says so; it is asked after every round. With a context
    /// that [can be interrupted](Context::interrupted_by), a round that would go on for longer than its grace after that, or after
    /// the end of the time, is left unfinished, and its unfinished samples are dropped. With others the last round is finished,
    /// and there is one sample at least.
    ///
    /// # Errors
    /// A lost device; no sample that was finished before the time was over, or before it was interrupted.
    pub fn run(&mut self, interrupted: impl FnMut(&Progress) -> bool) -> Result<Stop, RenderError> {
        let time = self.options.budget.time.map(|limit| limit.for_rendering(self.learning_time.total));
        let left = time.map(|time| time.saturating_sub(self.elapsed));
        self.integrator.wavefront_mut().set_deadline(left.map(|left| Instant::now() + left));
        let stop = self.run_rounds(time, interrupted);
        self.integrator.wavefront_mut().set_deadline(None);
        let stop = stop?;
        if self.samples == self.first && self.was_cut {
            return Err(match stop {
                Stop::Interrupted => RenderError::InterruptedAtOnce,
                _ => RenderError::NoSampleInTime,
            });
        }
        self.report.stop = stop;
        Ok(stop)
    }

    /// As [`run`](Self::run), until a limit is met. `time`: for rendering.
    fn run_rounds(
        &mut self,
        time: Option<Duration>,
        mut interrupted: impl FnMut(&Progress) -> bool,
    ) -> Result<Stop, RenderError> {
        let start = Instant::now();
        let before = self.elapsed;
        let budget = self.options.budget;
        self.was_cut = false;
        let at_once = self.integrator.samples_at_once();
        let mut round = at_once;
        let mut estimate = Estimate::default();
        loop {
            if budget.samples.is_some_and(|samples| self.samples >= samples) {
                return Ok(Stop::Samples);
            }
            let to_end = budget.samples.map_or(u32::MAX, |samples| samples - self.samples);
            let round_start = Instant::now();
            let samples = self.step(round.min(to_end))?;
            if estimate.is_due() {
                estimate.renew(|| self.estimated_error())?;
            }
            let error = estimate.error;
            self.elapsed = before + start.elapsed();
            let samples_here = self.samples - self.first;
            let progress = Progress { samples: samples_here, elapsed: self.elapsed, estimated_error: error };
            if interrupted(&progress) || (self.was_cut && self.context.interrupted()) {
                return Ok(Stop::Interrupted);
            }
            if self.was_cut {
                return Ok(Stop::Time);
            }
            let reached = |wanted: f64| error.is_some_and(|error| error <= wanted);
            if self.samples >= MIN_SAMPLES_FOR_ERROR && budget.error.is_some_and(reached) {
                return Ok(Stop::Error);
            }
            let a_sample = round_start.elapsed().as_secs_f64() / f64::from(samples);
            let next = (ROUND.as_secs_f64() / a_sample) as u32;
            round = next.clamp(at_once, round.max(at_once) * 4);
            if let Some(time) = time {
                let left = time.as_secs_f64() - self.elapsed.as_secs_f64();
                // Half a sample too many or too few; but none that would be cut.
                let is_cut = |grace: Duration| left + grace.as_secs_f64() < a_sample;
                if left <= 0.5 * a_sample || self.context.grace().is_some_and(is_cut) {
                    return Ok(Stop::Time);
                }
                round = round.min(((left / a_sample) as u32).max(1));
            }
        }
    }

    /// Looks at the host's sums together with what the device has not handed over yet. They are large: there is a copy of
    /// them only where there is something to add.
    pub(super) fn look_at_sums<T>(&self, look: impl FnOnce(&FilmSums) -> T) -> Result<T, RenderError> {
        let all_are_here = self.groups.is_empty() && self.samples.is_multiple_of(SAMPLES_A_FLUSH);
        Ok(if all_are_here { look(&self.sums) } else { look(&self.film_state()?.into_sums()) })
    }

    /// The picture so far, with its layers.
    ///
    /// # Errors
    /// A lost device.
    pub fn picture(&mut self) -> Result<Picture, RenderError> {
        // Layers are part of what is saved after an interrupt.
        self.integrator.wavefront_mut().hold(true);
        let picture = self.with_layers();
        self.integrator.wavefront_mut().hold(false);
        picture
    }

    fn with_layers(&mut self) -> Result<Picture, RenderError> {
        let mut picture = self.radiance()?;
        if self.options.first_hit_layers {
            let hits = match self.first_hits.take() {
                Some(hits) => hits,
                None => self.integrator.wavefront_mut().first_hits(&self.context, FIRST_HIT_SAMPLES)?,
            };
            picture.layers.extend(first_hit_layers(&hits, &self.unit));
            self.first_hits = Some(hits);
        }
        if let Some(seen) = &mut self.seen {
            seen.add_to(&mut picture, self.samples, self.integrator.wavefront_mut(), &self.context)?;
        }
        Ok(picture)
    }

    /// As [`picture`](Self::picture), with nothing but radiance and what the samples say of it.
    ///
    /// # Errors
    /// A lost device.
    pub fn radiance(&self) -> Result<Picture, RenderError> {
        self.look_at_sums(|sums| sums.picture(self.radiance_scale))
    }

    /// The [`radiance`](Self::radiance), and the [`report`](Self::report) without its estimate, which takes longest.
    ///
    /// # Errors
    /// A lost device.
    pub fn glance(&self) -> Result<(Picture, Report), RenderError> {
        let (picture, non_finite) =
            self.look_at_sums(|sums| (sums.picture(self.radiance_scale), sums.non_finite()))?;
        Ok((picture, self.status(non_finite)?))
    }

    /// Samples of each pixel that were left out because they were not finite.
    ///
    /// # Errors
    /// A lost device.
    pub fn non_finite(&self) -> Result<Vec<u64>, RenderError> {
        self.look_at_sums(FilmSums::non_finite_by_pixel)
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
        let (error, non_finite) = self.look_at_sums(|sums| (sums.estimated_error(), sums.non_finite()))?;
        Ok(Report { estimated_error: error, ..self.status(non_finite)? })
    }

    /// As [`FilmSums::estimated_error`].
    ///
    /// # Errors
    /// A lost device.
    pub fn estimated_error(&self) -> Result<Option<f64>, RenderError> {
        self.look_at_sums(FilmSums::estimated_error)
    }

    /// The report but for its estimate. `non_finite`: samples that were left out.
    pub(super) fn status(&self, non_finite: u64) -> Result<Report, RenderError> {
        let mut report = self.report.clone();
        report.samples = self.samples - self.first;
        report.seconds = self.elapsed.as_secs_f64();
        report.pretracing_seconds = self.learning_time.tracing.as_secs_f64();
        report.preprocessing_seconds = self.learning_time.total.as_secs_f64();
        let wavefront = self.integrator.wavefront();
        report.rays = wavefront.ray_counts(&self.context)? + self.rays_before;
        report.non_finite = non_finite + report.rays.non_finite_vertices;
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
