//! One door to all ways of learning.

use super::task::{TrainingProgress, TrainingResult, TrainingTask};
use super::{TrainingError, guided, pretrace};
use crate::subspace::{Model, TrainingSet};

/// Learns how to connect in a picture, until `interrupted` says so; it is asked several times per second.
///
/// # Errors
/// A lost device, a scene without light to connect to, [`TrainingError::Interrupted`].
pub fn train(
    task: &TrainingTask,
    mut interrupted: impl FnMut(TrainingProgress) -> bool,
) -> Result<TrainingResult, TrainingError> {
    let go_on =
        |step: TrainingProgress| if interrupted(step) { Err(TrainingError::Interrupted) } else { Ok(()) };
    match task.training.paths {
        Some(paths) => pretrace::train(task, paths, go_on),
        None => guided::train(task, go_on),
    }
}

/// The paths that one iteration of connections using `model` finds, as [`train`] learns from them.
///
/// # Errors
/// As [`train`].
pub fn find_training_paths(task: &TrainingTask, model: &Model) -> Result<TrainingSet, TrainingError> {
    guided::find_paths(task, model)
}
