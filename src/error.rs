//! One error enum a layer. Every message says what is wrong and what to do next.

use std::path::PathBuf;

use thiserror::Error;

/// Reading a scene.
#[derive(Debug, Error)]
pub enum SceneError {
    #[error("cannot read {path}: {source}")]
    Read { path: PathBuf, source: std::io::Error },
    #[error("cannot use the picture {path}: {reason}")]
    Picture { path: PathBuf, reason: String },
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
    #[error(transparent)]
    Input(#[from] SceneError),
    #[error(
        "cannot write {path}: {source}; choose another place or make room (an existing file is left as it was)"
    )]
    Write { path: PathBuf, source: std::io::Error },
    #[error(
        "cannot show {path}: {count} pixels are NaN or infinite; find them in the EXR, they are a bug to report"
    )]
    NonFinite { path: PathBuf, count: usize },
}
