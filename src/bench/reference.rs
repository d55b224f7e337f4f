//! References: pictures that grow by portions, each with a seed of its own, until they are as exact as asked; and what a
//! second integrator says of them.

use std::time::Duration;

use serde::Serialize;

use crate::film::average::average;
use crate::film::metric::{self, ReferenceNoise, TileTest};
use crate::film::{Picture, Region};
use crate::render::{Budget, Progress, RenderError, Renderer, Stop, TimeLimit};

/// Of the first portion: no other render has it.
const FIRST_SEED: u64 = 1 << 63;
/// Samples a pixel that a portion has at least: two groups, without which its variance is not known.
const LEAST_SAMPLES: u32 = 16;

/// What pictures are compared with, and which of their pixels it has.
#[derive(Clone, Copy, Debug)]
pub struct Reference<'a> {
    pub picture: &'a Picture,
    pub region: Region,
}

/// A reference as far as it has grown.
#[derive(Clone, Debug)]
pub struct AccumulatedReference {
    /// With the layers `variance` and `samples`.
    pub picture: Picture,
    /// Samples a pixel.
    pub samples: u64,
    /// Of rendering, without learning.
    pub seconds: f64,
    pub non_finite: u64,
    pub portions: Vec<Pass>,
}

/// A part of a reference that is independent of the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    pub samples: u64,
    /// Of all pixels and channels.
    pub mean: f64,
}

impl AccumulatedReference {
    /// Adds a portion that takes about `time` to what there is; `None` where `interrupted` said so before the portion was
    /// of any use. The seed is that of the portion's number, from the middle of all seeds on for a `stream` of 0.
    ///
    /// # Errors
    /// A lost device.
    pub fn with_portion(
        before: Option<Self>,
        renderer: &mut Renderer,
        stream: u64,
        time: Duration,
        mut interrupted: impl FnMut(&Progress) -> bool,
    ) -> Result<Option<Self>, RenderError> {
        let number = before.as_ref().map_or(0, |grown| grown.portions.len() as u64);
        renderer.restart(FIRST_SEED + (stream << 32) + number, None)?;
        renderer.set_budget(Budget { time: Some(TimeLimit::Rendering(time)), ..Budget::default() });
        renderer.run(&mut interrupted)?;
        renderer.set_budget(Budget { samples: Some(LEAST_SAMPLES), ..Budget::default() });
        if renderer.run(&mut interrupted)? == Stop::Interrupted && renderer.report()?.samples < LEAST_SAMPLES
        {
            return Ok(None);
        }
        let (report, picture) = (renderer.report()?, renderer.picture()?);
        let samples = u64::from(report.samples);
        let portion = Pass { samples, mean: mean(&picture) };
        Ok(Some(match before {
            None => Self {
                picture,
                samples,
                seconds: report.seconds,
                non_finite: report.non_finite,
                portions: vec![portion],
            },
            Some(mut grown) => {
                grown.picture = average([&grown.picture, &picture], [grown.samples as f64, samples as f64])?;
                grown.samples += samples;
                grown.seconds += report.seconds;
                grown.non_finite += report.non_finite;
                grown.portions.push(portion);
                grown
            }
        }))
    }

    /// What it does to the errors of pictures compared with it.
    ///
    /// # Errors
    /// A picture that nothing can be compared with, such as a black one.
    pub fn noise(&self) -> Result<Option<ReferenceNoise>, RenderError> {
        Ok(metric::reference_noise(&self.picture)?)
    }

    /// Mean of all pixels, and its standard error by how portions scatter: pixels may share light paths, portions do not.
    fn mean(&self) -> (f64, Option<f64>) {
        let total: f64 = self.portions.iter().map(|portion| portion.samples as f64).sum();
        let share = |portion: &Pass| portion.samples as f64 / total;
        let mean: f64 = self.portions.iter().map(|portion| share(portion) * portion.mean).sum();
        let count = self.portions.len() as f64;
        let squares: f64 =
            self.portions.iter().map(|portion| (share(portion) * (portion.mean - mean)).powi(2)).sum();
        (mean, (count > 1.0).then(|| (squares * count / (count - 1.0)).sqrt()))
    }
}

/// What a second integrator says of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The second's mean over the reference's, and its standard error by how the portions of both scatter.
    pub mean_ratio: f64,
    pub mean_ratio_error: Option<f64>,
    /// By the variance of pixels, taken as independent: with light paths that pixels share, a few standard errors more
    /// than chance allows are none.
    pub tiles: Option<TileTest>,
}

impl Check {
    /// Standard errors between the two means.
    pub fn z(&self) -> Option<f64> {
        self.mean_ratio_error.map(|error| (self.mean_ratio - 1.0) / error)
    }
}

/// Compares a reference with one that another integrator made.
///
/// # Errors
/// Pictures that cannot be compared.
pub fn check(reference: &AccumulatedReference, other: &AccumulatedReference) -> Result<Check, RenderError> {
    let ((a, error_a), (b, error_b)) = (other.mean(), reference.mean());
    let relative = |error: Option<f64>, mean: f64| error.map(|error| error / mean);
    let error = relative(error_a, a).zip(relative(error_b, b)).map(|(a, b)| a.hypot(b));
    Ok(Check {
        mean_ratio: a / b,
        mean_ratio_error: error.map(|error| error * a / b),
        tiles: metric::tile_test(&other.picture, &reference.picture)?,
    })
}

fn mean(picture: &Picture) -> f64 {
    let values = picture.rgb.as_flattened();
    values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
}
