//! What the worker tells the window.

use std::sync::Arc;

use crate::film::Picture;
use crate::integrator::{Choice, FirstSubspaces};

/// A picture as it stands, with what is known of it.
#[derive(Clone, Default)]
pub struct Snapshot {
    /// Radiance, with the layers `variance` and `samples`; smaller than was asked for while the camera moves.
    pub picture: Arc<Picture>,
    /// Of the integrator beside it, in a split.
    pub beside: Option<Arc<Picture>>,
    /// Which integrator made the picture.
    pub slot: usize,
    /// The view that it shows, as the wish numbered it.
    pub view: u64,
    /// Counts up with every snapshot.
    pub number: u64,
    /// Of each pixel, where wished for.
    pub subspaces: Option<Arc<Vec<FirstSubspaces>>>,
    pub non_finite: Option<Arc<Vec<u64>>>,
    pub figures: Figures,
}

/// What the panel shows.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Samples a pixel, and seconds of rendering them.
    pub samples: u32,
    pub seconds: f64,
    /// Time for one sample of all pixels.
    pub seconds_a_sample: Option<f64>,
    /// Of them, by kernel, most first.
    pub kernels: Vec<(String, f64)>,
    pub error: Option<f64>,
    /// Seconds and estimated error, as it went.
    pub errors: Vec<[f64; 2]>,
    /// Bytes on the device by buffer, all integrators together, most first.
    pub memory: Vec<(String, u64)>,
    pub non_finite_samples: u64,
    pub non_finite_vertices: u64,
    pub light_vertices: u64,
    pub learnt: Option<Learnt>,
    pub choices: Vec<Choice>,
    /// What is being made in the background, and which share of it is done.
    pub making: Option<Making>,
    /// All that was wished for is rendered.
    pub done: bool,
}

/// What an integrator has learnt.
#[derive(Clone, Debug, Default)]
pub struct Learnt {
    pub subspaces: u32,
    /// Eye subspaces that have learnt something.
    pub used: u64,
    pub paths: u64,
    /// The loss after each lesson over that before it.
    pub losses: Vec<f64>,
    /// For the view that is seen.
    pub of_this_view: bool,
}

/// Work in the background.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Making {
    pub what: String,
    pub share: Option<f32>,
}
