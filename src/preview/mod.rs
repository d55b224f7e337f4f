//! The preview window: a picture that gets better while one looks at it and moves about.
//!
//! ```text
//! window (events, frames) -> wishes -> worker (renders by turns) -> snapshots -> panel and picture
//!                                      builder (loads, learns, compiles; on a thread of its own)
//! ```
//!
//! The window's thread never waits for light: it says what it wishes for, and shows the last snapshot there is. All of
//! them use one device; the worker's submissions are short, so that frames come in between.

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
mod watch;
mod window;
pub mod worker;

use std::path::PathBuf;
use std::sync::Arc;

use crate::device::Context;
use crate::film::Picture;
use crate::film::tonemap::View;
use crate::integrator::{METHODS, Method};
use crate::render::RenderOptions;
use crate::scene::{Scene, Viewpoint};

pub use error::PreviewError;
pub use window::{Display, run};

/// Integrators that one can switch between, by the keys 1 to 5.
pub const SLOTS: usize = METHODS.len();

/// Loads the scene again; the error is for the user.
pub type Loader = Box<dyn Fn() -> Result<Arc<Scene>, String> + Send + Sync>;

/// What a window shows, and how.
pub struct Settings {
    pub context: Context,
    pub scene: Arc<Scene>,
    pub camera: Viewpoint,
    pub loader: Loader,
    /// Where the scene comes from: it is loaded anew when one of these changes.
    pub files: Vec<PathBuf>,
    /// Size, seed and depth of all renders; a model and settings of learning, for `Method::SpcBpt`.
    pub options: RenderOptions,
    pub methods: [Method; SLOTS],
    /// Index of the method to begin with.
    pub slot: usize,
    /// Samples after which a picture is good enough.
    pub samples: Option<u32>,
    pub reference: Option<Picture>,
    pub view: View,
    pub exposure: f32,
    /// Pictures are saved beside this name, with a number.
    pub output: PathBuf,
    pub title: String,
    pub command_line: String,
}
