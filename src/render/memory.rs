//! What a picture takes of memory while it is rendered, told before anything is built.

use super::{RenderError, RenderOptions};
use crate::device::Context;
use crate::device::host_memory::free_memory;
use crate::device::layout::{FilmPixel, FirstHitPixel, SAMPLES_A_GROUP};
use crate::device::scene::readable_bytes;
use crate::film::Region;
use crate::film::sums::{PixelSums, SAMPLES_A_FLUSH};
use crate::integrator::wavefront::SPLAT_WORDS;

/// What rounding leaves out of a pixel's six sums, once there is something to round.
const REST_BYTES: u64 = 48;
/// Sums and weight of a pixel's first half, and the colours of both.
const HALF_BYTES: u64 = 56;
/// Radiance, variance and samples of a picture, in f32.
const PICTURE_BYTES: u64 = 28;
/// While it is made: variances in f64. While its error is estimated: moments, and their sums over blocks of 9.
const VARIANCE_BYTES: u64 = 24;
const MOMENT_BYTES: u64 = 72;
/// Albedo, normal and depth, in f32.
const FIRST_HIT_BYTES: u64 = 28;

/// Bytes on the device and on the host at the peak, where nothing but radiance and first hits is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureMemory {
    pub device: u64,
    pub host: u64,
}

impl PictureMemory {
    pub fn of(options: &RenderOptions) -> Self {
        let when = |wanted: bool, bytes: u64| if wanted { bytes } else { 0 };
        let film = size_of::<FilmPixel>() as u64;
        let first_hits = when(options.first_hit_layers, size_of::<FirstHitPixel>() as u64);
        let splats = when(options.method.plan().to_camera, 4 * SPLAT_WORDS as u64);
        let samples = options.budget.samples.unwrap_or(u32::MAX);
        let sums = size_of::<PixelSums>() as u64 + when(samples >= 2 * SAMPLES_A_FLUSH, REST_BYTES);
        // Of the first half, and of a block of groups that are taken one by one.
        let halves = when(options.halves, HALF_BYTES + film);
        // Sums that are on the device still are added to a copy.
        let copy = when(!samples.is_multiple_of(SAMPLES_A_FLUSH), sums);
        let last = match samples >= 2 * SAMPLES_A_GROUP {
            true => MOMENT_BYTES,
            false => VARIANCE_BYTES,
        };
        let layers = first_hits + when(options.first_hit_layers, FIRST_HIT_BYTES);
        let pixels = u64::from(options.view.region().pixels());
        Self {
            device: pixels * (film + splats + first_hits),
            host: pixels * (sums + copy + halves + PICTURE_BYTES + last + layers),
        }
    }

    /// Says so where the picture does not fit into what is free: of a software device's memory, which is the host's, or of
    /// the host's alone.
    ///
    /// # Errors
    /// [`RenderError::PictureTooLarge`].
    pub fn check(&self, context: &Context, options: &RenderOptions) -> Result<(), RenderError> {
        let (needed, free) = match context.is_cpu() {
            true => (self.device + self.host, context.memory),
            false => (self.host, free_memory()),
        };
        match free {
            Some(free) if needed > free => {
                let Region { width, height, .. } = options.view.region();
                let [needed, free] = [needed, free].map(readable_bytes);
                Err(RenderError::PictureTooLarge { width, height, needed, free })
            }
            _ => Ok(()),
        }
    }
}
