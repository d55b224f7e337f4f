//! math

use thiserror::Error;

use crate::fault::Fault;

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

impl MathError {
    /// Whose fault it is: callers leave out what has no weight, so only sizes are the scene's.
    pub fn fault(&self) -> Fault {
        match self {
            Self::TooManyWeights { .. } => Fault::Input,
            Self::NoWeights | Self::BadWeight { .. } | Self::AllWeightsZero { .. } => Fault::Defect,
        }
    }
}
