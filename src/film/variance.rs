//! The layer `variance`, in f32: scaled where the squares of very bright or very dim pictures do not fit.

use super::{Layer, Picture};
use crate::math::scale::{normalising_exponent, scale_by_power_of_two};

/// Exponents of two between which the largest variance of a picture may lie: below the largest f32, and so far above
/// the smallest normal one that pixels of a 2^15th of the noise still count.
const EXPONENTS: std::ops::Range<i32> = -96..127;

/// The variances of a picture's pixels.
#[derive(Clone, Copy, Debug)]
pub struct Variance<'a> {
    channels: [&'a [f32]; 3],
    scale: f64,
}

impl Variance<'_> {
    /// Estimated variance of the mean of a channel of a pixel.
    pub fn at(&self, channel: usize, pixel: usize) -> f64 {
        f64::from(self.channels[channel][pixel]) * self.scale
    }

    /// How many pixels there are.
    pub fn pixels(&self) -> usize {
        self.channels[0].len()
    }
}

impl Picture {
    /// What is known of the pixels' variance.
    pub fn variance(&self) -> Option<Variance<'_>> {
        let channel = |name: &str| self.channel("variance", name);
        let channels = [channel("R")?, channel("G")?, channel("B")?];
        Some(Variance { channels, scale: self.variance_scale.unwrap_or(1.0) })
    }

    /// Adds the layer of variances, which there must not be yet, in units that f32 can hold.
    pub fn push_variance(&mut self, channels: [Vec<f64>; 3]) {
        let largest = channels.iter().flatten().copied().fold(0.0, f64::max);
        // largest * 2^exponent is about 1.
        let exponent = normalising_exponent(largest).filter(|exponent| !EXPONENTS.contains(&-exponent));
        self.variance_scale = exponent.map(|exponent| scale_by_power_of_two(1.0, -exponent));
        let stored = |value: f64| scale_by_power_of_two(value, exponent.unwrap_or(0)) as f32;
        let names = ["R", "G", "B"].into_iter();
        let channels = names
            .zip(channels)
            .map(|(name, values)| (name.to_string(), values.into_iter().map(stored).collect()));
        self.layers.push(Layer { name: "variance".into(), channels: channels.collect() });
    }
}
