//! The settings of a training.

use serde::Serialize;

use super::tree::MAX_DEPTH;
use crate::subspace::SubspaceError;

/// Most subspaces per side: Gamma then has 16 million entries.
pub const MOST_SUBSPACES: u32 = 4000;
/// Training nodes for each (eye, light) pair of subspaces, when the number of subspaces follows from the training set.
/// With fewer, Gamma learns the paths instead of the scene; without smoothing that would begin at about 40.
const NODES_PER_PAIR: f64 = 5.0;
/// Most of them then: twice as many hardly lower the loss, however much there is to learn from, and cost time.
pub const MOST_FOLLOWED: u32 = 300;

/// How Gamma is improved from the contribution matrix on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Optimiser {
    /// Majorise and minimise: no step size, never raises the loss.
    #[default]
    Mm,
    /// Adam on the logits of a masked softmax.
    Softmax,
    /// Entropic mirror descent with backtracking.
    Mirror,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Eye subspaces, and as many light subspaces; `None`: as many as the training set can teach.
    pub subspaces: Option<u32>,
    /// Share of the light subspaces that is reserved for points on lights.
    pub source_share: f64,
    /// Weight of the incident direction in the classification's distance, relative to the normal's; 0: it does not count.
    pub direction_weight: f32,
    /// Steps that move the centroids to the middle of what is nearest to them.
    pub lloyd_steps: u32,
    pub tree_depth: u32,
    /// A tree is finished when so much of the samples' weight gets the label of its nearest centroid.
    pub tree_stop: f64,
    /// Most samples that a tree is grown from.
    pub tree_samples: u32,
    /// Share of every row of Gamma that goes evenly to all light subspaces, whatever was learnt.
    pub uniform_share: f64,
    /// Share of what is left that goes to them by their power: bright light that training paths did not meet would make
    /// fireflies.
    pub power_share: f64,
    /// Share of what neighbouring subspaces have learnt in every step of Gamma; `None`: what suits the held-out paths.
    pub smoothing: Option<f64>,
    /// Light paths are guided, where that is worth it.
    pub light_guide: bool,
    pub optimiser: Optimiser,
    pub max_steps: u32,
    /// Share of the paths that judges the steps instead of teaching them.
    pub held_out: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            subspaces: None,
            source_share: 0.1,
            direction_weight: 0.0,
            lloyd_steps: 5,
            tree_depth: 15,
            tree_stop: 0.99,
            tree_samples: 100_000,
            uniform_share: 0.1,
            power_share: 0.02,
            smoothing: None,
            light_guide: true,
            optimiser: Optimiser::Mm,
            max_steps: 20,
            held_out: 0.1,
        }
    }
}

/// Of which the kernels still see every subspace's part, in single precision.
pub const LEAST_UNIFORM_SHARE: f64 = 1e-6;

impl Settings {
    /// Subspaces per side for so many training nodes.
    pub fn subspaces_for(&self, nodes: usize) -> u32 {
        let followed = (nodes as f64 / NODES_PER_PAIR).sqrt() as u32;
        self.subspaces.unwrap_or(followed.clamp(2, MOST_FOLLOWED))
    }

    /// # Errors
    /// A number out of its range.
    pub fn check(&self) -> Result<(), SubspaceError> {
        let share = |name: &'static str, value: f64, most: f64| {
            // Written so that NaN fails.
            if value >= 0.0 && value <= most {
                Ok(())
            } else {
                Err(SubspaceError::Setting { name, value, least: 0.0, most })
            }
        };
        share("source_share", self.source_share, 1.0)?;
        share("direction_weight", f64::from(self.direction_weight), 1e6)?;
        share("tree_depth", f64::from(self.tree_depth), f64::from(MAX_DEPTH))?;
        share("lloyd_steps", f64::from(self.lloyd_steps), 100.0)?;
        share("tree_stop", self.tree_stop, 1.0)?;
        share("held_out", self.held_out, 0.9)?;
        share("smoothing", self.smoothing.unwrap_or(0.0), 1.0)?;
        if !(self.uniform_share >= LEAST_UNIFORM_SHARE && self.uniform_share <= 1.0) {
            // Without it a light subspace may become unreachable: energy would be lost.
            return Err(SubspaceError::Setting {
                name: "uniform_share",
                value: self.uniform_share,
                least: LEAST_UNIFORM_SHARE,
                most: 1.0,
            });
        }
        share("power_share", self.power_share, 1.0)?;
        let count = |name: &'static str, value: u32, most: u32| {
            if (1..=most).contains(&value) {
                return Ok(());
            }
            Err(SubspaceError::Setting { name, value: f64::from(value), least: 1.0, most: f64::from(most) })
        };
        count("subspaces", self.subspaces.unwrap_or(1), MOST_SUBSPACES)
    }
}
