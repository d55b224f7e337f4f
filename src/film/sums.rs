//! The host's half of the film: sums in f64, so that no number of samples stalls them (N-18).

use super::estimate::{self, Moments};
use super::{Layer, Picture};

/// The device's f32 sums are taken over after every so many samples per pixel, counted from the first: the rounding
/// stays below 1e-5, and the result does not depend on how a render was cut into iterations.
pub const SAMPLES_A_FLUSH: u32 = 64;

/// A pixel's sums, in device units. Samples come in groups; those of a group depend on each other, groups do not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSums {
    pub sum: [f64; 3],
    /// Of each group its sum squared over its samples.
    pub sum_sq: [f64; 3],
    pub count: u64,
    pub groups: u64,
    pub non_finite: u64,
}

/// A pixel's samples that were taken in another way before, each with a weight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Earlier {
    count: u64,
    groups: u64,
    non_finite: u64,
    /// Sum of the samples' weights, and of the weighted samples; the estimated variance of the latter.
    weight: f64,
    sum: [f64; 3],
    variance: [f64; 3],
}

/// Sums over all samples of every pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmSums {
    pub width: u32,
    pub height: u32,
    /// All with weight one.
    pub pixels: Vec<PixelSums>,
    /// Empty where all samples are alike.
    earlier: Vec<Earlier>,
}

impl FilmSums {
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![PixelSums::default(); width as usize * height as usize];
        Self { width, height, pixels, earlier: Vec::new() }
    }

    /// Adds what the device has gathered, one entry per pixel.
    pub fn add(&mut self, taken: impl Iterator<Item = PixelSums>) {
        for (pixel, taken) in self.pixels.iter_mut().zip(taken) {
            for channel in 0..3 {
                pixel.sum[channel] += taken.sum[channel];
                pixel.sum_sq[channel] += taken.sum_sq[channel];
            }
            pixel.count += taken.count;
            pixel.groups += taken.groups;
            pixel.non_finite += taken.non_finite;
        }
    }

    /// What comes from now on is taken in another way, with another variance. What there is keeps the weight one, until
    /// [`weigh_earlier`](Self::weigh_earlier) changes it.
    pub fn settle(&mut self) {
        self.earlier.resize(self.pixels.len(), Earlier::default());
        for (earlier, pixel) in self.earlier.iter_mut().zip(&mut self.pixels) {
            *earlier = earlier.with(pixel);
            *pixel = PixelSums::default();
        }
    }

    /// Samples of before the last [`settle`](Self::settle) weigh so much more from now on. For the least variance, one
    /// of then should weigh the variance of one of now over its own; it must not depend on these samples.
    pub fn weigh_earlier(&mut self, factor: f64) {
        for earlier in &mut self.earlier {
            earlier.weight *= factor;
            earlier.sum = earlier.sum.map(|sum| factor * sum);
            earlier.variance = earlier.variance.map(|variance| factor * factor * variance);
        }
    }

    /// All samples of each pixel together.
    fn totals(&self) -> impl Iterator<Item = Earlier> {
        let none = Earlier::default();
        self.pixels.iter().enumerate().map(move |(i, pixel)| self.earlier.get(i).unwrap_or(&none).with(pixel))
    }

    /// Samples left out because they were not finite.
    pub fn non_finite(&self) -> u64 {
        self.totals().map(|pixel| pixel.non_finite).sum()
    }

    /// As [`non_finite`](Self::non_finite), of each pixel.
    pub fn non_finite_by_pixel(&self) -> Vec<u64> {
        self.totals().map(|pixel| pixel.non_finite).collect()
    }

    /// Radiance, with the layers `variance` (of the mean) and `samples`. `radiance_scale` turns device units into
    /// the scene's.
    pub fn picture(&self, radiance_scale: f64) -> Picture {
        let totals: Vec<Earlier> = self.totals().collect();
        let rgb =
            totals.iter().map(|pixel| pixel.mean().map(|mean| (mean * radiance_scale) as f32)).collect();
        let mut picture = Picture::new(self.width, self.height, rgb);
        let scale_sq = radiance_scale * radiance_scale;
        picture.push_variance(
            [0, 1, 2].map(|channel| {
                totals.iter().map(|pixel| pixel.variance_of_mean(channel) * scale_sq).collect()
            }),
        );
        let samples = totals.iter().map(|pixel| pixel.count as f32).collect();
        picture.layers.push(Layer { name: "samples".into(), channels: vec![("Y".into(), samples)] });
        picture
    }

    /// Estimated error of the picture: the expected MAPE against the truth, as `compare` has it. `None` before two
    /// groups of samples per pixel, and of a black picture. Light that no sample anywhere has found is not in it.
    pub fn estimated_error(&self) -> Option<f64> {
        let moments = |pixel: Earlier| {
            (pixel.groups >= 2).then(|| Moments {
                mean: pixel.mean(),
                variance: [0, 1, 2].map(|channel| pixel.variance_of_mean(channel)),
                freedom: pixel.groups - 1,
                pixels: 1,
            })
        };
        let pixels: Vec<Moments> = self.totals().map(moments).collect::<Option<_>>()?;
        estimate::mape(self.width as usize, &pixels)
    }
}

impl PixelSums {
    /// Adds a group of so many samples by their sum.
    pub fn add_group(&mut self, sum: [f64; 3], samples: u64) {
        if samples == 0 {
            return;
        }
        for (channel, sum) in sum.into_iter().enumerate() {
            self.sum[channel] += sum;
            self.sum_sq[channel] += sum * sum / samples as f64;
        }
        self.count += samples;
        self.groups += 1;
    }

    /// Zero where there are no samples.
    pub fn mean(&self) -> [f64; 3] {
        self.sum.map(|sum| if self.count > 0 { sum / self.count as f64 } else { 0.0 })
    }

    /// Estimated variance of the mean of a channel; infinite information is not claimed: 0 only where all groups
    /// agree, and for one group alone, of which nothing is known (`samples` shows which it is).
    pub fn variance(&self, channel: usize) -> f64 {
        if self.groups < 2 {
            return 0.0;
        }
        let mean = self.mean()[channel];
        let scatter = self.sum_sq[channel] / self.count as f64 - mean * mean;
        (scatter / (self.groups - 1) as f64).max(0.0)
    }
}

impl Earlier {
    /// With samples of weight one.
    fn with(&self, pixel: &PixelSums) -> Self {
        let count = pixel.count as f64;
        let variance = |channel: usize| match pixel.groups {
            // A single group has no variance of its own: as if the weights were right.
            0 | 1 if self.weight > 0.0 => count * self.variance[channel] / self.weight,
            _ => count * count * pixel.variance(channel),
        };
        Self {
            count: self.count + pixel.count,
            groups: self.groups + pixel.groups,
            non_finite: self.non_finite + pixel.non_finite,
            weight: self.weight + count,
            sum: [0, 1, 2].map(|c| self.sum[c] + pixel.sum[c]),
            variance: [0, 1, 2].map(|c| self.variance[c] + variance(c)),
        }
    }

    /// Zero where there are no samples.
    fn mean(&self) -> [f64; 3] {
        self.sum.map(|sum| if self.weight > 0.0 { sum / self.weight } else { 0.0 })
    }

    fn variance_of_mean(&self, channel: usize) -> f64 {
        if self.weight > 0.0 { self.variance[channel] / (self.weight * self.weight) } else { 0.0 }
    }
}
