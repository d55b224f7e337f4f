//! The film of one integrator: it is kept while another is looked at.

use crate::device::DeviceError;
use crate::render::{Estimate, RenderError, Renderer};
use crate::scene::Camera;
use crate::training::WarmStart;

/// Points of the curve of errors at most; then every other one is left out.
const MOST_ERRORS: usize = 400;
/// Sides of a picture are divided by this at most while the camera moves.
const LARGEST_DIVISOR: u32 = 8;

/// A view of the scene.
#[derive(Clone, Debug)]
pub struct Aim {
    pub camera: Camera,
    /// Counts up with every change.
    pub view: u64,
    /// Of the whole picture, pixels.
    pub size: [u32; 2],
}

pub struct Film {
    pub renderer: Renderer,
    /// What it shows; `None` where that is worth nothing.
    view: Option<u64>,
    /// Each side of the picture is divided by this.
    pub divisor: u32,
    estimate: Estimate,
    /// Seconds and estimated error.
    pub errors: Vec<[f64; 2]>,
    /// Time for one sample of the whole picture.
    pub seconds_a_sample: Option<f64>,
    pub known: Option<WarmStart>,
    /// The view that was learnt for.
    pub learnt_view: u64,
}

impl Film {
    /// Of a renderer that was made for that view.
    pub fn new(renderer: Renderer, view: u64, known: Option<WarmStart>) -> Self {
        Self {
            renderer,
            view: Some(view),
            divisor: 1,
            estimate: Estimate::default(),
            errors: Vec::new(),
            seconds_a_sample: None,
            known,
            learnt_view: view,
        }
    }

    /// Shows that view, whole.
    pub fn is_whole(&self, view: u64) -> bool {
        self.view == Some(view) && self.divisor == 1
    }

    pub fn view(&self) -> Option<u64> {
        self.view
    }

    pub fn error(&self) -> Option<f64> {
        self.estimate.error
    }

    /// What is there is no use any more.
    pub fn forget(&mut self) {
        self.view = None;
    }

    /// What a side has to be divided by for a sample in so many seconds.
    pub fn divisor_for(&self, seconds: f64, unknown: u32) -> u32 {
        match self.seconds_a_sample {
            Some(whole) => ((whole / seconds).sqrt().ceil() as u32).clamp(1, LARGEST_DIVISOR),
            None => unknown,
        }
    }

    /// Starts anew where it does not show that view yet, divided by `divisor`.
    pub fn aim(&mut self, aim: &Aim, divisor: u32) -> Result<(), RenderError> {
        if self.view == Some(aim.view) && self.divisor == divisor {
            return Ok(());
        }
        self.view = None;
        let [width, height] = aim.size.map(|side| side.div_ceil(divisor));
        self.renderer.aim(&aim.camera, width, height)?;
        self.view = Some(aim.view);
        self.divisor = divisor;
        self.estimate = Estimate::default();
        self.errors.clear();
        Ok(())
    }

    /// Renders for about so many seconds, whole iterations, but no more than `most` samples. A view that nobody wants any
    /// more is forgotten.
    pub fn step(&mut self, seconds: f64, most: u32) -> Result<(), RenderError> {
        let at_once = self.renderer.samples_at_once();
        let whole = self.divisor == 1;
        let samples = match self.seconds_a_sample {
            _ if !whole => 1,
            Some(one) => ((seconds / one) as u32 / at_once).max(1) * at_once,
            None => at_once,
        };
        let before = self.renderer.elapsed();
        let done = match self.renderer.step(samples.min(most)) {
            Err(RenderError::Device(DeviceError::Abandoned)) => {
                self.forget();
                return Ok(());
            }
            done => done?,
        };
        let taken = (self.renderer.elapsed() - before).as_secs_f64() / f64::from(done.max(1));
        let taken = taken * f64::from(self.divisor * self.divisor);
        // Small pictures say little of large ones, and the last steps more than all before.
        if whole || self.seconds_a_sample.is_none() {
            self.seconds_a_sample = Some(self.seconds_a_sample.map_or(taken, |old| 0.7 * old + 0.3 * taken));
        }
        Ok(())
    }

    /// Estimates the error, unless that was done a moment ago.
    pub fn estimate(&mut self) -> Result<(), RenderError> {
        if self.view.is_none() || self.divisor != 1 || !self.estimate.is_due() {
            return Ok(());
        }
        let renderer = &self.renderer;
        self.estimate.renew(|| renderer.estimated_error())?;
        if let Some(error) = self.estimate.error {
            self.errors.push([self.renderer.elapsed().as_secs_f64(), error]);
        }
        if self.errors.len() > MOST_ERRORS {
            self.errors = self.errors.iter().copied().step_by(2).collect();
        }
        Ok(())
    }
}
