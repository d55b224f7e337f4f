//! What goes wrong in the preview window.

use thiserror::Error;

use crate::device::DeviceError;
use crate::fault::Fault;
use crate::render::RenderError;
use crate::scene::ViewpointError;

/// See the module.
#[derive(Debug, Error)]
pub enum PreviewError {
    #[error(
        "there is no desktop to open a window on ({message}); on a server, render to a file: halfway render SCENE -o \
         out.exr"
    )]
    NoDisplay { message: String },
    #[error(
        "the window cannot be shown ({message}); render to a file in its place: halfway render SCENE -o out.exr"
    )]
    Window { message: String },
    #[error("the window was closed before it had opened; start it again")]
    NeverOpened,
    #[error("the device was lost ({message}); what was seen last is saved, with the samples that it had")]
    Lost { message: String },
    #[error(transparent)]
    Input(#[from] ViewpointError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl PreviewError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::NoDisplay { .. } | Self::Window { .. } | Self::NeverOpened | Self::Lost { .. } => {
                Fault::Machine
            }
            Self::Input(error) => error.fault(),
            Self::Render(error) => error.fault(),
            Self::Device(error) => error.fault(),
        }
    }
}
