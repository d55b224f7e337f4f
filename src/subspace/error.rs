//! subspace

use std::path::PathBuf;

use thiserror::Error;

use crate::fault::Fault;
use crate::film::FilmError;
use crate::math::MathError;

/// Learning the subspaces, and the file they are kept in.
#[derive(Debug, Error)]
pub enum SubspaceError {
    #[error("the setting {name} is {value}; it must lie between {least} and {most}")]
    Setting { name: &'static str, value: f64, least: f64, most: f64 },
    #[error(
        "a training path is in tile {tile}, but the picture has {count}; this is a defect of Halfway, please report it"
    )]
    UnknownTile { tile: u32, count: usize },
    #[error(
        "a path ends on light {light}, but the scene has {count}; this is a defect of Halfway, please report it"
    )]
    UnknownLight { light: u32, count: usize },
    #[error(
        "none of {samples} vertices of {paths} light paths carries light, so there is nothing to connect to; check that \
         the scene's lights shine into it, or render with the path tracer"
    )]
    NoLight { samples: usize, paths: u64 },
    #[error(transparent)]
    Math(#[from] MathError),
    #[error(transparent)]
    Write(#[from] FilmError),
    #[error(
        "cannot read the model {path}: {cause}; check that the file is there and readable, or train again (`halfway \
         train`)"
    )]
    Read { path: PathBuf, cause: std::io::Error },
    #[error(
        "{path} is no model of Halfway's subspaces; give a file that `halfway train` wrote, or train again"
    )]
    NotAModel { path: PathBuf },
    #[error(
        "the model {path} has version {found} of the format, this program reads version {expected}; train again \
         (`halfway train`)"
    )]
    Version { path: PathBuf, found: u32, expected: u32 },
    #[error(
        "the model {path} was trained on another scene (or another state of this one, --env included): {found:016x} \
         where this one is {expected:016x}; train again (`halfway train`)"
    )]
    WrongScene { path: PathBuf, found: u64, expected: u64 },
    #[error(
        "the model {path} is cut off: {found} bytes where {expected} are announced; copy it again, or train again \
         (`halfway train`)"
    )]
    Truncated { path: PathBuf, found: u64, expected: u64 },
    #[error("the model {path} is damaged ({what}); copy it again, or train again (`halfway train`)")]
    Damaged { path: PathBuf, what: &'static str },
}

impl SubspaceError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Setting { .. }
            | Self::NoLight { .. }
            | Self::Read { .. }
            | Self::NotAModel { .. }
            | Self::Version { .. }
            | Self::WrongScene { .. }
            | Self::Truncated { .. }
            | Self::Damaged { .. } => Fault::Input,
            Self::UnknownTile { .. } | Self::UnknownLight { .. } => Fault::Defect,
            Self::Math(error) => error.fault(),
            Self::Write(error) => error.fault(),
        }
    }
}
