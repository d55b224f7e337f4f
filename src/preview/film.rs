//! The film of one integrator: it is kept while another is seen.

use std::sync::Arc;

use crate::device::DeviceError;
use crate::render::{Estimate, RenderError, Renderer};
use crate::scene::Camera;
use crate::subspace::Model;
use crate::training::WarmStart;

/// Points of the curve of errors at most; then every other one is left out.
const MOST_ERRORS: usize = 400;
/// Sides of a picture are divided by this at most while the camera moves.
const LARGEST_DIVISOR: u32 = 8;

/// A view of the scene.
#[derive(Clone, Debug)]
pub struct Aim {
    pub camera: Camera,
    /// Counts up with every change of the camera.
    pub view: u64,
    /// Of the whole picture, pixels.
    pub size: [u32; 2],
}

/// A renderer, with what it shows and how long that takes.
pub struct Film {
    pub renderer: Renderer,
    /// The view that it shows; `None`: its samples are of no use.
    view: Option<u64>,
    /// Each side of the picture is divided by this.
    pub divisor: u32,
    estimate: Estimate,
    /// Seconds and estimated error.
    pub errors: Vec<[f64; 2]>,
    /// Time for one sample of the whole picture.
    pub seconds_per_sample: Option<f64>,
    /// The same of the first, for which light paths may be traced that others share.
    seconds_of_first: Option<f64>,
    /// For training for another view, where the method trains.
    pub warm_start: Option<WarmStart>,
    /// The view that the model was trained for.
    pub trained_view: u64,
}

impl Film {
    /// Of a renderer that was made for that view.
    pub fn new(renderer: Renderer, view: u64, warm_start: Option<WarmStart>) -> Self {
        Self {
            renderer,
            view: Some(view),
            divisor: 1,
            estimate: Estimate::default(),
            errors: Vec::new(),
            seconds_per_sample: None,
            seconds_of_first: None,
            warm_start,
            trained_view: view,
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

    /// Drops its samples: the next step starts again.
    pub fn forget(&mut self) {
        self.view = None;
    }

    /// What each side has to be divided by for a sample in so many seconds; `unknown` before the first is measured.
    pub fn divisor_for(&self, seconds: f64, unknown: u32) -> u32 {
        match self.seconds_of_first {
            Some(whole) => ((whole / seconds).sqrt().ceil() as u32).clamp(1, LARGEST_DIVISOR),
            None => unknown,
        }
    }

    /// Starts again, unless it shows that view already, divided by `divisor`.
    ///
    /// # Errors
    /// A lost device.
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

    /// Renders for about so many seconds, but no more than `most` samples: one at first, and later as many as the device
    /// likes to have at once, where there is time for them. A step that is abandoned drops all samples.
    ///
    /// # Errors
    /// A lost device, a buffer that does not fit.
    pub fn step(&mut self, seconds: f64, most: u32) -> Result<(), RenderError> {
        let at_once = self.renderer.samples_at_once();
        let whole = self.divisor == 1;
        let samples = match self.seconds_per_sample {
            Some(one) if whole && seconds / one > f64::from(at_once) => {
                (seconds / one) as u32 / at_once * at_once
            }
            Some(one) if whole => ((seconds / one) as u32).max(1),
            _ => 1,
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
        if before.is_zero() && done == 1 && (whole || self.seconds_of_first.is_none()) {
            self.seconds_of_first = Some(taken);
        }
        // Small pictures say little of large ones, and the last steps more than all before.
        if whole || self.seconds_per_sample.is_none() {
            self.seconds_per_sample =
                Some(self.seconds_per_sample.map_or(taken, |old| 0.7 * old + 0.3 * taken));
        }
        Ok(())
    }

    /// Connects using another model from now on. `loss`: that of the new model over that of the old, where it is known;
    /// earlier samples then weigh by it.
    ///
    /// # Errors
    /// A buffer that does not fit.
    pub fn use_model(&mut self, model: Arc<Model>, loss: Option<f64>) -> Result<(), RenderError> {
        self.renderer.connect_by(model)?;
        if let Some(loss) = loss {
            self.renderer.weigh_earlier(loss);
        }
        Ok(())
    }

    /// Estimates the error, unless that was done a moment ago.
    ///
    /// # Errors
    /// A lost device.
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
