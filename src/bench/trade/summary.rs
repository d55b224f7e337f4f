//! What the renders of an integrator have in common: medians with intervals, by seeds.

use serde::Serialize;

use super::Checkpoint;
use crate::bench::efficiency::{self, Ratio, Run};
use crate::film::metric::ReferenceNoise;
use crate::integrator::RayCounts;
use crate::math::curve::{self, Crossing};
use crate::math::statistics::{median, median_interval};

/// A median over renders with different seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    pub value: f64,
    /// 95 % confidence; `None` for a single render. Infinite where some never came so far.
    pub interval: Option<[f64; 2]>,
    /// Some of it lies beyond what was measured.
    pub extrapolated: bool,
}

impl Estimate {
    fn of(values: &[f64], extrapolated: bool) -> Self {
        Self { value: median(values), interval: median_interval(values), extrapolated }
    }
}

/// When an error is met for good.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Seconds, pre-processing included; infinite where half of the renders do not come so far.
    pub seconds: Estimate,
    /// Without pre-processing.
    pub rendering_seconds: Estimate,
    /// Samples per pixel.
    pub samples: Estimate,
    /// Renders that had met it at their first checkpoint already: it is met sooner than said.
    pub at_once: usize,
    /// Renders that come so far, at least by extrapolation.
    pub met: usize,
    /// Seconds of the first integrator over these, render by render; `None` where one of the two is not met.
    pub speedup: Option<Ratio>,
    pub rendering_speedup: Option<Ratio>,
}

/// The renderer's own estimate of its error beside the error that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorCalibration {
    /// Estimated over measured error: below 1 the picture is worse than its estimate.
    pub median: f64,
    /// Furthest from 1, as a factor, and the samples at which that was.
    pub worst: f64,
    pub worst_samples: u32,
    /// How many it is known at.
    pub checkpoints: usize,
}

/// The median of all renders at a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Typical {
    pub samples: f64,
    pub seconds: f64,
    pub preprocessing_seconds: f64,
    pub total_seconds: f64,
    pub mape: f64,
    pub relmse: f64,
    pub relmse_trimmed: f64,
    /// Estimated over measured MAPE; `None` before two groups of samples.
    pub estimated_over_measured: Option<f64>,
}

/// The figures of an integrator in all tables.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub learning_seconds: f64,
    pub target: Target,
    /// MAPE after each of the times that were asked for, pre-processing included.
    pub expected: Vec<Option<Estimate>>,
    /// At the same number of samples for all: MAPE, relMSE and seconds with pre-processing.
    pub equal_mape: Option<Estimate>,
    pub equal_relmse: Option<Estimate>,
    pub equal_seconds: Option<Estimate>,
    /// At the ends of the renders: 1 / (relMSE x time), by the time of rendering alone and by all time.
    pub efficiency: efficiency::Summary,
    pub efficiency_with_learning: efficiency::Summary,
    pub calibration: Option<ErrorCalibration>,
    pub curve: Vec<Typical>,
}

/// Summarises renders, each with the render of the first integrator in the same round. There is at least one.
pub fn summary(
    runs: &[&[Checkpoint]],
    first: &[&[Checkpoint]],
    noise: Option<ReferenceNoise>,
    target: f64,
    times: &[f64],
    equal_samples: u32,
) -> Summary {
    let equal = |of: fn(&Checkpoint) -> f64| {
        all(runs, |points| value_at(points, |p| f64::from(p.samples), of, f64::from(equal_samples)))
    };
    // Rendering alone is a straight line, with learning before it is none.
    let equal_seconds = all(runs, |points| {
        let learning = points.last()?.preprocessing_seconds;
        let rendering = value_at(points, |p| f64::from(p.samples), |p| p.seconds, f64::from(equal_samples))?;
        Some(curve::Value { value: rendering.value + learning, ..rendering })
    });
    let at = |time: f64| {
        all(runs, |points| {
            let rendering = time - points.last()?.preprocessing_seconds;
            value_at(points, |p| p.seconds, |p| p.mape, rendering)
        })
    };
    let ends = |runs: &[&[Checkpoint]], seconds: fn(&Checkpoint) -> f64| -> Vec<Run> {
        runs.iter().filter_map(|points| points.last()).map(|point| end(point, seconds(point))).collect()
    };
    let efficiency = |seconds: fn(&Checkpoint) -> f64| {
        efficiency::summary(&ends(runs, seconds), &ends(first, seconds), noise)
    };
    let learning: Vec<f64> =
        runs.iter().filter_map(|points| points.last()).map(|point| point.preprocessing_seconds).collect();
    Summary {
        learning_seconds: median(&learning),
        target: target_of(runs, first, target),
        expected: times.iter().map(|&time| at(time)).collect(),
        equal_mape: equal(|p| p.mape),
        equal_relmse: equal(|p| p.relmse),
        equal_seconds,
        efficiency: efficiency(|p| p.seconds),
        efficiency_with_learning: efficiency(Checkpoint::total_seconds),
        calibration: calibration(runs),
        curve: typical(runs),
    }
}

