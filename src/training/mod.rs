//! Finding paths to learn from, with the integrators' kernels, before or while pictures are rendered. What is made of them
//! is `subspace`'s.

mod guided;
mod online;
mod pretrace;
mod records;
mod task;

pub use online::{OnlineTraining, PreparedTrainer, TrainingEvent};
pub use task::{
    DEFAULT_ROUNDS, LONG_RENDER_ROUNDS, Training, TrainingProgress, TrainingResult, TrainingTask, WarmStart,
    When, find_training_paths, train,
};
