//! What speed costs in accuracy: renders that are compared with a reference while they converge.

mod summary;

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::reference::Reference;
use super::speed::NormalisedClock;
use crate::film::denoise::Denoiser;
use crate::film::metric::{self, Errors};
use crate::film::{FilmError, Picture};
use crate::math::curve;
use crate::render::{Budget, Progress, RenderError, Renderer, Report, Stop, TimeLimit};

pub use summary::{
    ErrorCalibration, Estimate, Summary, Target, Typical, front, summary, time_to, typical, value_at,
};

/// Samples of the first checkpoint, a whole group; then after twice as many, and so on.
const FIRST_CHECKPOINT: u32 = 8;

/// How long a render goes on, and where its checkpoints are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Plan {
    /// Of rendering, pre-processing included.
    pub time: Option<Duration>,
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// A checkpoint at so many samples as well.
    pub equal_samples: u32,
    pub goal: Option<Goal>,
    /// [`Checkpoint::mape`] is [the paper's](metric::mape_paper), and times are of rendering alone.
    pub as_paper: bool,
}

/// What a render goes on to that its time is not long enough for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Goal {
    /// MAPE to be met.
    pub error: f64,
    /// Where it is not met in time but may be soon, a render goes on until it is, for no longer than this.
    pub longest: Duration,
}

impl Goal {
    /// Whether to go on, as far as the checkpoints so far tell. Beyond its end a curve is continued by a factor: a
    /// render that would not come so far has no need to begin.
    pub fn is_near(&self, points: &[Checkpoint]) -> bool {
        let pairs: Vec<[f64; 2]> = points.iter().map(|point| [point.total_seconds(), point.mape]).collect();
        let far = points.last().is_some_and(|point| point.mape > self.error);
        let within = |seconds: f64| seconds <= curve::REACH * self.longest.as_secs_f64();
        far && curve::continued(&pairs, self.error).is_some_and(within)
    }
}

impl Plan {
    pub fn budget(&self) -> Budget {
        Budget { time: self.time.map(TimeLimit::Total), samples: self.samples, error: None }
    }

    /// The same where learning has taken so much time, which is part of all limits from here on.
    fn after_learning(&self, learning: Duration) -> Self {
        let learning = if self.as_paper { learning } else { Duration::ZERO };
        Self {
            time: self.time.map(|time| time + learning),
            goal: self.goal.map(|goal| Goal { longest: goal.longest + learning, ..goal }),
            ..*self
        }
    }

    /// The next checkpoint of a render that goes on to its goal: there are more of them, so that it ends soon after,
    /// the same for all renders.
    fn checkpoint_after(&self, samples: u32) -> Option<u32> {
        let end = self.samples.unwrap_or(u32::MAX);
        let steps = (1..)
            .map(|quarters| (f64::from(FIRST_CHECKPOINT) * 2f64.powf(0.25 * f64::from(quarters))) as u32);
        let next = steps
            .map(|step| step.next_multiple_of(FIRST_CHECKPOINT))
            .find(|&checkpoint| checkpoint > samples)?;
        let next = if samples < self.equal_samples { next.min(self.equal_samples) } else { next };
        (samples < end).then_some(next.min(end))
    }

    /// Samples per pixel at the checkpoints, in order, without end where nothing but time ends it.
    pub fn checkpoints(&self) -> impl Iterator<Item = u32> {
        let end = self.samples.unwrap_or(u32::MAX);
        let mut last = 0;
        let (mut next, equal) = (FIRST_CHECKPOINT, self.equal_samples);
        std::iter::from_fn(move || {
            if last >= end {
                return None;
            }
            let checkpoint = if last < equal && equal < next { equal } else { next };
            if checkpoint == next {
                next = next.saturating_mul(2);
            }
            last = checkpoint.min(end);
            Some(last)
        })
    }
}

/// A render's error while it goes on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Per pixel.
    pub samples: u32,
    /// Of rendering alone.
    pub seconds: f64,
    /// Of learning before.
    pub preprocessing_seconds: f64,
    /// The same two in units of work that the device could have done in them, see [`NormalisedClock`].
    pub work: f64,
    pub preprocessing_work: f64,
    /// As in [`Errors`], the noise of the reference included; but see [`Plan::as_paper`].
    pub mape: f64,
    pub relmse: f64,
    pub relmse_trimmed: f64,
    /// The picture's mean over the reference's.
    pub mean_ratio: f64,
    /// What a viewer sees of it: mean LDR-FLIP at the exposure that suits the reference. `None` of pictures that are compared
    /// at some pixels only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flip: Option<f64>,
    /// The renderer's own estimate of its MAPE; `None` before two groups of samples, and of denoised pictures.
    pub estimated_error: Option<f64>,
    pub non_finite: u64,
}

impl Checkpoint {
    /// Compares a render's picture with a reference; `work` is that of rendering and of learning before.
    ///
    /// # Errors
    /// A reference that nothing can be compared with.
    pub fn new(
        report: &Report,
        picture: &Picture,
        reference: &Picture,
        [work, preprocessing_work]: [f64; 2],
    ) -> Result<Self, FilmError> {
        let Errors { mape, relmse, relmse_trimmed } = metric::errors(picture, reference)?;
        Ok(Self {
            samples: report.samples,
            seconds: report.seconds,
            preprocessing_seconds: report.preprocessing_seconds,
            work,
            preprocessing_work,
            mape,
            relmse,
            relmse_trimmed,
            mean_ratio: metric::mean_ratio(picture, reference).ratio,
            flip: None,
            estimated_error: report.estimated_error,
            non_finite: report.non_finite,
        })
    }

