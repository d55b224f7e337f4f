//! How efficient integrators are: 1 / (relMSE x time), from rounds in which each renders once.

use std::time::Duration;

use serde::Serialize;

use super::reference::Reference;
use crate::film::metric::{self, Errors, ReferenceNoise};
use crate::integrator::RayCounts;
use crate::math::statistics::{mean, median, median_interval, standard_error};
use crate::render::{Budget, RenderError, Renderer, Report, TimeLimit};

/// How much each render does. The error is that of a number of samples, never of an interval of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Work {
    /// As many samples as take about so long, the same number in every round.
    Time(Duration),
    /// So many samples a pixel.
    Samples(u32),
}

/// One render of one integrator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Run {
    pub seed: u64,
    pub samples: u32,
    pub seconds: f64,
    /// As measured, the noise of the reference included.
    #[serde(flatten)]
    pub errors: Errors,
    /// The picture's mean over the reference's.
    pub mean_ratio: f64,
    pub rays: RayCounts,
    pub non_finite: u64,
}

/// All runs of an integrator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    pub samples: u32,
    /// Median; whatever else the machine did is in the mean.
    pub seconds: f64,
    /// Means over the rounds. `relmse` is freed of the reference's noise, the other two are not.
    #[serde(flatten)]
    pub errors: Errors,
    /// 1 / (mean relMSE x mean time), in 1 / s; `None` where the error is below the reference's noise.
    pub efficiency: Option<f64>,
    /// Efficiency over that of the first integrator.
    pub ratio: Option<Ratio>,
    pub mean_ratio: f64,
    /// Of the mean ratio: from its scatter over the rounds and from the noise of the reference.
    pub mean_ratio_error: Option<f64>,
    /// Means over all samples of all pixels; the runs have exact totals.
    pub iteration: Iteration,
}

impl Summary {
    /// More than a tenth of what was measured is the reference's noise.
    pub fn needs_better_reference(&self, noise: ReferenceNoise) -> bool {
        noise.relmse > 0.1 * (self.errors.relmse + noise.relmse)
    }
}

/// The ratio of two efficiencies, from pairs of runs of the same round.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    pub median: f64,
    /// 95 % confidence.
    pub interval: Option<[f64; 2]>,
}

/// What a sample of all pixels takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Iteration {
    pub rays: f64,
    pub connections: f64,
    pub light_vertices: f64,
}

/// Renders `rounds` times with each of the renderers, in an order that turns round from round to round, every time
/// with a seed of its own from `first_seed` on. Returns each renderer's runs, and a report for each (of its last run).
/// `progress` is told the round and the renderer about to run; `None` is the choice of its number of samples.
///
/// # Errors
/// A lost device, a reference that nothing can be compared with.
pub fn measure(
    renderers: &mut [Renderer],
    work: Work,
    rounds: u32,
    first_seed: u64,
    truth: &Reference<'_>,
    mut progress: impl FnMut(Option<u32>, usize),
) -> Result<Vec<(Vec<Run>, Report)>, RenderError> {
    let count = renderers.len();
    let mut samples = Vec::new();
    for (index, renderer) in renderers.iter_mut().enumerate() {
        progress(None, index);
        renderer.restart(first_seed, None)?;
        samples.push(match work {
            Work::Samples(samples) => {
                // Buffers grow to their size here, not while the clock runs.
                render(renderer, Budget { samples: Some(1), ..Budget::default() })?;
                samples
            }
            Work::Time(time) => {
                let limit = TimeLimit::Rendering(time);
                let report = render(renderer, Budget { time: Some(limit), ..Budget::default() })?;
                samples_for(time.as_secs_f64(), &report)
            }
        });
    }
    let mut runs = vec![Vec::new(); count];
    for round in 0..rounds {
        for place in 0..count {
            let index = if round.is_multiple_of(2) { place } else { count - 1 - place };
            progress(Some(round), index);
            // Runs share no random numbers, not even those of a round: their errors are independent.
            let seed = first_seed + 1 + u64::from(round) * count as u64 + index as u64;
            let renderer = &mut renderers[index];
            renderer.restart(seed, None)?;
            let budget = Budget { samples: Some(samples[index]), ..Budget::default() };
            let report = render(renderer, budget)?;
            let picture = renderer.radiance()?.part(&truth.region);
            runs[index].push(Run {
                seed,
                samples: report.samples,
                seconds: report.seconds,
                errors: metric::errors(&picture, truth.picture)?,
                mean_ratio: metric::mean_ratio(&picture, truth.picture).ratio,
                rays: report.rays,
                non_finite: report.non_finite,
            });
        }
    }
    let reports = renderers.iter().map(Renderer::report).collect::<Result<Vec<_>, _>>()?;
    Ok(runs.into_iter().zip(reports).collect())
}

fn render(renderer: &mut Renderer, budget: Budget) -> Result<Report, RenderError> {
    renderer.set_budget(budget);
    renderer.run(|_| false)?;
    renderer.report()
}

/// The samples that take about `seconds`, at the speed of a render.
fn samples_for(seconds: f64, report: &Report) -> u32 {
    ((f64::from(report.samples) * seconds / report.seconds).round() as u32).max(1)
}

