//! How fast a device is at the moment. Others may share it, or its cores: measured times then differ by a factor of two and
//! more from minute to minute, whatever is measured.

use std::time::Duration;

use crate::device::Context;
use crate::integrator::View;
use crate::render::{Budget, RenderError, RenderOptions, Renderer};
use crate::scene::builtin::rooms::cornell;

/// Samples a pixel of the work, which then takes a tenth of a second or two: always as many, so that figures of several
/// days can be compared.
const SAMPLES_CPU: u32 = 8;
const SAMPLES_GPU: u32 = 1024;
/// Time between two looks at how fast the device is.
const LOOKS_APART: Duration = Duration::from_secs(2);
/// Pixels a side.
const SIZE: u32 = 128;

/// The same work again and again: a Cornell box, by path tracing.
pub struct SpeedProbe {
    renderer: Renderer,
    /// A pixel.
    samples: u32,
}

impl SpeedProbe {
    /// Compiles.
    ///
    /// # Errors
    /// A lost device, a kernel that does not compile.
    pub fn new(context: &Context) -> Result<Self, RenderError> {
        let options = RenderOptions {
            view: View { width: SIZE, height: SIZE, ..View::default() },
            ..RenderOptions::default()
        };
        let samples = if context.is_cpu() { SAMPLES_CPU } else { SAMPLES_GPU };
        Ok(Self { renderer: Renderer::new(context, &cornell(), options)?, samples })
    }

    /// Seconds for a sample of every pixel: the less, the faster the device is now.
    ///
    /// # Errors
    /// A lost device.
    pub fn pace(&mut self) -> Result<f64, RenderError> {
        self.renderer.restart(0, None)?;
        self.renderer.set_budget(Budget { samples: Some(self.samples), ..Budget::default() });
        self.renderer.run(|_| false)?;
        Ok(self.renderer.elapsed().as_secs_f64() / f64::from(self.samples))
    }

    /// A clock that starts at zero.
    ///
    /// # Errors
    /// A lost device.
    pub fn clock(&mut self) -> Result<NormalisedClock<'_>, RenderError> {
        let pace = self.pace()?;
        Ok(NormalisedClock { gauge: self, pace, seconds: 0.0, work: 0.0 })
    }
}

/// Tells time by the work that the device could have done in it, as many times that of the gauge.
pub struct NormalisedClock<'a> {
    gauge: &'a mut SpeedProbe,
    /// When it was looked at last: the pace, and what clocks said.
    pace: f64,
    seconds: f64,
    work: f64,
}

impl NormalisedClock<'_> {
    /// Whether it is time to look, after so many seconds by the clock on the wall.
    pub fn is_due(&self, seconds: f64) -> bool {
        seconds - self.seconds >= LOOKS_APART.as_secs_f64()
    }

    /// The work until now, that is after so many seconds. This takes a moment, which is not counted.
    ///
    /// # Errors
    /// A lost device.
    pub fn work(&mut self, seconds: f64) -> Result<f64, RenderError> {
        let before = std::mem::replace(&mut self.pace, self.gauge.pace()?);
        self.work += 2.0 * (seconds - self.seconds) / (before + self.pace);
        self.seconds = seconds;
        Ok(self.work)
    }
}
