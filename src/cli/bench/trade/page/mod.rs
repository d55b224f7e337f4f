//! The page: what a user wants to know first, how it was made last.

mod sweeps;
mod tables;

use super::results::{SceneResult, Trade};
use crate::bench::trade::Estimate;
use crate::cli::bench::format::{level, percent, seconds, share, table};
use crate::cli::bench::runs::{CandidateResult, Drift};
use crate::cli::text::short;

/// The page as Markdown; `sheet` is the file of its plots, beside it.
pub fn page(trade: &Trade, sheet: &str) -> String {
    let mut page = Page { text: String::new(), trade, sheet };
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
    page.seen();
    page.efficiency();
    page.sweeps();
    page.calibration();
    page.how();
    page.text
}

struct Page<'a> {
    text: String,
    trade: &'a Trade,
    sheet: &'a str,
}

impl Page<'_> {
    /// A paragraph, or a line of a table.
    fn say(&mut self, line: &str) {
        self.text += line;
        self.text.push('\n');
    }

    /// A table; columns after the first `left` are numbers.
    fn table(&mut self, heads: &[String], left: usize, rows: &[Vec<String>]) {
        self.say(&table(heads, left, rows));
    }

    /// Error after the times that are asked for, and the curves.
    fn expected(&mut self) {
        let trade = self.trade;
        self.say("## What to expect\n");
        self.say(
            "Error after so much time, learning included; the least is bold, where it is known to be that, and so is the \
             least of what is denoised. `~` is continued beyond what was measured, by no more than a factor of four; `-` \
             is beyond that, or before the first picture.\n",
        );
        let mut heads: Vec<String> = ["scene", "`halfway render`"].map(String::from).into();
        heads.extend(trade.times.iter().map(|&time| seconds(time)));
        let mut rows = Vec::new();
        for scene in &trade.scenes {
            for (index, one) in scene.integrators.iter().enumerate() {
                let name = if index == 0 { format!("**{}**", scene.name) } else { String::new() };
                let mut row = vec![name, format!("`{}`", one.flags)];
                for (place, estimate) in one.summary.expected.iter().enumerate() {
                    row.push(match estimate {
                        Some(estimate) if scene.best(place, one.denoised) == Some(index) => {
                            format!("**{}**", share(estimate))
                        }
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
        }
        self.say(&format!("![error against time and samples, scene by scene]({})\n", self.sheet));
    }

    /// What to use for a scene, in a sentence.
    fn advice(&mut self, scene: &SceneResult) {
        let best_at = |place: usize, denoised: bool| -> Option<(&CandidateResult, Estimate)> {
            let one = &scene.integrators[scene.best(place, denoised)?];
            Some((one, one.summary.expected[place]?))
        };
        let mut parts: Vec<String> = Vec::new();
        for denoised in [false, true] {
            let mut last = "";
            for (place, &time) in self.trade.times.iter().enumerate() {
                if let Some((one, estimate)) = best_at(place, denoised).filter(|(one, _)| one.label != last) {
                    parts.push(format!("for {} `{}` ({})", seconds(time), one.flags, share(&estimate)));
                    last = &one.label;
                }
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

    /// How long renders go on that are on their way.
    fn longest(&self) -> String {
        let trade = self.trade;
        trade.longest.map_or(String::new(), |longest| {
            format!(" (up to {} on the way to {})", seconds(longest), level(trade.target))
        })
    }

    /// What it takes to make the page again, and how far to trust it.
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
                "Machines that others share are not always as fast. The same small work was timed before and after \
                 learning and every other second of rendering, and times are scaled by that to the usual speed: single \
                 renders went at {} to {} times the usual time.\n",
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
                "Pictures were rendered whole, and compared at the pixels that the reference has: one of each \
                 square.\n",
            );
        }
        for warning in trade.warnings() {
            self.say(&format!("* {warning}"));
        }
    }
}
