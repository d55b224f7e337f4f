//! What a model is worth, measured using paths that another one found.

use std::ops::Range;

use rayon::prelude::*;

use super::model::Model;
use super::prepare::weigh;
use super::training::TrainingSet;
use crate::subspace::SubspaceError;

impl Model {
    /// Density of a path by all strategies together, with this model, over the density p that it was found with.
    pub fn path_density(&self, set: &TrainingSet, path: usize) -> f64 {
        let by_connection = set.nodes()[set.nodes_of(path)].iter().map(|node| {
            let (row, column) = (self.eye_label(&node.eye), self.light_label(&node.light));
            let share = f64::from(self.gamma[(row * self.subspaces + column) as usize]);
            share / f64::from(self.q[column as usize]) * f64::from(node.mass)
        });
        f64::from(set.paths()[path].p0) + by_connection.sum::<f64>()
    }
}

/// The loss sum W / D by a model, over that of the model which found the paths (and so has D = 1 for each of them).
/// 1 where nothing was found.
///
/// # Errors
/// A tile or a light that does not exist.
pub fn relative_loss(model: &Model, set: &TrainingSet, found: Range<usize>) -> Result<f64, SubspaceError> {
    let weighed = weigh(set, model.sources.len(), &model.settings, model.seed)?;
    let losses = found.into_par_iter().map(|path| {
        let squared = weighed.paths[path].squared;
        let density = model.path_density(set, path);
        // Without a strategy that makes it the loss would be infinite, and hide the others.
        if squared > 0.0 && density > 0.0 { [squared / density, squared] } else { [0.0; 2] }
    });
    // In order: the sum does not depend on the number of threads.
    let losses: Vec<[f64; 2]> = losses.collect();
    let [by_model, by_finder] = [0, 1].map(|which| losses.iter().map(|loss| loss[which]).sum::<f64>());
    Ok(if by_finder > 0.0 { by_model / by_finder } else { 1.0 })
}
