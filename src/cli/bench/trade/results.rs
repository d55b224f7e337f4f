//! All figures of a benchmark, as JSON and as CSV.

use serde::Serialize;

use super::lineup::Lineup;
use crate::bench::trade::{Checkpoint, Typical, front};
use crate::cli::bench::candidate::Candidate;
use crate::cli::bench::reference::ReferenceFile;
use crate::cli::bench::runs::{Ask, CandidateResult, Drift, ReferenceResult};
use crate::cli::bench::scene::BenchScene;
use crate::cli::bench::sweep::Sweep;

/// Share of an error that a reference may have itself before errors are of the reference.
const REFERENCE_SHARE: f64 = 0.2;

/// A benchmark.
#[derive(Serialize)]
pub struct Trade {
    pub date: String,
    pub device: String,
    pub command: String,
    pub version: &'static str,
    /// Renders of each candidate.
    pub seeds: u32,
    /// The budget of each.
    pub seconds: f64,
    /// The same for a render that goes on to the target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<u32>,
    pub target: f64,
    pub times: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
    pub equal_samples: u32,
    pub scenes: Vec<SceneResult>,
}

/// A scene.
#[derive(Serialize)]
pub struct SceneResult {
    pub name: String,
    pub hash: String,
    pub size: [u32; 2],
    pub reference: ReferenceResult,
    /// Those of --integrators; ratios are to the first.
    pub integrators: Vec<CandidateResult>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sweeps: Vec<SweepResult>,
}

/// A setting with its values.
#[derive(Serialize)]
pub struct SweepResult {
    pub name: String,
    /// The first is without the setting; ratios are to it.
    pub values: Vec<CandidateResult>,
    /// Of each value its checkpoints on the front of all, `[seconds, MAPE]`.
    pub front: Vec<Vec<[f64; 2]>>,
}

/// Summarises the renders of a scene: `runs` by candidate and seed.
pub fn scene_result(
    bench_scene: &BenchScene,
    reference: &ReferenceFile,
    lineup: &Lineup,
    runs: Vec<Vec<Vec<Checkpoint>>>,
    ask: &Ask,
) -> SceneResult {
    let result = |index: usize, first: usize| {
        CandidateResult::new(&lineup.all[index], &runs[index], &runs[first], reference.noise, ask)
    };
    let place = |one: &Candidate| lineup.all.iter().position(|other| other.label == one.label);
    let sweep = |sweep: &Sweep| {
        let places: Vec<usize> = sweep.candidates.iter().filter_map(place).collect();
        let values: Vec<CandidateResult> = places.iter().map(|&index| result(index, places[0])).collect();
        let curves: Vec<&[Typical]> = values.iter().map(|value| value.summary.curve.as_slice()).collect();
        SweepResult { name: sweep.name.clone(), front: front(&curves), values }
    };
    SceneResult {
        name: bench_scene.name.clone(),
        hash: format!("{:016x}", bench_scene.hash),
        size: [bench_scene.options.view.width, bench_scene.options.view.height],
        reference: reference.into(),
        integrators: (0..lineup.listed).map(|index| result(index, 0)).collect(),
        sweeps: lineup.sweeps.iter().map(sweep).collect(),
    }
}

impl SceneResult {
    /// Every candidate once.
    pub fn all(&self) -> impl Iterator<Item = &CandidateResult> {
        let of_sweeps = self.sweeps.iter().flat_map(|sweep| &sweep.values);
        let mut seen: Vec<&str> = Vec::new();
        self.integrators.iter().chain(of_sweeps).filter(move |one| {
            let is_new = !seen.contains(&one.label.as_str());
            seen.push(&one.label);
            is_new
        })
    }

    /// Which integrator has the least error after that one of the times, of those that are denoised or of the others; `None`
    /// where it is one of which that is not known, as its error was less before.
    pub fn best(&self, place: usize, denoised: bool) -> Option<usize> {
        let expected =
            |one: &CandidateResult| one.summary.expected[..=place].iter().flatten().last().copied();
        let alike = self.integrators.iter().enumerate().filter(|(_, one)| one.denoised == denoised);
        let last = alike.filter_map(|(index, one)| Some((index, expected(one)?)));
        let (index, _) = last.min_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
        self.integrators[index].summary.expected[place].map(|_| index)
    }

    /// The least error of any checkpoint.
    fn least_error(&self) -> f64 {
        let checkpoints = self.all().flat_map(|one| &one.summary.curve);
        checkpoints.map(|checkpoint| checkpoint.mape).fold(f64::INFINITY, f64::min)
    }

    /// The reference's own error, where it is too much of the least error.
    pub fn noisy_reference(&self) -> Option<f64> {
        let noise = self.reference.noise?.mape;
        (noise > REFERENCE_SHARE * self.least_error()).then_some(noise)
    }
}

impl Trade {
    pub fn non_finite(&self) -> u64 {
        let runs = self.scenes.iter().flat_map(SceneResult::all).flat_map(|one| &one.runs);
        runs.filter_map(|points| points.last()).map(|point| point.non_finite).sum()
    }

    /// What makes figures doubtful.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for scene in &self.scenes {
            let name = &scene.name;
            match scene.reference.noise {
                None => warnings
                    .push(format!("{name}: the reference's own error is not known; it counts as exact")),
                Some(_) => warnings.extend(scene.noisy_reference().map(|error| {
                    format!(
                        "{name}: the reference's own MAPE, {:.2} %, is over a fifth of the least error here, \
                         {:.2} %: the lowest errors are too high; raise --reference-time",
                        100.0 * error,
                        100.0 * scene.least_error()
                    )
                })),
            }
        }
        warnings
    }

    /// Every checkpoint of every render.
    pub fn csv(&self) -> String {
        let columns = Checkpoint::COLUMNS;
        let mut csv = format!(
            "scene,integrator,seed,{columns},relmse_without_reference_noise,estimated_over_measured\n"
        );
        for scene in &self.scenes {
            let name = scene.name.replace('"', "\"\"");
            let noise = scene.reference.noise.map_or(0.0, |noise| noise.relmse);
            for one in scene.all() {
                for (seed, points) in one.runs.iter().enumerate() {
                    for point in points {
                        let calibration = point.estimated_error.map(|error| (error / point.mape).to_string());
                        csv += &format!(
                            "\"{name}\",\"{}\",{seed},{},{},{}\n",
                            one.label,
                            point.row(),
                            point.relmse - noise,
                            calibration.unwrap_or_default(),
                        );
                    }
                }
            }
        }
        csv
    }
}
