//! cli: arguments

use thiserror::Error;

use crate::fault::Fault;
use crate::scene::ViewpointError;

/// Arguments that do not go together, or with the scene.
#[derive(Debug, Error)]
pub enum InputError {
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Viewpoint(#[from] ViewpointError),
}

impl InputError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Usage(_) => Fault::Input,
            Self::Viewpoint(error) => error.fault(),
        }
    }
}
