//! Pictures of any brightness, in numbers that the filter knows.

use glam::Vec3;

use crate::film::Picture;
use crate::math::color::luminance;
use crate::math::scale::{normalising_exponent, scale_by_power_of_two};

/// The log-average luminance that the filter was trained with, and the edge of the blocks that it is of: Open Image
/// Denoise's own exposure (`core/autoexposure.h`), which takes very dim pictures for black.
const KEY: f64 = 0.18;
const BLOCK: usize = 16;
/// What is brighter, in units of a picture of middle grey, is no longer told apart from what is around it: the largest
/// half float, which the filter's curve ends at.
const BRIGHTEST: f32 = 65504.0;

/// Of the luminances of blocks.
const MOST_APART: f64 = 4096.0;

/// How a picture is scaled before it is filtered: by a power of two, so that all comes back as it was.
pub(super) struct Range {
    exponent: i32,
    input_scale: f32,
}

impl Range {
    pub fn of(picture: &Picture) -> Self {
        let average = log_average(picture);
        let exponent = average.and_then(normalising_exponent).unwrap_or(0);
        let scaled = average.map_or(KEY, |average| scale_by_power_of_two(average, exponent));
        Self { exponent, input_scale: (KEY / scaled) as f32 }
    }

    /// What brings the scaled picture to middle grey.
    pub fn input_scale(&self) -> f32 {
        self.input_scale
    }

    /// The colours, scaled; those that are not finite or negative replaced by their neighbours' mean.
    pub fn apply(&self, picture: &Picture) -> Vec<[f32; 3]> {
        let usable = |pixel: &[f32; 3]| pixel.iter().all(|value| value.is_finite());
        let (width, height) = (picture.width as usize, picture.height as usize);
        let most = BRIGHTEST / self.input_scale;
        let scaled = |pixel: [f32; 3]| {
            pixel
                .map(|value| (scale_by_power_of_two(f64::from(value), self.exponent) as f32).clamp(0.0, most))
        };
        let mean_around = |index: usize| {
            let (x, y) = (index % width, index / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let around = rows
                .flat_map(|y| &picture.rgb[y * width + x.saturating_sub(1)..y * width + (x + 2).min(width)]);
            let (sum, count) =
                around.filter(|pixel| usable(pixel)).fold(([0.0f64; 3], 0.0f64), |(sum, n), pixel| {
                    ([0, 1, 2].map(|c| sum[c] + f64::from(pixel[c])), n + 1.0)
                });
            sum.map(|sum| (sum / count.max(1.0)) as f32)
        };
        let pixels = picture.rgb.iter().enumerate();
        pixels.map(|(index, pixel)| scaled(if usable(pixel) { *pixel } else { mean_around(index) })).collect()
    }

    /// Scales back.
    pub fn undo(&self, colors: &mut [[f32; 3]]) {
        for value in colors.as_flattened_mut() {
            let back = scale_by_power_of_two(f64::from(*value), -self.exponent) as f32;
            *value = if back.is_finite() { back.max(0.0) } else { f32::MAX };
        }
    }
}

/// The geometric mean of the luminances of blocks that have light; a block that outshines the others by far, such as one
/// with a firefly in it, counts as [`MOST_APART`] times their median.
fn log_average(picture: &Picture) -> Option<f64> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let mut stops = Vec::new();
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            let rows = top..(top + BLOCK).min(height);
            let pixels =
                rows.flat_map(|y| &picture.rgb[y * width + left..y * width + (left + BLOCK).min(width)]);
            let lights = pixels
                .map(|&pixel| f64::from(luminance(Vec3::from(pixel))))
                .filter(|light| light.is_finite());
            let (light, pixels) = lights.fold((0.0, 0u32), |(sum, n), light| (sum + light.max(0.0), n + 1));
            if light > 0.0 {
                stops.push((light / f64::from(pixels)).log2());
            }
        }
    }
    stops.sort_unstable_by(f64::total_cmp);
    let median = *stops.get(stops.len() / 2)?;
    let apart = MOST_APART.log2();
    let sum: f64 = stops.iter().map(|stop| stop.clamp(median - apart, median + apart)).sum();
    Some((sum / stops.len() as f64).exp2())
}