/// What runs say, beside those of the first integrator in the same rounds.
pub fn summary(runs: &[Run], first: &[Run], noise: Option<ReferenceNoise>) -> Summary {
    let of = |value: &dyn Fn(&Run) -> f64| -> Vec<f64> { runs.iter().map(value).collect() };
    let noise_relmse = noise.map_or(0.0, |noise| noise.relmse);
    let cost = |run: &Run| (run.errors.relmse - noise_relmse) * run.seconds;
    let relmse = mean(&of(&|run| run.errors.relmse)) - noise_relmse;
    let seconds = of(&|run| run.seconds);
    let ratios: Vec<f64> = runs.iter().zip(first).map(|(own, first)| cost(first) / cost(own)).collect();
    let known = runs.iter().chain(first).all(|run| cost(run) > 0.0);

    let mean_ratios = of(&|run| run.mean_ratio);
    let mean_ratio = mean(&mean_ratios);
    let of_reference = mean_ratio * noise.map_or(0.0, |noise| noise.mean);
    let samples: f64 = of(&|run| f64::from(run.samples)).iter().sum();
    let each = |value: &dyn Fn(&RayCounts) -> u64| {
        runs.iter().map(|run| value(&run.rays)).sum::<u64>() as f64 / samples
    };
    Summary {
        samples: runs[0].samples,
        seconds: median(&seconds),
        errors: Errors {
            mape: mean(&of(&|run| run.errors.mape)),
            relmse,
            relmse_trimmed: mean(&of(&|run| run.errors.relmse_trimmed)),
        },
        efficiency: (relmse > 0.0).then(|| 1.0 / (relmse * mean(&seconds))),
        ratio: known.then(|| Ratio { median: median(&ratios), interval: median_interval(&ratios) }),
        mean_ratio,
        mean_ratio_error: standard_error(&mean_ratios).map(|own| own.hypot(of_reference)),
        iteration: Iteration {
            rays: each(&|rays| rays.closest_hit),
            connections: each(&|rays| rays.occlusion),
            light_vertices: each(&|rays| rays.light_vertices),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(relmse: f64, seconds: f64, mean_ratio: f64) -> Run {
        let errors = Errors { mape: 0.5 * relmse, relmse, relmse_trimmed: 0.25 * relmse };
        let rays = RayCounts { closest_hit: 80, occlusion: 60, light_vertices: 40, ..RayCounts::default() };
        Run { seed: 0, samples: 10, seconds, errors, mean_ratio, rays, non_finite: 0 }
    }

    #[test]
    fn a_summary_by_hand() {
        let first = [run(0.5, 2.0, 1.0), run(0.75, 2.0, 1.0), run(0.5, 4.0, 1.0)];
        let own = [run(0.5, 1.0, 0.5), run(0.5, 1.0, 1.0), run(0.5, 4.0, 1.5)];
        let noise = ReferenceNoise { relmse: 0.25, mape: 0.5, mean: 0.75 };
        let summary = summary(&own, &first, Some(noise));
        assert_eq!(summary.errors, Errors { mape: 0.25, relmse: 0.25, relmse_trimmed: 0.125 });
        assert_eq!((summary.samples, summary.seconds), (10, 1.0));
        assert_eq!(summary.efficiency, Some(2.0), "1 / (0.25 x 2 s)");
        // Of the rounds, without the noise: (0.25 x 2) / (0.25 x 1), (0.5 x 2) / (0.25 x 1), (0.25 x 4) / (0.25 x 4).
        assert_eq!(summary.ratio, Some(Ratio { median: 2.0, interval: Some([1.0, 4.0]) }));
        assert_eq!(summary.mean_ratio, 1.0);
        // Variance of the three ratios 1/4, of their mean 1/12; of the reference 9/16.
        let error = summary.mean_ratio_error.expect("three rounds");
        assert!((error - (1.0f64 / 12.0 + 9.0 / 16.0).sqrt()).abs() < 1e-15, "{error}");
        assert_eq!(summary.iteration, Iteration { rays: 8.0, connections: 6.0, light_vertices: 4.0 });
    }

    #[test]
    fn an_integrator_is_as_efficient_as_itself() {
        let runs = [run(0.5, 2.0, 1.0), run(0.75, 3.0, 1.0)];
        let ratio = summary(&runs, &runs, None).ratio;
        assert_eq!(ratio, Some(Ratio { median: 1.0, interval: Some([1.0, 1.0]) }));
    }

    /// Errors below the noise of the reference say nothing of efficiency, and must not become a negative one.
    #[test]
    fn errors_below_the_reference_s_noise_give_no_efficiency() {
        let runs = [run(0.5, 2.0, 1.0), run(0.5, 2.0, 1.0)];
        let summary = summary(&runs, &runs, Some(ReferenceNoise { relmse: 0.5, mape: 0.5, mean: 0.0 }));
        assert_eq!((summary.efficiency, summary.ratio), (None, None));
        assert!(summary.needs_better_reference(ReferenceNoise { relmse: 0.5, mape: 0.5, mean: 0.0 }));
        assert!(!summary.needs_better_reference(ReferenceNoise { relmse: 0.0, mape: 0.0, mean: 0.0 }));
    }
}
