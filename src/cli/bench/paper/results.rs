//! All figures of the comparison, as JSON.

use serde::Serialize;

use super::{MORE_SAMPLES, PUBLISHED, methods};
use crate::bench::trade::{Checkpoint, Estimate};
use crate::cli::bench::candidate::Candidate;
use crate::cli::bench::runs::{Ask, CandidateResult, Drift, ReferenceResult, SceneRenders};
use crate::math::statistics::{median, median_interval};

/// The comparison.
#[derive(Serialize)]
pub struct Paper {
    pub date: String,
    pub device: String,
    pub command: String,
    pub version: &'static str,
    /// Renders of each.
    pub seeds: u32,
    /// The budget of each, and of those that go on to 12 %.
    pub seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest: Option<f64>,
    pub inset_seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
    pub scenes: Vec<SceneResult>,
}

/// A scene.
#[derive(Serialize)]
pub struct SceneResult {
    pub name: String,
    pub hash: String,
    pub size: [u32; 2],
    pub reference: ReferenceResult,
    /// As published and as it is by turns, in the order of [`methods`].
    pub candidates: Vec<CandidateResult>,
    pub more: Vec<More>,
    #[serde(skip)]
    runs: Vec<Vec<Vec<Checkpoint>>>,
}

/// A method by records with more light paths or more records.
#[derive(Serialize)]
pub struct More {
    pub method: &'static str,
    pub with: String,
    pub flags: String,
    /// The device holds its tables.
    pub fits: bool,
    /// Seed by seed.
    pub runs: Vec<Vec<Checkpoint>>,
}

impl More {
    fn of(&self, value: fn(&Checkpoint) -> f64) -> Option<Estimate> {
        let ends: Vec<f64> = self.runs.iter().filter_map(|points| points.last()).map(value).collect();
        (!ends.is_empty()).then(|| Estimate {
            value: median(&ends),
            interval: median_interval(&ends),
            extrapolated: false,
        })
    }

    /// After all its samples.
    pub fn mape(&self) -> Option<Estimate> {
        debug_assert!(self.runs.iter().flatten().all(|point| point.samples <= MORE_SAMPLES));
        self.of(|point| point.mape)
    }

    pub fn seconds(&self) -> Option<Estimate> {
        self.of(Checkpoint::total_seconds)
    }
}

impl SceneResult {
    /// Not [summarised](Self::summarise) yet. `runs` by candidate and seed.
    pub fn new(
        renders: &SceneRenders,
        candidates: &[Candidate],
        runs: Vec<Vec<Vec<Checkpoint>>>,
        more: Vec<More>,
    ) -> Self {
        debug_assert_eq!(candidates.len(), runs.len());
        let view = renders.bench_scene.options.view;
        Self {
            name: renders.bench_scene.name.clone(),
            hash: format!("{:016x}", renders.bench_scene.hash),
            size: [view.width, view.height],
            reference: (&renders.reference).into(),
            candidates: Vec::new(),
            more,
            runs,
        }
    }

    /// Every render.
    pub fn runs(&self) -> impl Iterator<Item = &[Checkpoint]> {
        let more = self.more.iter().flat_map(|more| &more.runs);
        self.runs.iter().flatten().chain(more).map(Vec::as_slice)
    }

    /// Figures at the usual speed of the device.
    pub fn summarise(&mut self, candidates: &[Candidate], seconds_per_unit: f64, ask: &Ask) {
        let at_usual_speed = |runs: &mut Vec<Vec<Checkpoint>>| {
            runs.iter_mut().flatten().for_each(|point| *point = point.at_speed(seconds_per_unit));
        };
        self.runs.iter_mut().for_each(at_usual_speed);
        self.more.iter_mut().for_each(|more| at_usual_speed(&mut more.runs));
        let noise = self.reference.noise;
        // Ratios are to SPCBPT, which comes last: as published and as it is.
        let first = |index: usize| &self.runs[self.runs.len() - 2 + index % 2];
        let result = |(index, one): (usize, &Candidate)| {
            CandidateResult::new(one, &self.runs[index], first(index), noise, ask)
        };
        self.candidates = candidates.iter().enumerate().map(result).collect();
    }

    /// A method with its figures as published and as it is.
    pub fn methods(&self) -> impl Iterator<Item = (&'static str, [&CandidateResult; 2])> {
        let pairs = self.candidates.as_chunks::<2>().0;
        methods().zip(pairs).map(|(name, [published, shipped])| {
            debug_assert!(published.label.contains(PUBLISHED) && shipped.label == name);
            (name, [published, shipped])
        })
    }
}
