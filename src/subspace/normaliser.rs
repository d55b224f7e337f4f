//! Q: how much light the sub-paths of each light subspace carry, the integral of |f_y|.

use rayon::prelude::*;

use super::sources::{SourceLabels, label_of};
use super::training::LightSample;
use super::tree::Tree;

/// Least Q relative to the mean of the subspaces that can occur. A light path that ends where the estimate saw none is
/// connected like any other: with Q = 0 its energy would be lost.
pub const FLOOR: f64 = 1e-3;

/// Estimates of Q, before and after the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Normaliser {
    /// Sum of |w| over the number of light paths.
    pub estimate: Vec<f64>,
    /// Light samples that are no finite, positive light.
    pub faulty: u64,
}

impl Normaliser {
    /// `light_paths`: how many paths the samples come from, those included that carry no light.
    pub fn estimate(
        samples: &[LightSample],
        light_paths: u64,
        labels: &[SourceLabels],
        tree: &Tree,
        subspaces: u32,
    ) -> Self {
        let label = |sample: &LightSample| {
            let sound = sample.weight.is_finite() && sample.weight >= 0.0 && sample.end.is_finite();
            if sound { label_of(labels, &sample.end, tree) } else { u32::MAX }
        };
        let of: Vec<u32> = samples.par_iter().map(label).collect();
        let mut estimate = vec![0.0; subspaces as usize];
        let mut faulty = 0;
        for (sample, label) in samples.iter().zip(of) {
            match estimate.get_mut(label as usize) {
                Some(sum) => *sum += f64::from(sample.weight),
                None => faulty += 1,
            }
        }
        estimate.iter_mut().for_each(|sum| *sum /= light_paths as f64);
        Self { estimate, faulty }
    }

    /// Q with its floor: positive everywhere if any sample carries light.
    pub fn floored(&self, active: &[bool]) -> Vec<f64> {
        let count = active.iter().filter(|a| **a).count().max(1);
        let least = FLOOR * self.estimate.iter().sum::<f64>() / count as f64;
        self.estimate.iter().map(|q| q.max(least)).collect()
    }
}
