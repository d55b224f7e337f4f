//! How fast a device is at the moment. Other programs may use it, or its cores: measured times then differ by a factor
//! of two and more from minute to minute, whatever is measured.

use std::time::Duration;

use crate::device::Context;
use crate::integrator::View;
use crate::render::{Budget, RenderError, RenderOptions, Renderer};
use crate::scene::builtin::rooms::cornell;

/// Samples per pixel of the probe, which then takes a tenth of a second or two: a constant, so that figures of several
/// days can be compared.
const SAMPLES_CPU: u32 = 8;
const SAMPLES_GPU: u32 = 1024;
/// Time between two probes.
const PROBE_INTERVAL: Duration = Duration::from_secs(2);
/// Pixels a side.
const SIZE: u32 = 128;

/// The same work again and again: a Cornell box, by path tracing. The unit of work is one sample of each of its pixels.
pub struct SpeedProbe {
    renderer: Renderer,
    /// Per pixel.
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

    /// Seconds that the device takes for a unit of work now.
    ///
    /// # Errors
    /// A lost device.
    pub fn seconds_per_unit(&mut self) -> Result<f64, RenderError> {
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
        let seconds_per_unit = self.seconds_per_unit()?;
        Ok(NormalisedClock { probe: self, seconds_per_unit, seconds: 0.0, work: 0.0 })
    }
}

/// Tells time by the units of work that the device could have done in it.
pub struct NormalisedClock<'a> {
    probe: &'a mut SpeedProbe,
    /// As of the last probe: the speed, the time by the clock on the wall, and the work until then.
    seconds_per_unit: f64,
    seconds: f64,
    work: f64,
}

impl NormalisedClock<'_> {
    /// Whether it is time for a probe, after so many seconds by the clock on the wall.
    pub fn is_due(&self, seconds: f64) -> bool {
        seconds - self.seconds >= PROBE_INTERVAL.as_secs_f64()
    }

    /// Units of work until now, that is after so many seconds: time since the last probe over the mean of the two
    /// speeds. The probe itself takes a moment, which is not counted.
    ///
    /// # Errors
    /// A lost device.
    pub fn work(&mut self, seconds: f64) -> Result<f64, RenderError> {
        let before = std::mem::replace(&mut self.seconds_per_unit, self.probe.seconds_per_unit()?);
        self.work += 2.0 * (seconds - self.seconds) / (before + self.seconds_per_unit);
        self.seconds = seconds;
        Ok(self.work)
    }
}
