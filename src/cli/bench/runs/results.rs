//! The renders of an integrator and of a scene, summarised.

use serde::Serialize;

use crate::bench::trade::{Checkpoint, Summary, summary};
use crate::cli::bench::candidate::Candidate;
use crate::cli::bench::reference::ReferenceFile;
use crate::film::metric::ReferenceNoise;

/// An integrator with its settings.
#[derive(Serialize)]
pub struct CandidateResult {
    pub label: String,
    /// Of `render`.
    pub flags: String,
    /// Its pictures are denoised.
    pub denoised: bool,
    pub summary: Summary,
    /// Seed by seed.
    pub runs: Vec<Vec<Checkpoint>>,
}

/// What the figures are of.
pub struct Ask<'a> {
    pub target: f64,
    pub times: &'a [f64],
    pub equal_samples: u32,
}

impl CandidateResult {
    /// `runs`, of which there are some; `first`: those that ratios are to.
    pub fn new(
        candidate: &Candidate,
        runs: &[Vec<Checkpoint>],
        first: &[Vec<Checkpoint>],
        noise: Option<ReferenceNoise>,
        ask: &Ask,
    ) -> Self {
        let of_this: Vec<&[Checkpoint]> = runs.iter().map(Vec::as_slice).collect();
        let of_first: Vec<&[Checkpoint]> = first.iter().map(Vec::as_slice).collect();
        Self {
            label: candidate.label.clone(),
            flags: candidate.flags(),
            denoised: candidate.denoise,
            summary: summary(&of_this, &of_first, noise, ask.target, ask.times, ask.equal_samples),
            runs: runs.to_vec(),
        }
    }
}

/// What a scene was compared with.
#[derive(Serialize)]
pub struct ReferenceResult {
    pub file: String,
    /// It has every pixel of this number, of every row of this number; 1: all.
    pub stride: u32,
    pub origin: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checked: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<ReferenceNoise>,
}

impl From<&ReferenceFile> for ReferenceResult {
    fn from(reference: &ReferenceFile) -> Self {
        Self {
            file: reference.path.display().to_string(),
            stride: reference.stride(),
            origin: reference.origin(),
            checked: reference.checked().map(str::to_owned),
            noise: reference.noise,
        }
    }
}
