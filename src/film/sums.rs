//! The host's half of the film: sums in f64, so that no number of samples stalls them (N-18).

use rayon::prelude::*;

use super::estimate::{self, Moments};
use super::{Layer, Picture};
use crate::math::exact::{rounded_sum, two_sum};

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
pub(super) struct Earlier {
    pub count: u64,
    pub groups: u64,
    pub non_finite: u64,
    /// Sum of the samples' weights, and of the weighted samples; the estimated variance of the latter.
    pub weight: f64,
    pub sum: [f64; 3],
    pub variance: [f64; 3],
}

/// Pixels that share room for what their sums have left out.
pub const BLOCK: usize = 256;

/// What rounding has left out of the sums of a block's pixels, and of what this adds up to in turn: as many levels as it
/// takes for nothing to be lost, mostly none or one. Red, green and blue of `sum`, then of `sum_sq`.
pub(super) type Rests = Vec<Box<[[f64; 6]; BLOCK]>>;

/// Sums over all samples of every pixel.
///
/// They are exact, so that they do not depend on how samples were spread over renders that are added up later: a pixel's
/// sum is that in `pixels` and all of its rests together. Whole trees of partial sums in a fixed order would do as well, but
/// for the memory of a picture for each level of the tree; these rests take as much as a picture where it is noisy, and
/// nothing where it is not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmSums {
    pub width: u32,
    pub height: u32,
    /// All with weight one; rounded.
    pub pixels: Vec<PixelSums>,
    /// For every [`BLOCK`] pixels.
    pub(super) rests: Vec<Rests>,
    /// Empty where all samples are alike.
    pub(super) earlier: Vec<Earlier>,
}

