//! All figures of a benchmark, as JSON, as CSV and as plots.

use serde::Serialize;

use super::plot::{Curve, Line, Plot};
use super::record::Drift;
use crate::bench::trade::{Point, Summary, Typical, front, summary};
use crate::cli::bench::candidate::{Candidate, Sweep};
use crate::cli::bench::reference::ReferenceFile;
use crate::cli::bench::scene::BenchScene;
use crate::film::metric::ReferenceNoise;

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
    pub knobs: Vec<SweepResult>,
}

/// What a scene was compared with.
#[derive(Serialize)]
pub struct ReferenceResult {
    pub file: String,
    /// It has every so manieth pixel of every so manieth row.
    pub stride: u32,
    pub origin: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checked: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<ReferenceNoise>,
}

/// An integrator with its settings.
#[derive(Serialize)]
pub struct CandidateResult {
    pub label: String,
    /// Of `render`.
    pub flags: String,
    pub summary: Summary,
    /// Seed by seed.
    pub runs: Vec<Vec<Point>>,
}

/// A setting with its values.
#[derive(Serialize)]
pub struct SweepResult {
    pub name: String,
    /// The first is without the setting; ratios are to it.
    pub values: Vec<CandidateResult>,
    /// Of each value its looks on the front of all, `[seconds, MAPE]`.
    pub front: Vec<Vec<[f64; 2]>>,
}

/// What tables ask for.
pub struct Ask<'a> {
    pub target: f64,
    pub times: &'a [f64],
    pub equal_samples: u32,
}

/// Summarises the renders of a scene: `runs` by candidate and seed.
pub fn scene_result(
    subject: &BenchScene,
    reference: &ReferenceFile,
    candidates: &[Candidate],
    listed: usize,
    knobs: &[Sweep],
    runs: Vec<Vec<Vec<Point>>>,
    ask: &Ask,
) -> SceneResult {
    let result = |index: usize, first: usize| {
        let slices = |index: usize| runs[index].iter().map(Vec::as_slice).collect::<Vec<_>>();
        CandidateResult {
            label: candidates[index].label.clone(),
            flags: candidates[index].flags(),
            summary: summary(
                &slices(index),
                &slices(first),
                reference.noise,
                ask.target,
                ask.times,
                ask.equal_samples,
            ),
            runs: runs[index].clone(),
        }
    };
    let place = |one: &Candidate| candidates.iter().position(|other| other.label == one.label);
    let knob = |knob: &Sweep| {
        let places: Vec<usize> = knob.candidates.iter().filter_map(place).collect();
        let values: Vec<CandidateResult> = places.iter().map(|&index| result(index, places[0])).collect();
        let curves: Vec<&[Typical]> = values.iter().map(|value| value.summary.curve.as_slice()).collect();
        SweepResult { name: knob.name.clone(), front: front(&curves), values }
    };
    SceneResult {
        name: subject.name.clone(),
        hash: format!("{:016x}", subject.hash),
        size: [subject.options.view.width, subject.options.view.height],
        reference: ReferenceResult {
            file: reference.path.display().to_string(),
            stride: reference.stride(),
            origin: reference.origin(),
            checked: reference.checked().map(str::to_owned),
            noise: reference.noise,
        },
        integrators: (0..listed).map(|index| result(index, 0)).collect(),
        knobs: knobs.iter().map(knob).collect(),
    }
}

impl SceneResult {
    /// Every candidate once.
    pub fn all(&self) -> impl Iterator<Item = &CandidateResult> {
        let of_knobs = self.knobs.iter().flat_map(|knob| &knob.values);
        let mut seen: Vec<&str> = Vec::new();
        self.integrators.iter().chain(of_knobs).filter(move |one| {
            let is_new = !seen.contains(&one.label.as_str());
            seen.push(&one.label);
            is_new
        })
    }

    /// Which integrator has the least error after that one of the times; `None` where it is one of which that is not
    /// known, as its error was less before.
    pub fn best(&self, place: usize) -> Option<usize> {
        let expected =
            |one: &CandidateResult| one.summary.expected[..=place].iter().flatten().last().copied();
        let last =
            self.integrators.iter().enumerate().filter_map(|(index, one)| Some((index, expected(one)?)));
        let (index, _) = last.min_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
        self.integrators[index].summary.expected[place].map(|_| index)
    }

    /// The least error that is told.
    fn least_error(&self) -> f64 {
        let looks = self.all().flat_map(|one| &one.summary.curve);
        looks.map(|look| look.mape).fold(f64::INFINITY, f64::min)
    }

