//! render

use thiserror::Error;

use crate::accel::AccelError;
use crate::device::DeviceError;
use crate::film::FilmError;

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
        "interrupted while it learnt, so there is nothing to save yet; start it again, or ask for fewer --train-paths"
    )]
    Interrupted,
    /// Comparing the picture with a reference.
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error(transparent)]
    Accel(#[from] AccelError),
    #[error(transparent)]
    Device(#[from] DeviceError),
}
