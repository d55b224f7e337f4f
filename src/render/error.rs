//! render

use std::path::PathBuf;

use thiserror::Error;

use crate::accel::AccelError;
use crate::device::DeviceError;
use crate::fault::Fault;
use crate::film::FilmError;
use crate::subspace::SubspaceError;
use crate::training::TrainingError;

/// Rendering a scene to a picture.
#[derive(Debug, Error)]
pub enum RenderError {
    #[error("there is no camera {wanted}: the scene has {count} (numbered from 0); see `halfway info`")]
    NoCamera { wanted: usize, count: usize },
    #[error(
        "the part {part} (left,top,width,height) does not lie in the picture of {width}x{height} pixels; --crop takes \
         X,Y,WIDTH,HEIGHT"
    )]
    BadRegion { part: String, width: u32, height: u32 },
    #[error(
        "{width}x{height} pixels are more than a picture can have; render it in parts with a smaller --size"
    )]
    TooManyPixels { width: u32, height: u32 },
    #[error(
        "a picture of {width}x{height} pixels takes {needed} of memory while it is rendered, and {free} are free; render it in \
         parts (--crop X,Y,WIDTH,HEIGHT), or a smaller one (--size)"
    )]
    PictureTooLarge { width: u32, height: u32, needed: String, free: String },
    #[error(
        "interrupted while it learnt, so there is nothing to save yet; start it again, or ask for fewer --train-paths"
    )]
    Interrupted,
    #[error("interrupted before the first sample was finished, so there is nothing to save")]
    InterruptedAtOnce,
    #[error(
        "not one sample per pixel was finished in the time that was given, so there is no picture; give it a longer \
         --time, a smaller --size, or let paths end sooner with --max-depth"
    )]
    NoSampleInTime,
    #[error("cannot start a thread for {purpose} ({cause}); end other programs and start it again")]
    Thread { purpose: &'static str, cause: std::io::Error },
    #[error("{what} broke down, stderr says where; this is a defect of Halfway, please report it")]
    Panicked { what: &'static str },
    #[error(
        "cannot go on from {path}: it is of another render: {differences}; ask for the same (`halfway resume` does), or \
         render anew without it"
    )]
    OtherRender { path: PathBuf, differences: String },
    #[error("cannot go on from {path}: {what} in it cannot be read; render anew without it")]
    UnknownRun { path: PathBuf, what: &'static str },
    /// Comparing the picture with a reference.
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error(transparent)]
    Accel(#[from] AccelError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error(transparent)]
    Subspace(#[from] SubspaceError),
}

impl RenderError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::NoCamera { .. }
            | Self::BadRegion { .. }
            | Self::TooManyPixels { .. }
            | Self::OtherRender { .. }
            | Self::UnknownRun { .. } => Fault::Input,
            Self::Interrupted | Self::InterruptedAtOnce => Fault::Interrupted,
            Self::PictureTooLarge { .. } | Self::Thread { .. } | Self::NoSampleInTime => Fault::Machine,
            Self::Panicked { .. } => Fault::Defect,
            Self::Film(error) => error.fault(),
            Self::Accel(error) => error.fault(),
            Self::Device(error) => error.fault(),
            Self::Subspace(error) => error.fault(),
        }
    }
}

/// A device that is lost is that, whether it is lost while learning or while rendering: callers match on one variant.
impl From<TrainingError> for RenderError {
    fn from(error: TrainingError) -> Self {
        match error {
            TrainingError::Device(DeviceError::Abandoned) => Self::Interrupted,
            TrainingError::Device(error) => Self::Device(error),
            TrainingError::Subspace(error) => Self::Subspace(error),
            TrainingError::Interrupted => Self::Interrupted,
            TrainingError::Thread { cause } => Self::Thread { purpose: "learning", cause },
            TrainingError::Panicked => Self::Panicked { what: "learning" },
        }
    }
}
