//! What each value of a setting does to the error.

use super::Page;
use crate::cli::bench::format::{level, met, seconds, share};
use crate::cli::bench::runs::CandidateResult;
use crate::cli::bench::trade::results::{SceneResult, SweepResult};
use crate::cli::text::{ratio, short};
use crate::math::statistics::geometric_mean;

impl Page<'_> {
    /// All settings at a glance, then each in each scene.
    pub(super) fn sweeps(&mut self) {
        let trade = self.trade;
        if trade.scenes.iter().all(|scene| scene.sweeps.is_empty()) {
            return;
        }
        self.say("## Settings\n");
        self.say(&format!(
            "One setting at a time, the others at their defaults; the first row is without it. *Best* says from when to \
             when a value is on the front of all: nothing else tried had less error after as much time. `times as fast` \
             is to the first row; an interval that holds 1 shows no difference. The curves are in the [picture of all \
             plots]({}), each setting under a title of its own.\n",
            self.sheet
        ));
        if trade.scenes.len() > 1 {
            self.sweeps_at_a_glance();
        }
        for scene in &trade.scenes {
            for sweep in &scene.sweeps {
                self.sweep(scene, sweep);
            }
        }
    }

    /// A row for each value of each sweep, a column for each scene.
    fn sweeps_at_a_glance(&mut self) {
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
        for (place, sweep) in scenes[0].sweeps.iter().enumerate() {
            for (value, one) in sweep.values.iter().enumerate().skip(1) {
                let ratios: Vec<Option<f64>> = scenes
                    .iter()
                    .map(|scene| Some(scene.sweeps[place].values[value].summary.target.speedup?.median))
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

    fn sweep(&mut self, scene: &SceneResult, sweep: &SweepResult) {
        let trade = self.trade;
        self.say(&format!("### {}: {}\n", scene.name, sweep.name));
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
        let rows: Vec<Vec<String>> = sweep.values.iter().zip(&sweep.front).map(row).collect();
        self.table(&heads, 1, &rows);
    }
}
