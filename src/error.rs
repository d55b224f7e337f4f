//! One error enum a layer. Every message says what is wrong and what to do next.

use std::path::PathBuf;

use thiserror::Error;

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