    /// The reference's own error, where it is too much of the least that is told.
    pub fn noisy_reference(&self) -> Option<f64> {
        let noise = self.reference.noise?.mape;
        (noise > REFERENCE_SHARE * self.least_error()).then_some(noise)
    }

    /// The beginning of the names of its plots.
    pub fn stem(&self) -> String {
        file_name(&self.name)
    }
}

/// Only what any file system and any page takes.
pub fn file_name(text: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c.to_ascii_lowercase() } else { '-' };
    text.chars().map(keep).collect()
}

impl Trade {
    pub fn non_finite(&self) -> u64 {
        let runs = self.scenes.iter().flat_map(SceneResult::all).flat_map(|one| &one.runs);
        runs.filter_map(|points| points.last()).map(|point| point.non_finite).sum()
    }

    /// What a reader has to know before he believes a figure.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for scene in &self.scenes {
            let name = &scene.name;
            match scene.reference.noise {
                None => warnings
                    .push(format!("{name}: nobody knows the reference's own error; it counts as exact")),
                Some(_) => warnings.extend(scene.noisy_reference().map(|error| {
                    format!(
                        "{name}: the reference's own MAPE, {:.2} %, is over a fifth of the least error told, \
                         {:.2} %: the lowest errors are too high; raise --reference-time",
                        100.0 * error,
                        100.0 * scene.least_error()
                    )
                })),
            }
        }
        warnings
    }

    /// Every look at every render.
    pub fn csv(&self) -> String {
        let columns = Point::COLUMNS;
        let mut csv = format!(
            "scene,integrator,seed,{columns},relmse_without_reference_noise,estimated_over_measured\n"
        );
        for scene in &self.scenes {
            let name = scene.name.replace('"', "\"\"");
            let noise = scene.reference.noise.map_or(0.0, |noise| noise.relmse);
            for one in scene.all() {
                for (seed, points) in one.runs.iter().enumerate() {
                    for point in points {
                        let honesty = point.estimated_error.map(|error| (error / point.mape).to_string());
                        csv += &format!(
                            "\"{name}\",\"{}\",{seed},{},{},{}\n",
                            one.label,
                            point.row(),
                            point.relmse - noise,
                            honesty.unwrap_or_default(),
                        );
                    }
                }
            }
        }
        csv
    }

    /// File names and plots.
    pub fn plots(&self) -> Vec<(String, Plot<'_>)> {
        let mut plots = Vec::new();
        for scene in &self.scenes {
            let stem = scene.stem();
            let [width, height] = scene.size;
            for (suffix, x_title, of_median, of_point) in [
                (
                    "time",
                    "seconds, learning included",
                    (|look| look.total_seconds) as fn(&Typical) -> f64,
                    Point::total_seconds as fn(&Point) -> f64,
                ),
                ("samples", "samples a pixel", |look| look.samples, |point| f64::from(point.samples)),
            ] {
                let line = |one: &CandidateResult| Line {
                    name: one.label.clone(),
                    median: median(one, of_median),
                    renders: one
                        .runs
                        .iter()
                        .map(|points| points.iter().map(|p| [of_point(p), 100.0 * p.mape]).collect())
                        .collect(),
                    front: Vec::new(),
                };
                plots.push((
                    format!("{stem}-{suffix}.svg"),
                    self.plot(
                        format!("{}, {width}x{height}", scene.name),
                        x_title,
                        scene.integrators.iter().map(line).collect(),
                    ),
                ));
            }
            for knob in &scene.knobs {
                let line = |(one, front): (&CandidateResult, &Vec<[f64; 2]>)| Line {
                    name: one.label.clone(),
                    median: median(one, |look| look.total_seconds),
                    renders: Vec::new(),
                    front: front.iter().map(|[seconds, mape]| [*seconds, 100.0 * mape]).collect(),
                };
                plots.push((
                    format!("{stem}-{}.svg", file_name(&knob.name)),
                    self.plot(
                        format!("{}, {width}x{height}: {}, rings: the front", scene.name, knob.name),
                        "seconds, learning included",
                        knob.values.iter().zip(&knob.front).map(line).collect(),
                    ),
                ));
            }
        }
        plots
    }

    fn plot<'a>(&self, title: String, x_title: &'a str, lines: Vec<Line>) -> Plot<'a> {
        Plot { title, x_title, y_title: "MAPE, %", level: Some(100.0 * self.target), lines }
    }
}

fn median(one: &CandidateResult, x: fn(&Typical) -> f64) -> Curve {
    one.summary.curve.iter().map(|look| [x(look), 100.0 * look.mape]).collect()
}
