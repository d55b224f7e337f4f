//! cli: arguments

use thiserror::Error;

use crate::fault::Fault;

/// Arguments that do not go together, or with the scene.
#[derive(Debug, Error)]
pub enum InputError {
    #[error("{0}")]
    Usage(String),
}

impl InputError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Usage(_) => Fault::Input,
        }
    }
}
