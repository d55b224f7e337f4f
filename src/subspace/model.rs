//! What a training leaves: everything that is fixed while an iteration runs.

use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

use super::connections::{Connections, FirstConnections};
use super::gamma::{Loss, Tried};
use super::guide::LightGuide;
use super::settings::Settings;
use super::sources::{SourceLabels, label_of};
use super::training::{Feature, LightEnd, TrainingInput};
use super::tree::Tree;
use crate::math::MathError;
use crate::math::cutpoints::{Cutpoint, Cutpoints};

/// Classification, Gamma and Q of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Of the scene that it was trained on.
    pub scene_hash: u64,
    /// What it was trained for.
    pub connections: Connections,
    /// What it was trained with.
    pub settings: Settings,
    pub seed: u64,
    /// K, eye subspaces and as many light subspaces.
    pub subspaces: u32,
    pub eye_tree: Tree,
    pub light_tree: Tree,
    /// Of the eye subspaces, and of those of light paths' surfaces.
    pub centroids: [Vec<CentroidMove>; 2],
    /// Of each light of the device's list.
    pub sources: Vec<SourceLabels>,
    /// K x K, a row an eye subspace; every row sums to one, the uniform share mixed in.
    pub gamma: Vec<f32>,
    /// Of each light subspace; positive.
    pub q: Vec<f32>,
    /// Where light paths go; `None` where that is worth nothing.
    pub guide: Option<LightGuide>,
    /// `None`: as many as the render has.
    pub first_connections: Option<FirstConnections>,
    pub report: TrainingReport,
}

/// The position of a centroid, in unit space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentroidMove {
    /// As it was drawn.
    pub drawn: Vec3,
    /// The middle of what is nearest to it.
    pub moved: Vec3,
}

/// Gamma as the device draws from it.
#[derive(Clone, Debug, PartialEq)]
pub struct GammaTables {
    /// K tables of K slots.
    pub entries: Vec<Cutpoint>,
    /// Probability with which the table of the row draws the column, exact to the rounding of f32.
    pub pdf: Vec<f32>,
}

impl Model {
    /// One subspace a side, and a Q that says nothing: any light vertex is as good as its power.
    pub fn untrained(input: &TrainingInput, settings: Settings) -> Self {
        let guide = settings.light_guide.then(|| LightGuide::even(1, input.lights));
        Self {
            scene_hash: input.scene_hash,
            connections: input.connections,
            seed: input.seed,
            settings,
            subspaces: 1,
            eye_tree: Tree::single(0),
            light_tree: Tree::single(0),
            centroids: Default::default(),
            sources: vec![SourceLabels { first: 0, divisions: 1 }; input.lights.len()],
            gamma: vec![1.0],
            q: vec![1.0],
            guide,
            first_connections: None,
            report: TrainingReport::default(),
        }
    }

    pub fn eye_label(&self, feature: &Feature) -> u32 {
        self.eye_tree.label(feature)
    }

    pub fn light_label(&self, end: &LightEnd) -> u32 {
        label_of(&self.sources, end, &self.light_tree)
    }

    /// The table of every row.
    ///
    /// # Errors
    /// A row that is no distribution; no row of a trained or loaded model is.
    pub fn tables(&self) -> Result<GammaTables, MathError> {
        let k = self.subspaces as usize;
        let rows: Vec<(Cutpoints, Vec<f32>)> = self
            .gamma
            .par_chunks(k)
            .map(|row| {
                let weights: Vec<f64> = row.iter().map(|&p| f64::from(p)).collect();
                let table = Cutpoints::new(&weights)?;
                let pdf = (0..k).map(|column| table.pdf_select(column) as f32).collect();
                Ok((table, pdf))
            })
            .collect::<Result<_, MathError>>()?;
        Ok(GammaTables {
            entries: rows.iter().flat_map(|(table, _)| table.entries()).copied().collect(),
            pdf: rows.into_iter().flat_map(|(_, pdf)| pdf).collect(),
        })
    }
}

/// What there was to learn from, and how it went.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TrainingReport {
    pub counts: Counts,
    /// At the start and after each step.
    pub losses: Vec<Loss>,
    /// Index in `losses` of what was kept.
    pub best_step: u32,
    /// What the smoothing of the kept step was chosen from.
    pub tried: Vec<Tried>,
    /// Entropy of the rows of Gamma that were learnt, in bits: least, mean, most.
    pub row_entropy: [f64; 3],
    /// Largest over smallest positive estimate of Q.
    pub q_spread: f64,
    /// Of guided light paths: the mean logarithm of how much denser they are where their light is wanted. Where that is far from
    /// worth it, by a part of the training paths.
    pub guide_gain: f64,
    pub seconds: Seconds,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub paths: u64,
    pub nodes: u64,
    /// Paths that judged the optimisation.
    pub held_out_paths: u64,
    /// Paths and light samples with a number that is negative, infinite or none: a bug to report.
    pub faulty_paths: u64,
    pub faulty_light_samples: u64,
    /// Paths that no strategy makes.
    pub unreachable_paths: u64,
    /// Paths whose contribution was held back as an outlier.
    pub clamped_paths: u64,
    pub light_samples: u64,
    /// Rows with training paths.
    pub learnt_rows: u64,
    /// Light subspaces that can occur.
    pub active_columns: u64,
    /// Of them, those whose Q is the floor.
    pub floored_columns: u64,
    /// Light subspaces that points on lights take.
    pub source_subspaces: u64,
    pub eye_tree_nodes: u64,
    pub light_tree_nodes: u64,
}

/// Time of each part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seconds {
    pub weights: f64,
    pub trees: f64,
    pub labels: f64,
    pub q: f64,
    pub gamma: f64,
    pub guide: f64,
    pub total: f64,
}
