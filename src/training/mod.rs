//! Finding paths to learn from, with the integrators' kernels, before or while pictures are rendered. What is made of them
//! is `subspace`'s.

mod error;
mod first_connections;
mod guided;
mod online;
mod options;
mod pretrace;
mod records;
mod task;
mod train;

pub use error::TrainingError;
pub use online::{OnlineTraining, PreparedTrainer, TrainingEvent};
pub use options::{DEFAULT_ROUNDS, LONG_RENDER_ROUNDS, MOST_ROUNDS, Training, When};
pub use task::{TrainingProgress, TrainingResult, TrainingTask, WarmStart};
pub use train::{find_training_paths, train};
