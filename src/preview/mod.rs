//! The preview window: a picture that gets better while the camera moves about.
//!
//! ```text
//! window (events, frames) -> requests -> worker (renders in steps) -> snapshots -> panel and picture
//!                                        builder (loads, trains, compiles; on a thread of its own)
//! ```
//!
//! The window's thread never waits for a render: it sends requests, and shows the last snapshot. All threads use one
//! device; the worker's submissions are short, so that frames come in between.

mod builder;
mod canvas;
pub mod controls;
mod display;
mod error;
mod film;
mod frames;
mod gui;
mod panel;
mod saving;
pub mod snapshot;
mod textures;
mod watch;
mod window;
pub mod worker;

use std::path::PathBuf;
use std::sync::Arc;

use crate::device::Context;
use crate::film::Picture;
use crate::film::tonemap::ViewTransform;
use crate::integrator::{METHODS, Method};
use crate::render::RenderOptions;
use crate::scene::{Scene, Viewpoint};

pub use error::PreviewError;
pub use window::{Display, run};

/// Integrators that the window switches between: a slot is an index into [`METHODS`].
pub const SLOTS: usize = METHODS.len();

/// Loads the scene again; the error is a message for the user.
pub type Loader = Box<dyn Fn() -> Result<Arc<Scene>, String> + Send + Sync>;

/// What a window shows, and how.
pub struct Settings {
    pub context: Context,
    pub scene: Arc<Scene>,
    pub camera: Viewpoint,
    pub loader: Loader,
    /// The scene's files: it is loaded again when one of these changes.
    pub files: Vec<PathBuf>,
    /// Size, seed and depth of all renders; a model and settings of training, for methods that learn.
    pub options: RenderOptions,
    /// In the order of [`METHODS`], with their settings.
    pub methods: [Method; SLOTS],
    /// The method to begin with.
    pub slot: usize,
    /// Samples per pixel after which a picture is complete; `None`: it never is.
    pub samples: Option<u32>,
    /// A picture of the same size to compare with.
    pub reference: Option<Picture>,
    pub view: ViewTransform,
    /// Stops.
    pub exposure: f32,
    /// Pictures are saved beside this name, with a number.
    pub output: PathBuf,
    pub title: String,
    /// For the metadata of saved pictures.
    pub command_line: String,
}
