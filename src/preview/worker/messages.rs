//! What the window and the worker send each other.

use std::path::PathBuf;
use std::sync::Arc;

use crate::film::tonemap::ViewTransform;
use crate::scene::{Camera, Scene};

/// What the window is to show. A new request takes the place of the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    pub camera: Camera,
    /// Counts up with every change of the camera.
    pub view: u64,
    /// The camera will change again soon.
    pub moving: bool,
    /// Index into [`METHODS`](crate::integrator::METHODS), as all slots.
    pub slot: usize,
    /// The integrator on the other side of a split.
    pub beside: Option<usize>,
    pub paused: bool,
    /// Samples per pixel after which a picture is complete; `None`: it never is.
    pub samples: Option<u32>,
    /// Snapshots contain the denoised picture, and so do files.
    pub denoised: bool,
    /// Snapshots contain the subspaces of every pixel.
    pub subspaces: bool,
    /// Snapshots contain the count of non-finite samples of every pixel.
    pub non_finite: bool,
    /// The camera as flags of `halfway render`.
    pub camera_flags: String,
}

/// A picture to be saved: as `name-1.exr` and `name-1.png`, or the next number that is free.
#[derive(Clone, Debug)]
pub struct Save {
    pub name: PathBuf,
    pub view: ViewTransform,
    /// Stops.
    pub exposure: f32,
}

/// What the window sends; the worker handles commands in order.
pub(super) enum Command {
    Request(Box<Request>),
    Save(Save),
    /// Drops the samples of all pictures.
    Restart,
    /// Loads the scene again.
    Reload,
    Quit,
}

/// What the worker sends.
pub enum Event {
    Loaded(Arc<Scene>),
    Saved(Saved),
    /// Something failed, in words for the user; the worker goes on.
    Failed(String),
    /// The device is lost, and with it all but the last snapshot. The worker has ended.
    Lost(String),
}

/// A picture that was saved.
pub struct Saved {
    /// EXR, PNG, and the model where there is one.
    pub paths: Vec<PathBuf>,
    pub slot: usize,
    pub view: u64,
    /// Per pixel.
    pub samples: u32,
}
