//! The unit in which light that reaches the camera is summed.

use super::iterate::Light;
use super::{Bidirectional, PILOT_PATHS, PILOT_SAMPLE};
use crate::device::layout::Batch;
use crate::device::{Context, DeviceError};
use crate::integrator::wavefront::SPLAT_WORDS;

/// Where a pixel counts what was lost: `shaders/bind/splats.wgsl`.
const LOST: usize = SPLAT_WORDS - 1;
/// Binary logarithm of the unit, at scale one: `shaders/lib/splat.wgsl`.
const UNIT: i32 = -44;
/// A mean radiance of the picture, as a power of two, that needs no finer unit: it is 2^20 units.
const DIM: i32 = -24;
/// What the mean of a dimmer picture is brought to: 2^23 units, and a single contribution may be 2^39 times as much.
const WANTED: i32 = -21;
/// Powers of two by which the unit is made finer until something is seen.
const STEPS: [i32; 4] = [0, 32, 64, 96];
/// Surfaces whose light tells how bright a picture is: more is a matter of a power of two or three.
const DEEP_ENOUGH: u32 = 32;
/// Units in sight that tell how bright a picture is.
const ENOUGH: f64 = 16.0;

impl Bidirectional {
    /// Makes the unit fit the picture's brightness, which paths tell that no picture is made of: the strongest light may be
    /// 10^18 times as bright as what it lights.
    ///
    /// # Errors
    /// A lost device.
    pub(super) fn choose_splat_scale(&mut self, context: &Context) -> Result<(), DeviceError> {
        self.sees_light = false;
        for step in STEPS {
            self.wavefront.splat_scale = 2f32.powi(step);
            let (units, lost) = self.pilot_units(context)?;
            if lost > 0.0 {
                // Something is so bright that this unit is too fine, and was below the one before.
                break;
            }
            if units < ENOUGH {
                continue;
            }
            self.sees_light = true;
            let pixels = f64::from(self.wavefront.settings.view.region().pixels());
            let mean = (units / (3.0 * pixels)).log2().floor() as i32 + UNIT - step;
            self.wavefront.splat_scale = if mean < DIM { 2f32.powi(WANTED - mean) } else { 1.0 };
            return Ok(());
        }
        self.wavefront.splat_scale = 1.0;
        Ok(())
    }

    /// Units of all channels of all pixels that the pilot's light paths bring, and contributions that did not fit.
    fn pilot_units(&mut self, context: &Context) -> Result<(f64, f64), DeviceError> {
        let most = match self.cached_paths {
            0 => PILOT_PATHS,
            cached => cached.min(PILOT_PATHS),
        };
        let template = self.complete(self.wavefront.batches(PILOT_SAMPLE, 1)[0], most);
        let max_depth = template.max_depth.min(DEEP_ENOUGH);
        self.wavefront.clear_splats(context);
        let batch = Batch { first_light_path: 0, pixel_count: most, sample_count: 1, max_depth, ..template };
        self.trace_light_batch(context, &batch, Light::CameraAndCache)?;
        let mut sums = (0.0, 0.0);
        self.wavefront.read_splats(context, |_, pixels| {
            for pixel in pixels {
                let high = pixel[..LOST].iter().skip(1).step_by(2).map(|&word| f64::from(word)).sum::<f64>();
                let low = pixel[..LOST].iter().step_by(2).map(|&word| f64::from(word)).sum::<f64>();
                sums.0 += high * 2f64.powi(32) + low;
                sums.1 += f64::from(pixel[LOST]);
            }
        })?;
        self.wavefront.drop_unfinished(context, None)?;
        Ok(sums)
    }
}
