//! The page's tables with a row for each integrator of each scene.

use super::Page;
use crate::bench::trade::{Checkpoint, ErrorCalibration, Estimate};
use crate::cli::bench::format::{count, level, met, percent, seconds, share_spread, spread};
use crate::cli::bench::paper_figures as paper;
use crate::cli::bench::runs::CandidateResult;
use crate::cli::bench::trade::results::SceneResult;
use crate::cli::text::{grouped, ratio, short};
use crate::math::statistics::median;

impl Page<'_> {
    /// When the target is met.
    pub(super) fn target(&mut self) {
        let trade = self.trade;
        let error = level(trade.target);
        self.say(&format!("## Time to {error}\n"));
        let over = match trade.seeds {
            1 => "of one seed, so that it is not known how far another would be off".into(),
            seeds => format!("median of {seeds} seeds and its 95 % interval (bootstrap)"),
        };
        self.say(&format!(
            "From when on the error stays at or below {error}: {over}; read off between the checkpoints of a render by \
             straight lines in logarithms. `<`: some were there at their first checkpoint, after 8 samples. `times as \
             fast` is the first integrator's time over this one's, seed by seed.\n"
        ));
        let heads = [
            "scene",
            "integrator",
            "seconds",
            "of it learning",
            "samples",
            "times as fast",
            "times as fast, without learning",
        ];
        let row = |one: &CandidateResult| {
            let target = &one.summary.target;
            let sooner = |text: String| if target.at_once > 0 { format!("< {text}") } else { text };
            vec![
                sooner(met(one)),
                short(one.summary.learning_seconds),
                sooner(count(&target.samples)),
                ratio(target.speedup),
                ratio(target.rendering_speedup),
            ]
        };
        self.by_scene(&heads, row);
    }

    /// The paper's speed-ups, where the scene has a namesake there.
    pub(super) fn beside_the_paper(&mut self) {
        let find = |scene: &'_ SceneResult, label: &str| -> Option<usize> {
            scene.integrators.iter().position(|one| one.label == label)
        };
        let mut rows = Vec::new();
        for scene in &self.trade.scenes {
            let (Some(theirs), Some(slow), Some(fast)) =
                (paper::figures(&scene.name), find(scene, "lvcbpt"), find(scene, "spcbpt"))
            else {
                continue;
            };
            let target = |index: usize| &scene.integrators[index].summary.target;
            let ours = target(slow).seconds.value / target(fast).seconds.value;
            let ours = if ours.is_finite() && ours > 0.0 { short(ours) } else { "-".into() };
            let [slow_iterations, fast_iterations] = ["lvcbpt", "spcbpt"].map(|method| {
                theirs.reached(method).map_or("-".into(), |reached| grouped(reached.iterations.into()))
            });
            rows.push(vec![
                scene.name.clone(),
                ours,
                format!("{:.1}", theirs.speedup()),
                count(&target(slow).samples),
                slow_iterations,
                count(&target(fast).samples),
                fast_iterations,
            ]);
        }
        if rows.is_empty() {
            return;
        }
        self.say("### Beside the paper\n");
        self.say(
            "Time of `lvcbpt` over that of `spcbpt`, learning included, as the paper compares them (Su, Li, Wang, SPCBPT, \
             SIGGRAPH 2022, to 12 %), and the samples per pixel of each beside the paper's iterations. The scenes have \
             the name in common, not the model, nor the size, nor the device; both programs, and what counts as a \
             relative error near black, differ as well.\n",
        );
        let heads =
            ["scene", "here", "there", "lvcbpt's samples here", "there", "spcbpt's samples here", "there"]
                .map(String::from);
        self.table(&heads, 1, &rows);
    }

    /// Errors at the same number of samples.
    pub(super) fn equal_samples(&mut self) {
        let samples = self.trade.equal_samples;
        self.say(&format!("## At {samples} samples per pixel\n"));
        self.say(
            "What a sample is worth, whatever it costs. The paper counts iterations, of one sample per pixel against light \
             paths of its own; here up to eight samples share their light paths (not in `bdpt` and `light`), and a \
             sample is what is counted.\n",
        );
        let row = |one: &CandidateResult| {
            let summary = &one.summary;
            let known = |estimate: &Option<Estimate>, show: fn(&Estimate) -> String| {
                estimate.as_ref().map_or("-".into(), show)
            };
            vec![
                known(&summary.equal_mape, share_spread),
                known(&summary.equal_relmse, spread),
                known(&summary.equal_seconds, spread),
            ]
        };
        self.by_scene(&["scene", "integrator", "MAPE", "relMSE", "seconds, learning included"], row);
    }

    /// What is seen of the error at the ends of the renders, where whole pictures are compared.
    pub(super) fn seen(&mut self) {
        let last = |one: &CandidateResult, of: fn(&Checkpoint) -> Option<f64>| {
            let values: Vec<f64> = one.runs.iter().filter_map(|points| of(points.last()?)).collect();
            (!values.is_empty()).then(|| median(&values))
        };
        let flip = |one: &CandidateResult| last(one, |point| point.flip);
        if self.trade.scenes.iter().flat_map(|scene| &scene.integrators).all(|one| flip(one).is_none()) {
            return;
        }
        self.say("## What is seen\n");
        self.say(&format!(
            "At the ends of the renders, after {}{}: MAPE is what a measurement wants, FLIP what a viewer sees who switches \
             between the picture and the reference (LDR-FLIP, 0 to 1, 67 pixels per degree, at the exposure that suits the \
             reference). `--denoise` makes pictures look finished long before they are: where its MAPE stops falling, it has \
             made something up, and only more samples mend that.\n",
            seconds(self.trade.seconds),
            self.longest()
        ));
        let row = |one: &CandidateResult| {
            let shown = |value: Option<f64>, show: fn(f64) -> String| value.map_or("-".into(), show);
            vec![
                shown(last(one, |point| Some(point.mape)), percent),
                shown(flip(one), short),
                shown(last(one, |point| Some(point.mean_ratio)), |ratio| format!("{ratio:.4}")),
            ]
        };
        self.by_scene(&["scene", "integrator", "MAPE", "FLIP", "mean ratio"], row);
    }

    /// Efficiency at the ends of the renders, and whether the means agree.
    pub(super) fn efficiency(&mut self) {
        self.say("## Efficiency and bias\n");
        self.say(&format!(
            "At the ends of the renders, after {}{}: 1 / (relMSE x time), once by the time of rendering alone and once by all. \
             From relMSE, not from MAPE, the noise of the reference is subtracted. `trimmed` is relMSE without its largest \
             0.1 %, nothing subtracted: far less means few very bright pixels. The mean ratio is the picture's mean over \
             the reference's, +- its standard error by the seeds: with few seeds that is uncertain, but far beyond it from \
             1 something is biased, or has not been found yet.\n",
            seconds(self.trade.seconds),
            self.longest()
        ));
        let heads = [
            "scene",
            "integrator",
            "samples",
            "MAPE",
            "relMSE",
            "trimmed",
            "efficiency",
            "ratio",
            "with learning",
            "ratio",
            "mean ratio",
        ];
        let row = |one: &CandidateResult| {
            let (alone, all) = (&one.summary.efficiency, &one.summary.efficiency_with_learning);
            let ends = one.runs.iter().filter_map(|points| points.last());
            let samples = median(&ends.map(|end| f64::from(end.samples)).collect::<Vec<_>>());
            let error = alone.mean_ratio_error.map_or(String::new(), |error| format!(" +- {error:.4}"));
            let known = |value: Option<f64>| value.map_or("-".into(), short);
            vec![
                grouped(samples),
                percent(alone.errors.mape),
                short(alone.errors.relmse),
                short(alone.errors.relmse_trimmed),
                known(alone.efficiency),
                ratio(alone.ratio),
                known(all.efficiency),
                ratio(all.ratio),
                format!("{:.4}{error}", alone.mean_ratio),
            ]
        };
        self.by_scene(&heads, row);
    }

    /// How good `--error`'s estimate is.
    pub(super) fn calibration(&mut self) {
        self.say("## The renderer's own estimate of its error\n");
        self.say(
            "`--error` and the progress bar estimate the error without a reference. Estimated over measured, over all \
             checkpoints of all renders from 16 samples on: below 1 a picture is worse than its estimate, mostly because \
             light that no sample has found yet is not in it. Near the reference's own error the measured one is too \
             large. For each checkpoint it is in the CSV file.\n",
        );
        let row = |one: &CandidateResult| match one.summary.calibration {
            Some(ErrorCalibration { median, worst, worst_samples, checkpoints }) => vec![
                short(median),
                format!("{} (at {} samples)", short(worst), grouped(worst_samples.into())),
                checkpoints.to_string(),
            ],
            None => vec!["-".into(); 3],
        };
        self.by_scene(&["scene", "integrator", "median", "worst", "checkpoints"], row);
    }
}