impl FilmSums {
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![PixelSums::default(); width as usize * height as usize];
        let rests = vec![Vec::new(); pixels.len().div_ceil(BLOCK)];
        Self { width, height, pixels, rests, earlier: Vec::new() }
    }

    /// Adds what the device has gathered, one entry per pixel.
    pub fn add(&mut self, taken: impl IntoParallelIterator<Item = PixelSums, Iter: IndexedParallelIterator>) {
        self.add_from(0, taken);
    }

    /// As [`add`](Self::add), of the pixels from the `first` on, which begins a [`BLOCK`].
    pub fn add_from(
        &mut self,
        first: usize,
        taken: impl IntoParallelIterator<Item = PixelSums, Iter: IndexedParallelIterator>,
    ) {
        debug_assert!(first.is_multiple_of(BLOCK));
        let blocks = self.pixels[first..].par_chunks_mut(BLOCK).zip(&mut self.rests[first / BLOCK..]);
        blocks.zip(taken.into_par_iter().chunks(BLOCK)).for_each(|((pixels, rests), taken)| {
            for (index, (pixel, taken)) in pixels.iter_mut().zip(taken).enumerate() {
                pixel.add(&taken, rests, index);
            }
        });
    }

    /// Adds sums of other samples, all of weight one, of as many pixels.
    pub fn add_sums(&mut self, other: &Self) {
        self.add(other.pixels.par_iter().copied());
        let blocks = self.pixels.par_chunks_mut(BLOCK).zip(&mut self.rests).zip(&other.rests);
        blocks.for_each(|((pixels, rests), other)| {
            for level in other {
                for (index, (pixel, rest)) in pixels.iter_mut().zip(level.iter()).enumerate() {
                    pixel.add_values(rest, rests, index);
                }
            }
        });
    }

    /// The pixels whose samples have all weight one, each sum rounded once.
    pub fn rounded(&self) -> impl Iterator<Item = PixelSums> {
        self.pixels.iter().enumerate().map(|(index, pixel)| {
            let (rests, index) = (&self.rests[index / BLOCK], index % BLOCK);
            if rests.is_empty() {
                return *pixel;
            }
            let round = |value: f64, slot: usize| match rests.as_slice() {
                [level] => value + level[index][slot],
                levels => {
                    rounded_sum(std::iter::once(value).chain(levels.iter().map(|level| level[index][slot])))
                }
            };
            PixelSums {
                sum: [0, 1, 2].map(|c| round(pixel.sum[c], c)),
                sum_sq: [0, 1, 2].map(|c| round(pixel.sum_sq[c], 3 + c)),
                ..*pixel
            }
        })
    }

    /// What comes from now on is taken in another way, with another variance. What there is keeps the weight one, until
    /// [`weigh_earlier`](Self::weigh_earlier) changes it.
    pub fn settle(&mut self) {
        self.earlier = self.totals().collect();
        self.pixels.fill(PixelSums::default());
        self.rests.fill(Vec::new());
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

    /// All samples have the same weight.
    pub fn is_even(&self) -> bool {
        self.earlier.is_empty()
    }

    /// All samples of each pixel together.
    fn totals(&self) -> impl Iterator<Item = Earlier> {
        let none = Earlier::default();
        let rounded = self.rounded().enumerate();
        rounded.map(move |(i, pixel)| self.earlier.get(i).unwrap_or(&none).with(&pixel))
    }

    /// Of each pixel the weight of all samples, and their weighted sum.
    pub(super) fn weighted(&self) -> impl Iterator<Item = (f64, [f64; 3])> {
        self.totals().map(|pixel| (pixel.weight, pixel.sum))
    }

    /// Samples left out because they were not finite.
    pub fn non_finite(&self) -> u64 {
        let earlier = self.earlier.iter().map(|pixel| pixel.non_finite);
        self.pixels.iter().map(|pixel| pixel.non_finite).chain(earlier).sum()
    }

    /// As [`non_finite`](Self::non_finite), of each pixel.
    pub fn non_finite_by_pixel(&self) -> Vec<u64> {
        self.totals().map(|pixel| pixel.non_finite).collect()
    }

    /// Radiance, with the layers `variance` (of the mean) and `samples`. `radiance_scale` turns device units into
    /// the scene's.
    pub fn picture(&self, radiance_scale: f64) -> Picture {
        let room = self.pixels.len();
        let mut rgb = Vec::with_capacity(room);
        let mut variance = [(); 3].map(|()| Vec::with_capacity(room));
        let mut samples = Vec::with_capacity(room);
        let scale_sq = radiance_scale * radiance_scale;
        for pixel in self.totals() {
            rgb.push(pixel.mean().map(|mean| (mean * radiance_scale) as f32));
            for (channel, variance) in variance.iter_mut().enumerate() {
                variance.push(pixel.variance_of_mean(channel) * scale_sq);
            }
            samples.push(pixel.count as f32);
        }
        let mut picture = Picture::new(self.width, self.height, rgb);
        picture.push_variance(variance);
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
    /// Adds sums of other samples of this pixel, the `index`-th of its block.
    fn add(&mut self, taken: &Self, rests: &mut Rests, index: usize) {
        let values =
            std::array::from_fn(|slot| if slot < 3 { taken.sum[slot] } else { taken.sum_sq[slot - 3] });
        self.add_values(&values, rests, index);
        self.count += taken.count;
        self.groups += taken.groups;
        self.non_finite += taken.non_finite;
    }

    /// Adds to `sum` and `sum_sq`, and what rounding leaves out to the rests.
    fn add_values(&mut self, values: &[f64; 6], rests: &mut Rests, index: usize) {
        for (slot, value) in values.iter().enumerate() {
            let sum = if slot < 3 { &mut self.sum[slot] } else { &mut self.sum_sq[slot - 3] };
            let mut rest;
            [*sum, rest] = two_sum(*sum, *value);
            let mut level = 0;
            while rest != 0.0 {
                if level == rests.len() {
                    rests.push(Box::new([[0.0; 6]; BLOCK]));
                }
                let kept = &mut rests[level][index][slot];
                [*kept, rest] = two_sum(*kept, rest);
                level += 1;
            }
        }
    }

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
