//! film

use std::path::PathBuf;

use thiserror::Error;

use crate::fault::Fault;
use crate::picture_file::PictureFileError;

/// Pictures: reading, writing, comparing.
#[derive(Debug, Error)]
pub enum FilmError {
    #[error(transparent)]
    Input(#[from] PictureFileError),
    #[error(
        "cannot write {path}: {cause}; choose another place or make room (an existing file is left as it was)"
    )]
    Write { path: PathBuf, cause: std::io::Error },
    #[error(
        "cannot show {path}: {count} pixels are NaN or infinite; find them in the EXR, they are a bug to report"
    )]
    NonFinite { path: PathBuf, count: usize },
    #[error(
        "the picture has {} x {} pixels, the reference {} x {}; render at the reference's size (--size)",
        picture[0], picture[1], reference[0], reference[1]
    )]
    Sizes { picture: [u32; 2], reference: [u32; 2] },
    #[error(
        "pixels that are NaN or infinite: {picture} in the picture, {reference} in the reference; no metric can judge \
         them, find their cause first"
    )]
    NonFiniteCompared { picture: usize, reference: usize },
    #[error(
        "the reference is black, so no error is relative to it; check that the reference is the second file"
    )]
    BlackReference,
    #[error(
        "{count} pixels of the reference are negative, so no error is relative to them; take a reference that was \
         rendered without a filter of negative lobes"
    )]
    NegativeReference { count: usize },
    #[error(
        "cannot limit {metric}: the pictures do not say how noisy they are; compare EXR files with variance layers, as \
         `halfway render` writes them, or leave that limit out"
    )]
    MetricUnknown { metric: String },
    #[error("cannot read {path}: {cause}; check that the file is there and readable")]
    SavedRead { path: PathBuf, cause: std::io::Error },
    #[error(
        "{path} is no checkpoint or portion of a render; give a file that --checkpoint or --samples wrote"
    )]
    NotSaved { path: PathBuf },
    #[error(
        "{path} has version {found} of the format, this program reads version {expected}; go on with the program that \
         wrote it, or render again"
    )]
    SavedVersion { path: PathBuf, found: u32, expected: u32 },
    #[error("{path} is damaged: {what}; copy it again from where it came from, or render again")]
    SavedDamaged { path: PathBuf, what: &'static str },
    /// Portions that make no picture together; `reason` ends in what to do.
    #[error("cannot merge {path}: {reason}")]
    Merge { path: PathBuf, reason: String },
    #[error(
        "Open Image Denoise, which --denoise needs, is not to be had: run `tools/setup --denoiser`, or name its folder by \
         HALFWAY_OIDN ({reason})"
    )]
    NoDenoiser { reason: String },
    #[error(
        "Open Image Denoise did not denoise the picture: {reason}; the picture is saved as it was rendered, without the \
         layer `denoised`"
    )]
    Denoiser { reason: String },
    #[error("tev at {address}: {cause}; start the viewer first, or give its address with --tev HOST:PORT")]
    Viewer { address: String, cause: std::io::Error },
}

impl FilmError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Input(error) => error.fault(),
            Self::Sizes { .. }
            | Self::NonFiniteCompared { .. }
            | Self::BlackReference
            | Self::NegativeReference { .. }
            | Self::SavedRead { .. }
            | Self::NotSaved { .. }
            | Self::SavedVersion { .. }
            | Self::SavedDamaged { .. }
            | Self::Merge { .. }
            | Self::MetricUnknown { .. } => Fault::Input,
            Self::Write { .. } | Self::Viewer { .. } | Self::NoDenoiser { .. } | Self::Denoiser { .. } => {
                Fault::Machine
            }
            Self::NonFinite { .. } => Fault::Defect,
        }
    }
}