fn end(point: &Checkpoint, seconds: f64) -> Run {
    Run {
        seed: 0,
        samples: point.samples,
        seconds,
        errors: point.errors(),
        mean_ratio: point.mean_ratio,
        rays: RayCounts::default(),
        non_finite: point.non_finite,
    }
}

/// The median over all renders; `None` where it is not known of one.
fn all(runs: &[&[Checkpoint]], of: impl Fn(&[Checkpoint]) -> Option<curve::Value>) -> Option<Estimate> {
    let values: Vec<curve::Value> = runs.iter().map(|points| of(points)).collect::<Option<_>>()?;
    let extrapolated = values.iter().any(|value| value.extrapolated);
    Some(Estimate::of(&values.iter().map(|value| value.value).collect::<Vec<_>>(), extrapolated))
}

/// A curve of a render, read at `at`.
pub fn value_at(
    points: &[Checkpoint],
    x: fn(&Checkpoint) -> f64,
    y: fn(&Checkpoint) -> f64,
    at: f64,
) -> Option<curve::Value> {
    let pairs: Vec<[f64; 2]> = points.iter().map(|point| [x(point), y(point)]).collect();
    curve::value(&pairs, at)
}

/// From which rendering time on a render's MAPE stays at or below `error`.
pub fn time_to(points: &[Checkpoint], error: f64) -> Crossing {
    let pairs: Vec<[f64; 2]> = points.iter().map(|point| [point.seconds, point.mape]).collect();
    curve::crossing(&pairs, error)
}

fn target_of(runs: &[&[Checkpoint]], first: &[&[Checkpoint]], error: f64) -> Target {
    let reached = reached(runs, error);
    let of_first = self::reached(first, error);
    let estimate = |of: &dyn Fn(&Reached) -> f64| {
        let values: Vec<f64> = reached.iter().map(of).collect();
        Estimate::of(&values, reached.iter().any(|render| render.extrapolated))
    };
    let speedup = |of: &dyn Fn(&Reached) -> f64| {
        let ratios: Vec<f64> = of_first.iter().zip(&reached).map(|(a, b)| of(a) / of(b)).collect();
        let known = ratios.iter().all(|ratio| ratio.is_finite() && *ratio > 0.0);
        (known && !ratios.is_empty())
            .then(|| Ratio { median: median(&ratios), interval: median_interval(&ratios) })
    };
    Target {
        seconds: estimate(&|render| render.seconds + render.preprocessing),
        rendering_seconds: estimate(&|render| render.seconds),
        samples: estimate(&|render| render.samples),
        at_once: reached.iter().filter(|render| render.at_once).count(),
        met: reached.iter().filter(|render| render.seconds.is_finite()).count(),
        speedup: speedup(&|render| render.seconds + render.preprocessing),
        rendering_speedup: speedup(&|render| render.seconds),
    }
}

/// Where one render meets an error; infinite where it does not.
struct Reached {
    seconds: f64,
    preprocessing: f64,
    samples: f64,
    extrapolated: bool,
    at_once: bool,
}

