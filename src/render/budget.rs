//! When a render ends.

use std::time::{Duration, Instant};

use serde::Serialize;

/// When to stop: the first limit that is met.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Samples per pixel.
    pub samples: Option<u32>,
    pub time: Option<TimeLimit>,
    /// Estimated error of the picture, see [`FilmSums::estimated_error`](crate::film::sums::FilmSums::estimated_error).
    pub error: Option<f64>,
}

/// A limit of time, and what counts. Loading and shader compilation never do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeLimit {
    /// Learning before the first sample, and rendering.
    Total(Duration),
    /// Rendering alone.
    Rendering(Duration),
}

impl TimeLimit {
    pub fn duration(self) -> Duration {
        match self {
            Self::Total(time) | Self::Rendering(time) => time,
        }
    }

    /// The same, after some of it is spent.
    pub fn without(self, spent: Duration) -> Self {
        match self {
            Self::Total(time) => Self::Total(time.saturating_sub(spent)),
            Self::Rendering(time) => Self::Rendering(time.saturating_sub(spent)),
        }
    }

    /// Time for rendering where learning took so long; none where that was too long.
    pub fn for_rendering(self, learning: Duration) -> Duration {
        match self {
            Self::Total(time) => time.saturating_sub(learning),
            Self::Rendering(time) => time,
        }
    }
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

/// Where a render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    pub samples: u32,
    pub elapsed: Duration,
    /// Of a moment ago, now and then: it takes no more than a small part of the time.
    pub estimated_error: Option<f64>,
}

/// Time between two estimates of the error, in times that one takes: of the picture, and of the denoised one.
const ESTIMATES_APART: u32 = 20;
const DENOISED_APART: u32 = 10;

/// What is estimated of a picture that grows, again and again but for a small part of the time.
pub struct Estimate {
    pub error: Option<f64>,
    /// When it was made last, and how long that took.
    last: Option<(Instant, Duration)>,
    /// Time between two, in times that one takes.
    apart: u32,
}

impl Default for Estimate {
    fn default() -> Self {
        Self { error: None, last: None, apart: ESTIMATES_APART }
    }
}

impl Estimate {
    /// Of the denoised picture, which takes longer.
    pub fn denoised() -> Self {
        Self { apart: DENOISED_APART, ..Self::default() }
    }

    pub fn is_due(&self) -> bool {
        self.last.is_none_or(|(end, took)| end.elapsed() >= self.apart * took)
    }

    /// # Errors
    /// Those of `make`.
    pub fn renew<E>(&mut self, make: impl FnOnce() -> Result<Option<f64>, E>) -> Result<(), E> {
        let start = Instant::now();
        self.error = make()?;
        self.last = Some((Instant::now(), start.elapsed()));
        Ok(())
    }
}
