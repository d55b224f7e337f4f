//! The host's half of the film: sums in f64, so that no number of samples stalls them (N-18).

use super::{Layer, Picture};

/// The device's f32 sums are taken over after every so many samples a pixel, counted from the first: the rounding
/// stays below 1e-5, and the result does not depend on how a render was cut into rounds.
pub const SAMPLES_A_FLUSH: u32 = 64;

/// A pixel's sums as the device hands them over, in device units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSums {
    pub sum: [f64; 3],
    pub sum_sq: [f64; 3],
    pub count: u64,
    pub non_finite: u64,
}

/// Sums over all samples of every pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmSums {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<PixelSums>,
}

impl FilmSums {
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![PixelSums::default(); width as usize * height as usize] }
    }

    /// Adds what the device has gathered, one entry a pixel.
    pub fn add(&mut self, taken: impl Iterator<Item = PixelSums>) {
        for (pixel, taken) in self.pixels.iter_mut().zip(taken) {
            for channel in 0..3 {
                pixel.sum[channel] += taken.sum[channel];
                pixel.sum_sq[channel] += taken.sum_sq[channel];
            }
            pixel.count += taken.count;
            pixel.non_finite += taken.non_finite;
        }
    }

    /// Samples left out because they were not finite.
    pub fn non_finite(&self) -> u64 {
        self.pixels.iter().map(|pixel| pixel.non_finite).sum()
    }

    /// Radiance, with the layers `variance` (of the mean) and `samples`. `radiance_scale` turns device units into
    /// the scene's.
    pub fn picture(&self, radiance_scale: f64) -> Picture {
        let mean = |pixel: &PixelSums, channel: usize| match pixel.count {
            0 => 0.0,
            count => (pixel.sum[channel] / count as f64 * radiance_scale) as f32,
        };
        let rgb = self.pixels.iter().map(|pixel| [0, 1, 2].map(|channel| mean(pixel, channel))).collect();
        let mut picture = Picture::new(self.width, self.height, rgb);
        let variance = |channel: usize| {
            let scale_sq = radiance_scale * radiance_scale;
            self.pixels.iter().map(|pixel| (pixel.variance(channel) * scale_sq) as f32).collect()
        };
        picture.layers.push(Layer {
            name: "variance".into(),
            channels: ["R", "G", "B"]
                .iter()
                .enumerate()
                .map(|(i, name)| (name.to_string(), variance(i)))
                .collect(),
        });
        let samples = self.pixels.iter().map(|pixel| pixel.count as f32).collect();
        picture.layers.push(Layer { name: "samples".into(), channels: vec![("Y".into(), samples)] });
        picture
    }

    /// Estimated error of the picture: the expected MAPE against the truth, with an epsilon of 1 % of the picture's
    /// mean as `compare` has it, were every pixel's mean normally distributed with its estimated variance. `None`
    /// before two samples a pixel. Light that no sample has found yet is not in it.
    pub fn estimated_error(&self) -> Option<f64> {
        if self.pixels.iter().any(|pixel| pixel.count < 2) {
            return None;
        }
        let means: Vec<[f64; 3]> =
            self.pixels.iter().map(|p| p.sum.map(|sum| sum / p.count as f64)).collect();
        let total: f64 = means.iter().flatten().sum();
        let epsilon = 0.01 * total / (3 * means.len()) as f64;
        if epsilon <= 0.0 {
            return None;
        }
        let mean_absolute = (2.0 / std::f64::consts::PI).sqrt();
        let sum: f64 = self
            .pixels
            .iter()
            .zip(&means)
            .flat_map(|(pixel, mean)| [0, 1, 2].map(|c| pixel.variance(c).sqrt() / (mean[c] + epsilon)))
            .sum();
        Some(mean_absolute * sum / (3 * means.len()) as f64)
    }
}

impl PixelSums {
    /// Estimated variance of the mean of a channel; infinite information is not claimed: 0 only where all samples
    /// agree, and one sample alone says nothing (0 as well, with `samples` telling why).
    pub fn variance(&self, channel: usize) -> f64 {
        if self.count < 2 {
            return 0.0;
        }
        let n = self.count as f64;
        let mean = self.sum[channel] / n;
        ((self.sum_sq[channel] / n - mean * mean) / (n - 1.0)).max(0.0)
    }
}