fn reached(runs: &[&[Checkpoint]], error: f64) -> Vec<Reached> {
    let one = |points: &&[Checkpoint]| {
        let (seconds, extrapolated, at_once) = match time_to(points, error) {
            Crossing::Measured(seconds) => (seconds, false, false),
            Crossing::Extrapolated(seconds) => (seconds, true, false),
            Crossing::AtMost(seconds) => (seconds, false, true),
            Crossing::Never => (f64::INFINITY, false, false),
        };
        let samples = value_at(points, |p| p.seconds, |p| f64::from(p.samples), seconds);
        // What was learnt by then; where learning goes on while it renders, that is less than all.
        let learnt = points.iter().find(|point| point.seconds >= seconds).or(points.last());
        Reached {
            seconds,
            preprocessing: learnt.map_or(0.0, |point| point.preprocessing_seconds),
            samples: samples.map_or(f64::INFINITY, |samples| samples.value),
            extrapolated,
            at_once,
        }
    };
    runs.iter().map(one).collect()
}

fn calibration(runs: &[&[Checkpoint]]) -> Option<ErrorCalibration> {
    let known: Vec<(f64, u32)> = runs
        .iter()
        .flat_map(|points| points.iter())
        .filter_map(|point| Some((point.estimated_error? / point.mape, point.samples)))
        .collect();
    let off = |ratio: f64| ratio.ln().abs();
    let &(worst, worst_samples) = known.iter().max_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
    let ratios: Vec<f64> = known.iter().map(|&(ratio, _)| ratio).collect();
    Some(ErrorCalibration { median: median(&ratios), worst, worst_samples, checkpoints: known.len() })
}

/// Medians at each checkpoint; where renders ended by the clock, their ends are the last.
pub fn typical(runs: &[&[Checkpoint]]) -> Vec<Typical> {
    let Some(shortest) = runs.iter().map(|points| points.len()).min() else { return Vec::new() };
    let is_common = |place: usize| runs.iter().all(|points| points[place].samples == runs[0][place].samples);
    let mut checkpoints: Vec<Vec<&Checkpoint>> = (0..shortest)
        .filter(|&place| is_common(place))
        .map(|place| runs.iter().map(|points| &points[place]).collect())
        .collect();
    let ends: Vec<&Checkpoint> = runs.iter().filter_map(|points| points.last()).collect();
    let last = checkpoints.last().map_or(0, |points| points[0].samples);
    let times = || ends.iter().map(|point| point.total_seconds());
    // Not where one has gone on to its goal and another has not: their middle is on the curve of neither.
    let alike = times().fold(0.0, f64::max) <= 2.0 * times().fold(f64::INFINITY, f64::min);
    if alike && !ends.is_empty() && ends.iter().all(|point| point.samples > last) {
        checkpoints.push(ends);
    }
    checkpoints.iter().map(|points| median_checkpoint(points)).collect()
}

fn median_checkpoint(points: &[&Checkpoint]) -> Typical {
    let of = |value: &dyn Fn(&Checkpoint) -> f64| {
        median(&points.iter().map(|point| value(point)).collect::<Vec<_>>())
    };
    let ratios: Option<Vec<f64>> =
        points.iter().map(|point| Some(point.estimated_error? / point.mape)).collect();
    Typical {
        samples: of(&|point| f64::from(point.samples)),
        seconds: of(&|point| point.seconds),
        preprocessing_seconds: of(&|point| point.preprocessing_seconds),
        total_seconds: of(&Checkpoint::total_seconds),
        mape: of(&|point| point.mape),
        relmse: of(&|point| point.relmse),
        relmse_trimmed: of(&|point| point.relmse_trimmed),
        estimated_over_measured: ratios.map(|ratios| median(&ratios)),
    }
}

/// For the curves of several settings, the checkpoints of each that are on their common front, `[total seconds, MAPE]`:
/// nothing else had less error after as much time.
pub fn front(curves: &[&[Typical]]) -> Vec<Vec<[f64; 2]>> {
    let pairs = |curve: &&[Typical]| {
        curve.iter().map(|checkpoint| [checkpoint.total_seconds, checkpoint.mape]).collect()
    };
    let curves: Vec<Vec<[f64; 2]>> = curves.iter().map(pairs).collect();
    let places = curve::front(&curves);
    curves
        .iter()
        .zip(places)
        .map(|(curve, own)| own.into_iter().map(|place| curve[place]).collect())
        .collect()
}
