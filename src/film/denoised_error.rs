//! The error of a denoised picture, estimated from two halves of its samples that are denoised apart.
//!
//! Denoising leaves two errors: noise that it took for the picture, and what it smoothed away of the picture. Halves know
//! nothing of each other, so that what differs between them when they are denoised is noise: as far as denoising is linear in
//! its noise, |dA - dB| sqrt(a b) is as large on average as the noise that is left of the whole, where a and b are the halves'
//! shares of the samples.
//!
//! What is smoothed away is the same in both, and no difference shows it. A filter that is trained for the least error smooths
//! until what it would lose is about what it would gain, so that it is in proportion to the noise, as [`SMOOTHED_AWAY`] says.
//! Where pictures have more detail than that, cross-validation finds it: (dA - A) (dB - B) is the square of what is missing from
//! both, on average over pixels. It has noise of the size of the raw picture's variance, of which denoising leaves a hundredth, so
//! that it counts only where it is far above that, and never for less than the proportion: where it was less, it was too small
//! (docs/measurements.md, The error of a denoised picture).

use super::halves::Halves;

/// The square of what is smoothed away over that of the noise that is left: measured with Open Image Denoise.
const SMOOTHED_AWAY: f64 = 1.72;
/// In cross-validation pixels count by their relative squares, those darker than this share of the mean as if they had that.
const DARK: f64 = 0.1;
/// Its standard errors above zero from which it counts.
const CLEAR: f64 = 4.0;
/// Pixels along an edge of the blocks that are taken as independent.
const BLOCK: usize = 8;

/// The expected MAPE of a denoised picture against the truth, with an epsilon of 1 % of its mean; `None` for a black one.
/// `denoised`: of the whole picture and of its halves.
pub(super) fn estimate(halves: &Halves, denoised: [&[[f32; 3]]; 3]) -> Option<f64> {
    let [whole, first, second] = denoised.map(|rgb| rgb.as_flattened().iter().map(|&value| f64::from(value)));
    let values = whole.len() as f64;
    let mean = whole.clone().sum::<f64>() / values;
    if mean <= 0.0 {
        return None;
    }
    let relative = whole.zip(first.zip(second)).map(|(value, (a, b))| (a - b).abs() / (value + 0.01 * mean));
    let [a, b] = halves.shares;
    let noise = (a * b).sqrt() * relative.sum::<f64>() / values;
    let smoothed_away = SMOOTHED_AWAY.max(cross_validated(halves, denoised, DARK * mean));
    Some((1.0 + smoothed_away).sqrt() * noise)
}

/// What cross-validation has in place of [`SMOOTHED_AWAY`]; zero where that is not [`CLEAR`] of noise.
fn cross_validated(halves: &Halves, [whole, da, db]: [&[[f32; 3]]; 3], dark: f64) -> f64 {
    let ([a, b], [share_a, share_b]) = (&halves.pictures, halves.shares);
    let width = a.width as usize;
    let columns = width.div_ceil(BLOCK);
    // Of each block: values, and their products.
    let mut blocks = vec![(0.0, 0.0); columns * whole.len().div_ceil(width).div_ceil(BLOCK)];
    let mut noise = 0.0;
    for (index, whole) in whole.iter().enumerate() {
        let block = &mut blocks[index / width / BLOCK * columns + index % width / BLOCK];
        for c in 0..3 {
            let [a, b, da, db] =
                [a.rgb[index][c], b.rgb[index][c], da[index][c], db[index][c]].map(f64::from);
            // A half may have no sample of a pixel.
            if a.is_finite() && b.is_finite() {
                let weight = (f64::from(whole[c]) + dark).powi(-2);
                block.0 += 1.0;
                block.1 += weight * (da - a) * (db - b);
                noise += weight * share_a * share_b * (da - db).powi(2);
            }
        }
    }
    let (values, sum) = blocks.iter().fold((0.0, 0.0), |sum, block| (sum.0 + block.0, sum.1 + block.1));
    if noise <= 0.0 || blocks.len() < 2 {
        return 0.0;
    }
    let mean = sum / values;
    let scatter: f64 = blocks.iter().map(|(values, sum)| (sum - values * mean).powi(2)).sum();
    let count = blocks.len() as f64;
    let error = (scatter * count / (count - 1.0)).sqrt();
    if sum > CLEAR * error { sum / noise } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Picture;

    const SIDE: u32 = 64;

    /// Independent numbers from -1 to 1, by a hash of theirs.
    fn noise(number: u32) -> f32 {
        let mut word = number.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
        for _ in 0..2 {
            word = (word ^ word >> 15).wrapping_mul(0x2c1b_3c6d);
        }
        (word >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// What a filter makes grey is a pattern of this contrast, in halves with so much noise; the filter leaves `left` of noise.
    fn estimated(contrast: f32, raw: f32, left: f32) -> f64 {
        let pixels = SIDE * SIDE;
        let picture = |first: u32, value: &dyn Fn(u32) -> f32, amount: f32| -> Vec<[f32; 3]> {
            (0..pixels).map(|i| [value(i) + amount * noise(first * pixels + i); 3]).collect()
        };
        let pattern = |i: u32| 1.0 + if (i + i / SIDE).is_multiple_of(2) { contrast } else { -contrast };
        let [a, b] = [1, 2].map(|first| Picture::new(SIDE, SIDE, picture(first, &pattern, raw)));
        let [da, db] = [3, 4].map(|first| picture(first, &|_| 1.0, left));
        let whole: Vec<_> = da.iter().zip(&db).map(|(a, b)| [0.5 * (a[0] + b[0]); 3]).collect();
        let halves = Halves { pictures: [a, b], shares: [0.5; 2] };
        estimate(&halves, [&whole, &da, &db]).expect("light")
    }

    /// Noise that is left is known from what differs; detail that is gone, from what is missing in both halves.
    #[test]
    fn detail_that_is_gone_is_found_beyond_noise() {
        // The mean of |x - y| / 2 is a third of the largest.
        let plain = estimated(0.0, 0.5, 0.03);
        assert!((plain / (2.72f64.sqrt() * 0.01) - 1.0).abs() < 0.05, "{plain}");
        let detailed = estimated(0.3, 0.5, 0.03);
        assert!((0.7..1.1).contains(&(detailed / 0.3)), "{detailed}");
        // Of noise that hides the detail nothing is made.
        for raw in [3.0, 30.0, 300.0] {
            let hidden = estimated(0.01, raw, 0.03);
            assert!((hidden / plain - 1.0).abs() < 1e-6, "{hidden} {plain}");
        }
    }

    #[test]
    fn black_pictures_have_no_estimate() {
        let black = vec![[0.0; 3]; 16];
        let halves = Halves { pictures: [0, 1].map(|_| Picture::new(4, 4, black.clone())), shares: [0.5; 2] };
        assert_eq!(estimate(&halves, [&black, &black, &black]), None);
    }
}