    /// The names of [`row`](Self::row).
    pub const COLUMNS: &str = "samples,seconds,preprocessing_seconds,total_seconds,mape,relmse,relmse_trimmed,mean_ratio,\
                               flip,estimated_mape,non_finite";

    /// As a line of a CSV file.
    pub fn row(&self) -> String {
        let Self {
            samples, seconds, preprocessing_seconds, mape, relmse, relmse_trimmed, mean_ratio, ..
        } = self;
        let flip = self.flip.map_or(String::new(), |flip| flip.to_string());
        let total = self.total_seconds();
        let estimate = self.estimated_error.map_or(String::new(), |error| error.to_string());
        format!(
            "{samples},{seconds},{preprocessing_seconds},{total},{mape},{relmse},{relmse_trimmed},{mean_ratio},{flip},{estimate},{}",
            self.non_finite
        )
    }

    pub fn total_seconds(&self) -> f64 {
        self.seconds + self.preprocessing_seconds
    }

    pub fn total_work(&self) -> f64 {
        self.work + self.preprocessing_work
    }

    /// With the times of a device that takes `seconds_per_unit` for a unit of work.
    pub fn at_speed(&self, seconds_per_unit: f64) -> Self {
        Self {
            seconds: seconds_per_unit * self.work,
            preprocessing_seconds: seconds_per_unit * self.preprocessing_work,
            ..*self
        }
    }

    pub fn errors(&self) -> Errors {
        Errors { mape: self.mape, relmse: self.relmse, relmse_trimmed: self.relmse_trimmed }
    }
}

/// Renders by a plan; comparing does not count as time, nor does denoising, where there is a `denoiser`. `clock` began before
/// anything was learnt. `None` where `interrupted` said so, which is asked after every round.
///
/// # Errors
/// A lost device, a reference that nothing can be compared with, a denoiser that refuses.
pub fn measure(
    renderer: &mut Renderer,
    plan: &Plan,
    reference: &Reference<'_>,
    clock: &mut NormalisedClock,
    mut denoiser: Option<&mut Denoiser>,
    mut interrupted: impl FnMut(&Progress) -> bool,
) -> Result<Option<Vec<Checkpoint>>, RenderError> {
    let plan = plan.after_learning(renderer.learning_time().total);
    let before = renderer.learning_time().total.as_secs_f64();
    let preprocessing_work = clock.work(before)?;
    let mut points: Vec<Checkpoint> = Vec::new();
    let mut samples_ahead = plan.checkpoints();
    // Of a render that goes on to its goal.
    let mut goal: Option<Goal> = None;
    loop {
        let next = match (goal, points.last()) {
            (Some(_), Some(last)) => plan.checkpoint_after(last.samples),
            _ => samples_ahead.next(),
        };
        let Some(samples) = next else { break };
        let time = goal.map(|goal| goal.longest).or(plan.time);
        // The clock runs in `run` alone.
        renderer.set_budget(Budget { samples: Some(samples), time: time.map(TimeLimit::Total), error: None });
        let (stop, work) = loop {
            let mut given_up = false;
            let stop = renderer.run(|progress| {
                given_up = interrupted(progress);
                given_up || clock.is_due(before + progress.elapsed.as_secs_f64())
            })?;
            if given_up {
                return Ok(None);
            }
            let seconds = before + renderer.elapsed().as_secs_f64();
            let work = clock.work(seconds)? - preprocessing_work;
            let stop = match time {
                // An interrupted run has not compared the time with its limit.
                Some(time) if stop == Stop::Interrupted && seconds >= time.as_secs_f64() => Stop::Time,
                _ => stop,
            };
            if stop != Stop::Interrupted {
                break (stop, work);
            }
        };
        let mut report = renderer.report()?;
        let picture = match denoiser.as_deref_mut() {
            Some(denoiser) => {
                report.estimated_error = None;
                let picture = renderer.picture()?;
                Picture::new(picture.width, picture.height, denoiser.denoise(&picture)?)
            }
            None => renderer.radiance()?,
        };
        let picture = picture.part(&reference.region);
        let point = Checkpoint::new(&report, &picture, reference.picture, [work, preprocessing_work])?;
        let flip = (reference.region.stride == 1).then(|| metric::flip(&picture, reference.picture));
        let mape = if plan.as_paper { metric::mape_paper(&picture, reference.picture) } else { point.mape };
        points.push(Checkpoint { flip, mape, ..point });
        match goal {
            Some(goal) if stop == Stop::Time || points.last().is_some_and(|last| last.mape <= goal.error) => {
                break;
            }
            None if stop == Stop::Time => {
                goal = plan.goal.filter(|goal| goal.is_near(&points));
                if goal.is_none() {
                    break;
                }
            }
            _ => {}
        }
    }
    Ok(Some(points))
}
