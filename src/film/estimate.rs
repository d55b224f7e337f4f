//! The error of a picture, estimated from its own samples.

use std::f64::consts::FRAC_2_PI;

use rayon::prelude::*;

/// Mean and variance of a pixel, or their sums over several pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    pub mean: [f64; 3],
    /// Of the mean.
    pub variance: [f64; 3],
    /// Groups of samples that the variance is from, less one for each pixel.
    pub freedom: u64,
    pub pixels: u64,
}

impl Moments {
    fn sum<'a>(all: impl Iterator<Item = &'a Self>) -> Self {
        all.fold(Self::default(), |a, b| Self {
            mean: [0, 1, 2].map(|c| a.mean[c] + b.mean[c]),
            variance: [0, 1, 2].map(|c| a.variance[c] + b.variance[c]),
            freedom: a.freedom + b.freedom,
            pixels: a.pixels + b.pixels,
        })
    }

    /// Expected absolute error of one of these pixels over their mean, were errors normally distributed.
    fn relative_error(&self, channel: usize, epsilon: f64) -> f64 {
        let pixels = self.pixels as f64;
        let mean_absolute = FRAC_2_PI.sqrt();
        // The root of an estimated variance is too small on average by this factor.
        let root_mean = 4.0 * self.freedom as f64 / (4.0 * self.freedom as f64 + 1.0);
        let deviation = (self.variance[channel] / pixels).sqrt() / root_mean;
        mean_absolute * deviation / (self.mean[channel] / pixels + epsilon)
    }

    /// How likely 9 of these pixels are to find nothing. Light that is found with a relative variance v is found 1 / v
    /// times, as it were; once for 9 pixels is too rare to call a place without any black.
    fn chance_of_none(&self, channel: usize) -> f64 {
        let found = self.mean[channel] * self.mean[channel] / self.variance[channel];
        (1.0 - 9.0 * found / self.pixels as f64).min(0.0).exp()
    }
}

/// The expected MAPE of a picture against the truth, with an epsilon of 1 % of its mean; `None` for a black one.
///
/// A pixel that has missed light is too dark, and its variance too small: so it is estimated together with its
/// neighbours. Where these 3x3 pixels have found no light at all, they are black if the surroundings find so much of it
/// that this is no accident, and otherwise they count as entirely wrong.
pub(super) fn mape(width: usize, pixels: &[Moments]) -> Option<f64> {
    let height = pixels.len() / width;
    let total: f64 = pixels.iter().flat_map(|pixel| pixel.mean).sum();
    let epsilon = 0.01 * total / (3 * pixels.len()) as f64;
    if epsilon <= 0.0 {
        return None;
    }
    let mut levels = vec![blocks(width, pixels)];
    while levels.last().is_some_and(|(_, level)| level.len() > 1) {
        let (width, level) = &levels[levels.len() - 1];
        levels.push(blocks(*width, level));
    }
    let relative = |x: usize, y: usize| -> f64 {
        let near = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let window = near(y, height).flat_map(|y| near(x, width).map(move |x| &pixels[y * width + x]));
        let window = Moments::sum(window);
        let channel = |c: usize| {
            if window.mean[c] > 0.0 {
                return window.relative_error(c, epsilon);
            }
            // From 9x9 pixels on.
            let wider = levels.iter().enumerate().skip(1).map(|(level, (width, blocks))| {
                let side = 3usize.pow(level as u32 + 1);
                &blocks[y / side * width + x / side]
            });
            let found = wider.into_iter().find(|block| block.mean[c] > 0.0);
            found.map_or(0.0, |block| block.chance_of_none(c))
        };
        (0..3).map(channel).sum()
    };
    // In order: the sum does not depend on the number of threads.
    let rows: Vec<f64> =
        (0..height).into_par_iter().map(|y| (0..width).map(|x| relative(x, y)).sum()).collect();
    Some(rows.iter().sum::<f64>() / (3 * pixels.len()) as f64)
}

/// Sums over blocks of 3x3, and how many blocks there are in a row.
fn blocks(width: usize, level: &[Moments]) -> (usize, Vec<Moments>) {
    let (columns, rows) = (width.div_ceil(3), (level.len() / width).div_ceil(3));
    let block = |index: usize| {
        let (x, y) = (3 * (index % columns), 3 * (index / columns));
        let lines = y..(y + 3).min(level.len() / width);
        Moments::sum(lines.flat_map(|y| &level[y * width + x..y * width + (x + 3).min(width)]))
    };
    (columns, (0..columns * rows).into_par_iter().map(block).collect())
}
