//! training

use thiserror::Error;

use crate::device::DeviceError;
use crate::fault::Fault;
use crate::subspace::SubspaceError;

/// Finding paths and learning from them.
#[derive(Debug, Error)]
pub enum TrainingError {
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error(transparent)]
    Subspace(#[from] SubspaceError),
    /// By the caller.
    #[error(
        "interrupted while it learnt, so there is nothing to save yet; start it again, or ask for fewer --train-paths"
    )]
    Interrupted,
    #[error(
        "cannot start a thread to learn on ({cause}); end other programs and start it again, or learn first (--learn first)"
    )]
    Thread { cause: std::io::Error },
    #[error(
        "learning broke down, stderr says where; this is a defect of Halfway, please report it, and learn first (--learn first)"
    )]
    Panicked,
}

impl TrainingError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Device(error) => error.fault(),
            Self::Subspace(error) => error.fault(),
            Self::Interrupted => Fault::Interrupted,
            Self::Thread { .. } => Fault::Machine,
            Self::Panicked => Fault::Defect,
        }
    }
}
