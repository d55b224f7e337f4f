//! The plots of a page: error against time and samples of all integrators, and against time of each sweep.

use super::plot::{Curve, Group, Line, Panel, Sheet};
use super::results::{SceneResult, SweepResult, Trade};
use crate::bench::trade::{Checkpoint, Typical};
use crate::cli::bench::runs::CandidateResult;

const TIME: &str = "seconds, learning included";
const SAMPLES: &str = "samples per pixel";

/// All plots, scene by scene in each group.
pub fn sheet(trade: &Trade) -> Sheet {
    let level = 100.0 * trade.target;
    let panel = |scene: &SceneResult, x_title, lines| {
        let [width, height] = scene.size;
        let title = format!("{}, {width}x{height}", scene.name);
        Panel { title, x_title, y_title: "MAPE, %", level: Some(level), lines }
    };
    let Some(first) = trade.scenes.first() else { return Sheet { groups: Vec::new() } };
    let integrators = |scene: &SceneResult| {
        let by_time = scene
            .integrators
            .iter()
            .map(|one| line(one, |typical| typical.total_seconds, Checkpoint::total_seconds));
        let by_samples = scene
            .integrators
            .iter()
            .map(|one| line(one, |typical| typical.samples, |point| f64::from(point.samples)));
        [panel(scene, TIME, by_time.collect()), panel(scene, SAMPLES, by_samples.collect())]
    };
    let mut groups = vec![Group {
        title: "integrators".into(),
        names: names(&first.integrators),
        panels: trade.scenes.iter().flat_map(integrators).collect(),
    }];
    for (place, sweep) in first.sweeps.iter().enumerate() {
        let panels = trade.scenes.iter().map(|scene| panel(scene, TIME, sweep_lines(&scene.sweeps[place])));
        groups.push(Group {
            title: format!("{}; rings: nothing else here had less error by then", sweep.name),
            names: names(&sweep.values),
            panels: panels.collect(),
        });
    }
    Sheet { groups }
}

fn names(candidates: &[CandidateResult]) -> Vec<String> {
    candidates.iter().map(|one| one.label.clone()).collect()
}

/// With the single renders.
fn line(one: &CandidateResult, of_median: fn(&Typical) -> f64, of_point: fn(&Checkpoint) -> f64) -> Line {
    let render = |points: &Vec<Checkpoint>| -> Curve {
        points.iter().map(|point| [of_point(point), 100.0 * point.mape]).collect()
    };
    Line { median: median(one, of_median), renders: one.runs.iter().map(render).collect(), front: Vec::new() }
}

fn sweep_lines(sweep: &SweepResult) -> Vec<Line> {
    let front =
        |front: &Vec<[f64; 2]>| front.iter().map(|[seconds, mape]| [*seconds, 100.0 * mape]).collect();
    let values = sweep.values.iter().zip(&sweep.front);
    let line = |(one, of_front): (&CandidateResult, &Vec<[f64; 2]>)| Line {
        median: median(one, |typical| typical.total_seconds),
        renders: Vec::new(),
        front: front(of_front),
    };
    values.map(line).collect()
}

fn median(one: &CandidateResult, x: fn(&Typical) -> f64) -> Curve {
    one.summary.curve.iter().map(|typical| [x(typical), 100.0 * typical.mape]).collect()
}
