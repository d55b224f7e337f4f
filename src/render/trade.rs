//! What speed costs in accuracy: renders that are looked at while they converge.

mod summary;

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{Budget, Progress, Renderer, Stop};
use crate::error::RenderError;
use crate::film::Picture;
use crate::film::metric::{self, Errors};

pub use summary::{Estimate, Honesty, Summary, Target, Typical, front, summary, time_to, typical, value_at};

/// Samples of the first look, a whole group; then after twice as many, and so on.
const FIRST_LOOK: u32 = 8;

/// How long a render goes on, and where it is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Of rendering, pre-processing included.
    pub time: Option<Duration>,
    /// Samples a pixel.
    pub samples: Option<u32>,
    /// A look at so many samples as well.
    pub equal_samples: u32,
}

impl Plan {
    pub fn budget(&self) -> Budget {
        Budget { time: self.time, samples: self.samples, error: None }
    }

    /// Samples at which a render is looked at, in order, without end where nothing but time ends it.
    pub fn looks(&self) -> impl Iterator<Item = u32> {
        let end = self.samples.unwrap_or(u32::MAX);
        let mut last = 0;
        let (mut next, equal) = (FIRST_LOOK, self.equal_samples);
        std::iter::from_fn(move || {
            if last >= end {
                return None;
            }
            let look = if last < equal && equal < next { equal } else { next };
            if look == next {
                next = next.saturating_mul(2);
            }
            last = look.min(end);
            Some(last)
        })
    }
}

/// A look at a render while it goes on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// A pixel.
    pub samples: u32,
    /// Of rendering alone.
    pub seconds: f64,
    /// Of learning before.
    pub preprocessing_seconds: f64,
    /// As in [`Errors`], the noise of the reference included.
    pub mape: f64,
    pub relmse: f64,
    pub relmse_trimmed: f64,
    /// The picture's mean over the reference's.
    pub mean_ratio: f64,
    /// What the renderer believed its MAPE to be; `None` before two groups of samples.
    pub estimated_error: Option<f64>,
    pub non_finite: u64,
}

impl Point {
    pub fn total_seconds(&self) -> f64 {
        self.seconds + self.preprocessing_seconds
    }

    pub fn errors(&self) -> Errors {
        Errors { mape: self.mape, relmse: self.relmse, relmse_trimmed: self.relmse_trimmed }
    }
}

/// Renders by a plan; looking does not count as time. `None` where `interrupted` said so, which is asked after every round.
///
/// # Errors
/// A lost device, a reference that nothing can be compared with.
pub fn measure(
    renderer: &mut Renderer,
    plan: &Plan,
    reference: &Picture,
    mut interrupted: impl FnMut(&Progress) -> bool,
) -> Result<Option<Vec<Point>>, RenderError> {
    let mut points = Vec::new();
    for samples in plan.looks() {
        // The clock runs in `run` alone.
        renderer.set_budget(Budget { samples: Some(samples), ..plan.budget() });
        let stop = renderer.run(&mut interrupted)?;
        if stop == Stop::Interrupted {
            return Ok(None);
        }
        let (report, picture) = (renderer.report()?, renderer.picture()?);
        let Errors { mape, relmse, relmse_trimmed } = metric::errors(&picture, reference)?;
        points.push(Point {
            samples: report.samples,
            seconds: report.seconds,
            preprocessing_seconds: report.preprocessing_seconds,
            mape,
            relmse,
            relmse_trimmed,
            mean_ratio: metric::mean_ratio(&picture, reference).ratio,
            estimated_error: report.estimated_error,
            non_finite: report.non_finite,
        });
        if stop == Stop::Time {
            break;
        }
    }
    Ok(Some(points))
}
