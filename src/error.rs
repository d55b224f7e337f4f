//! One error enum a layer. Every message says what is wrong and what to do next.

use std::path::PathBuf;

use thiserror::Error;

/// Mathematics on the host.
#[derive(Debug, PartialEq, Error)]
pub enum MathError {
    #[error(
        "nothing to draw from: the list of weights is empty; skip the distribution where there is no entry"
    )]
    NoWeights,
    #[error("{count} weights are more than the {max} that a table can hold; merge entries")]
    TooManyWeights { count: usize, max: usize },
    #[error("weight {index} is {weight}; weights must be finite and not negative")]
    BadWeight { index: usize, weight: f64 },
    #[error(
        "all {count} weights are zero, so none can be drawn; skip the distribution where nothing has weight"
    )]
    AllWeightsZero { count: usize },
}

/// Reading a scene.
#[derive(Debug, Error)]
pub enum SceneError {
    #[error("cannot read {path}: {source}")]
    Read { path: PathBuf, source: std::io::Error },
}

/// Building the acceleration structure.
#[derive(Debug, Error)]
pub enum AccelError {}

/// The device, its shaders and its memory.
#[derive(Debug, Error)]
pub enum DeviceError {}

/// Pictures: reading, writing, comparing.
#[derive(Debug, Error)]
pub enum FilmError {
    #[error("cannot read {path}: {source}")]
    Read { path: PathBuf, source: std::io::Error },
}
