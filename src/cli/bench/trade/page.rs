//! The page: what a user wants to know first, how it was made last.

use super::paper;
use super::record::Drift;
use super::results::{CandidateResult, SceneResult, SweepResult, Trade, file_name};
use crate::bench::trade::{ErrorCalibration, Estimate};
use crate::cli::text::{grouped, ratio, short};
use crate::math::statistics::{geometric_mean, median};

/// The page as Markdown; `plots` is the folder of the plots, beside it.
pub fn page(trade: &Trade, plots: &str) -> String {
    let mut page = Page { text: String::new(), trade, plots };
    page.say("# Speed and accuracy\n");
    page.say(
        "How much error is left after how much time, by which integrator with which settings. Error is MAPE, the \
         average relative error of a pixel: 5 % looks clean, 20 % is grainy. This page is made by a command, which is \
         at [its end](#how-it-was-made), and holds for the device named there: elsewhere the seconds differ, the \
         order seldom.\n",
    );
    page.expected();
    page.target();
    page.beside_the_paper();
    page.equal_samples();
    page.efficiency();
    page.knobs();
    page.honesty();
    page.how();
    page.text
}

struct Page<'a> {
    text: String,
    trade: &'a Trade,
    plots: &'a str,
}

impl Page<'_> {
    /// A paragraph, or a line of a table.
    fn say(&mut self, line: &str) {
        self.text += line;
        self.text.push('\n');
    }

    /// A table; columns after the first `left` are numbers.
    fn table(&mut self, heads: &[String], left: usize, rows: &[Vec<String>]) {
        self.say(&format!("| {} |", heads.join(" | ")));
        let rule = |column: usize| if column < left { "---" } else { "--:" };
        self.say(&format!("|{}|", (0..heads.len()).map(rule).collect::<Vec<_>>().join("|")));
        for row in rows {
            self.say(&format!("| {} |", row.join(" | ")));
        }
        self.say("");
    }

    fn expected(&mut self) {
        let trade = self.trade;
        self.say("## What to expect\n");
        self.say(
            "Error after so much time, learning included; the least is bold, where it is known to be that. `~` is continued beyond what was measured, \
             by no more than a factor of four; `-` is beyond that, or before the first picture.\n",
        );
        let mut heads: Vec<String> = ["scene", "`halfway render`"].map(String::from).into();
        heads.extend(trade.times.iter().map(|&time| seconds(time)));
        let mut rows = Vec::new();
        for scene in &trade.scenes {
            let best: Vec<Option<usize>> = (0..trade.times.len()).map(|place| scene.best(place)).collect();
            for (index, one) in scene.integrators.iter().enumerate() {
                let name = if index == 0 { format!("**{}**", scene.name) } else { String::new() };
                let mut row = vec![name, format!("`{}`", one.flags)];
                for (estimate, best) in one.summary.expected.iter().zip(&best) {
                    row.push(match estimate {
                        Some(estimate) if *best == Some(index) => format!("**{}**", share(estimate)),
                        Some(estimate) => share(estimate),
                        None => "-".into(),
                    });
                }
                rows.push(row);
            }
        }
        self.table(&heads, 2, &rows);
        for scene in &trade.scenes {
            self.advice(scene);
            self.say(&format!(
                "![{0}: error against time]({1}/{2}-time.svg)\n\n![{0}: error against samples]({1}/{2}-samples.svg)\n",
                scene.name,
                self.plots,
                scene.stem()
            ));
        }
    }

    /// What to use for a scene, in a sentence.
    fn advice(&mut self, scene: &SceneResult) {
        let best_at = |place: usize| -> Option<(&CandidateResult, Estimate)> {
            let one = &scene.integrators[scene.best(place)?];
            Some((one, one.summary.expected[place]?))
        };
        let mut parts: Vec<String> = Vec::new();
        let mut last = "";
        for (place, &time) in self.trade.times.iter().enumerate() {
            if let Some((one, estimate)) = best_at(place).filter(|(one, _)| one.label != last) {
                parts.push(format!("for {} `{}` ({})", seconds(time), one.flags, share(&estimate)));
                last = &one.label;
            }
        }
        let [width, height] = scene.size;
        self.say(&match parts.is_empty() {
            true => format!(
                "**{}** ({width}x{height}): at none of these times was there a picture.\n",
                scene.name
            ),
            false => format!("**{}** ({width}x{height}): {}.\n", scene.name, parts.join(", ")),
        });
    }

    fn target(&mut self) {
        let trade = self.trade;
        let error = level(trade.target);
        self.say(&format!("## Time to {error}\n"));
        let over = match trade.seeds {
            1 => "of one seed, so that nobody knows how far another would be off".into(),
            seeds => format!("median of {seeds} seeds and its 95 % interval (bootstrap)"),
        };
        self.say(&format!(
            "From when on the error stays at or below {error}: {over}; \
             read off between looks at a render by straight lines in logarithms. `<`: some were there at their first \
             look, after 8 samples. `times as fast` is the first integrator's time over this one's, seed by seed.\n"
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

    /// A table with a row for each integrator of each scene.
    fn by_scene(&mut self, heads: &[&str], row: impl Fn(&CandidateResult) -> Vec<String>) {
        let mut rows = Vec::new();
        for scene in &self.trade.scenes {
            for (index, one) in scene.integrators.iter().enumerate() {
                let name = if index == 0 { format!("**{}**", scene.name) } else { String::new() };
                let mut cells = vec![name, one.label.clone()];
                cells.extend(row(one));
                rows.push(cells);
            }
        }
        self.table(&heads.iter().map(|head| head.to_string()).collect::<Vec<_>>(), 2, &rows);
    }

    fn beside_the_paper(&mut self) {
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
            let [slow_iterations, fast_iterations] = theirs.iterations.map(|count| grouped(count.into()));
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
             SIGGRAPH 2022, to 12 %), and the samples a pixel of each beside the paper's iterations. The scenes have the name in \
             common, not the model, nor the size, nor the device; both programs, and what counts as a relative error near \
             black, differ as well.\n",
        );
        let heads =
            ["scene", "here", "there", "lvcbpt's samples here", "there", "spcbpt's samples here", "there"]
                .map(String::from);
        self.table(&heads, 1, &rows);
    }

    fn equal_samples(&mut self) {
        let samples = self.trade.equal_samples;
        self.say(&format!("## At {samples} samples a pixel\n"));
        self.say(
            "What a sample is worth, whatever it costs. The paper counts iterations, of one sample a pixel against light \
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

    fn efficiency(&mut self) {
        self.say("## Efficiency and bias\n");
        self.say(&format!(
            "At the ends of the renders, after {}{}: 1 / (relMSE x time), once by the time of rendering alone and once by all. \
             From relMSE, not from MAPE, the noise of the reference is subtracted. `trimmed` is relMSE without its largest \
             0.1 %, nothing subtracted: far less means few very bright pixels. The mean ratio is the picture's mean over \
             the reference's, +- its standard error by the seeds: few seeds know that badly, but far beyond it from 1 \
             something is biased, or has not been found yet.\n",
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

    /// How long renders go on that are on their way.
    fn longest(&self) -> String {
        let trade = self.trade;
        trade.longest.map_or(String::new(), |longest| {
            format!(" (up to {} on the way to {})", seconds(longest), level(trade.target))
        })
    }

    fn knobs(&mut self) {
        let trade = self.trade;
        if trade.scenes.iter().all(|scene| scene.knobs.is_empty()) {
            return;
        }
        self.say("## Settings\n");
        self.say(
            "One setting at a time, the others at their defaults; the first row is without it. *Best* says from when to \
             when a value is on the front of all: nothing else tried had less error after as much time. `times as fast` is to \
             the first row; an interval that holds 1 is no difference that anyone has seen.\n",
        );
        if trade.scenes.len() > 1 {
            self.knobs_at_a_glance();
        }
        for scene in &trade.scenes {
            for knob in &scene.knobs {
                self.knob(scene, knob);
            }
        }
    }

    /// A row for each value of each knob, a column for each scene.
    fn knobs_at_a_glance(&mut self) {
        let scenes = &self.trade.scenes;
        self.say(&format!(
            "How many times as fast {} is met as without the setting, learning included, in each scene, and their \
             geometric mean where all are known.\n",
            level(self.trade.target)
        ));
        let mut heads = vec!["setting".to_string()];
        heads.extend(scenes.iter().map(|scene| scene.name.clone()));
        heads.push("all".into());
        let mut rows = Vec::new();
        for (place, knob) in scenes[0].knobs.iter().enumerate() {
            for (value, one) in knob.values.iter().enumerate().skip(1) {
                let ratios: Vec<Option<f64>> = scenes
                    .iter()
                    .map(|scene| Some(scene.knobs[place].values[value].summary.target.speedup?.median))
                    .collect();
                let mut row = vec![format!("`{}`", one.flags)];
                row.extend(
                    ratios.iter().map(|ratio| ratio.map_or("-".into(), |ratio| format!("{ratio:.2}"))),
                );
                let all: Option<Vec<f64>> = ratios.into_iter().collect();
                row.push(all.map(|all| geometric_mean(&all)).map_or("-".into(), |mean| format!("{mean:.2}")));
                rows.push(row);
            }
        }
        self.table(&heads, 1, &rows);
    }

    fn knob(&mut self, scene: &SceneResult, knob: &SweepResult) {
        let trade = self.trade;
        self.say(&format!("### {}: {}\n", scene.name, knob.name));
        let mut heads: Vec<String> = ["setting", "learning, s"].map(String::from).into();
        heads.extend(trade.times.iter().map(|&time| seconds(time)));
        heads.push(format!("seconds to {}", level(trade.target)));
        heads.extend(["times as fast", "best"].map(String::from));
        let row = |(one, front): (&CandidateResult, &Vec<[f64; 2]>)| {
            let mut row = vec![format!("`{}`", one.flags), short(one.summary.learning_seconds)];
            row.extend(one.summary.expected.iter().map(|e| e.as_ref().map_or("-".into(), share)));
            row.push(met(one));
            row.push(ratio(one.summary.target.speedup));
            row.push(match (front.first(), front.last()) {
                (Some([first, _]), Some([last, _])) if first == last => format!("at {} s", short(*first)),
                (Some([first, _]), Some([last, _])) => format!("{} to {} s", short(*first), short(*last)),
                _ => "-".into(),
            });
            row
        };
        let rows: Vec<Vec<String>> = knob.values.iter().zip(&knob.front).map(row).collect();
        self.table(&heads, 1, &rows);
        self.say(&format!(
            "![{0}: {1}]({2}/{3}-{4}.svg)\n",
            scene.name,
            knob.name,
            self.plots,
            scene.stem(),
            file_name(&knob.name)
        ));
    }

    fn honesty(&mut self) {
        self.say("## The renderer's own estimate of its error\n");
        self.say(
            "`--error` and the progress bar estimate the error without a reference. Estimated over measured, over all looks \
             at all renders from 16 samples on: below 1 a picture is worse than the renderer says, mostly because light \
             that no sample has found yet is not in the estimate. Near the reference's own error the measured one is too \
             large. By each look it is in the CSV file.\n",
        );
        let row = |one: &CandidateResult| match one.summary.honesty {
            Some(ErrorCalibration { median, worst, worst_samples, looks }) => vec![
                short(median),
                format!("{} (at {} samples)", short(worst), grouped(worst_samples.into())),
                looks.to_string(),
            ],
            None => vec!["-".into(); 3],
        };
        self.by_scene(&["scene", "integrator", "median", "worst", "looks"], row);
    }

    fn how(&mut self) {
        let trade = self.trade;
        self.say("## How it was made\n");
        let end = match trade.samples {
            Some(samples) => format!("{} or {samples} samples", seconds(trade.seconds)),
            None => seconds(trade.seconds),
        };
        self.say(&format!(
            "{}, {}, Halfway {}. {} of each, {end} a render{}, integrators by turns. A point on a curve is of a render \
             that went on to its end; one that is asked for less time may learn less.\n\n```\n{}\n```\n",
            trade.date,
            trade.device,
            trade.version,
            if trade.seeds == 1 { "One seed".into() } else { format!("{} seeds", trade.seeds) },
            self.longest(),
            trade.command
        ));
        if let Some(Drift { best, worst, .. }) = trade.drift {
            self.say(&format!(
                "Machines that others share are not always as fast. The same small work was timed before and after learning and \
                 every other second of rendering, and times are scaled by that to the usual pace: single renders went at {} \
                 to {} times the usual time.\n",
                short(best),
                short(worst)
            ));
        }
        let heads = ["scene", "reference", "its own MAPE", "checked by"].map(String::from);
        let rows: Vec<Vec<String>> = trade
            .scenes
            .iter()
            .map(|scene| {
                let noise = scene.reference.noise.map_or("unknown".into(), |noise| percent(noise.mape));
                let checked = scene.reference.checked.clone().unwrap_or("nothing yet".into());
                vec![scene.name.clone(), scene.reference.origin.clone(), noise, checked]
            })
            .collect();
        self.table(&heads, 1, &rows);
        if trade.scenes.iter().any(|scene| scene.reference.stride > 1) {
            self.say(
                "Pictures were rendered whole, and compared at the pixels that the reference has: one of each square.\n",
            );
        }
        for warning in trade.warnings() {
            self.say(&format!("* {warning}"));
        }
    }
}

/// 0.05 is 5.00 %.
fn percent(value: f64) -> String {
    format!("{} %", short(100.0 * value))
}

/// A share that somebody asked for: 0.12 is 12 %.
fn level(value: f64) -> String {
    format!("{} %", (1e6 * value).round() / 1e4)
}

fn seconds(value: f64) -> String {
    // Minutes where a tenth of one is exact.
    if value >= 120.0 && value % 6.0 == 0.0 { format!("{} min", value / 60.0) } else { format!("{value} s") }
}

fn tilde(estimate: &Estimate) -> &'static str {
    if estimate.extrapolated { "~" } else { "" }
}

fn share(estimate: &Estimate) -> String {
    format!("{}{}", tilde(estimate), percent(estimate.value))
}

fn share_spread(estimate: &Estimate) -> String {
    let interval = estimate
        .interval
        .map_or(String::new(), |[low, high]| format!(" ({} to {})", short(100.0 * low), short(100.0 * high)));
    share(estimate) + &interval
}

/// A value with its interval; what was not met is infinite.
fn spread(estimate: &Estimate) -> String {
    if estimate.value.is_infinite() {
        return "not met".into();
    }
    let bound = |value: f64| if value.is_finite() { short(value) } else { "never".into() };
    let interval = estimate
        .interval
        .map_or(String::new(), |[low, high]| format!(" ({} to {})", bound(low), bound(high)));
    format!("{}{}{interval}", tilde(estimate), short(estimate.value))
}

/// When an error is met, and by how many where not by all.
fn met(one: &CandidateResult) -> String {
    let target = &one.summary.target;
    let seconds = spread(&target.seconds);
    match target.met {
        0 => seconds,
        met if met == one.runs.len() => seconds,
        met => format!("{seconds}, {met} of {}", one.runs.len()),
    }
}

fn count(estimate: &Estimate) -> String {
    if estimate.value.is_infinite() {
        return "-".into();
    }
    format!("{}{}", tilde(estimate), grouped(estimate.value))
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn times_are_short() {
        let told = [1.5, 60.0, 120.0, 150.0, 400.0].map(seconds);
        assert_eq!(told, ["1.5 s", "60 s", "2 min", "2.5 min", "400 s"]);
    }
}
