//! Colours for what has no colour: labels, and matrices of probabilities.

use super::heatmap::{VIRIDIS, color};
use super::png::to_byte;
use super::tonemap::srgb_encode;

/// Pixels that a matrix measures at least.
const LEAST_SIDE: usize = 300;
/// Lightness (Oklab) of the darkest label and of the lightest, and the chroma of all.
const LIGHTNESS: [f32; 2] = [0.52, 0.88];
const CHROMA: f32 = 0.135;
/// One and two powers of one over the plastic number: multiples of them fill the square evenly, Martin Roberts' R2,
/// <https://extremelearning.com.au/unreasonable-effectiveness-of-quasirandom-sequences/>.
const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

/// Linear Rec.709 of a label: of all hues and several lightnesses, as unlike as can be for any number of labels.
fn label_color(label: u32) -> [f32; 3] {
    let [turn, step] = R2.map(|stride| (f64::from(label) * stride).fract() as f32);
    let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
    oklab(LIGHTNESS[0] + step * (LIGHTNESS[1] - LIGHTNESS[0]), CHROMA * cos, CHROMA * sin)
}

/// sRGB of a label, dimmed where the surface turns away: `facing` is 1 straight on and 0 at grazing angles. Black
/// without a label.
pub fn label_pixel(label: Option<u32>, facing: f32) -> [u8; 3] {
    let Some(label) = label else { return [0; 3] };
    let shade = 0.25 + 0.75 * facing.clamp(0.0, 1.0);
    label_color(label).map(|linear| to_byte(srgb_encode((shade * linear).clamp(0.0, 1.0))))
}

/// A square matrix of numbers that are not negative as a picture of so many pixels a side, by logarithm from the least
/// positive (dark violet) to the largest (yellow); zeros are black. Small ones are drawn large.
pub fn matrix(entries: &[f32], side: usize) -> (u32, Vec<[u8; 3]>) {
    let [least, most] = range(entries);
    let span = f64::from(most / least).ln();
    let colors: Vec<[u8; 3]> = entries
        .iter()
        .map(|&entry| match entry > 0.0 {
            true => color(&VIRIDIS, if span > 0.0 { f64::from(entry / least).ln() / span } else { 1.0 }),
            false => [0; 3],
        })
        .collect();
    let factor = LEAST_SIDE.div_ceil(side.max(1));
    let pixels = side * factor;
    let at = |pixel: usize| colors[pixel / pixels / factor * side + pixel % pixels / factor];
    (pixels as u32, (0..pixels * pixels).map(at).collect())
}

/// Squares of `side` x `side` numbers that are not negative, each column by column, as one picture of so many pixels a side:
/// row by row with a black line between them, in the colours of [`matrix`].
pub fn squares(entries: &[f32], side: usize) -> (u32, Vec<[u8; 3]>) {
    let count = entries.len() / (side * side);
    let columns = (count as f64).sqrt().ceil() as usize;
    let pitch = side + 1;
    let total = columns * pitch;
    let mut all = vec![0.0; total * total];
    for (square, cells) in entries.chunks(side * side).enumerate() {
        let (left, top) = (square % columns * pitch, square / columns * pitch);
        for (cell, &entry) in cells.iter().enumerate() {
            all[(top + cell % side) * total + left + cell / side] = entry;
        }
    }
    matrix(&all, total)
}

/// The least positive and the largest entry.
pub fn range(entries: &[f32]) -> [f32; 2] {
    let positive = entries.iter().copied().filter(|entry| *entry > 0.0);
    let (least, most) = positive.fold((f32::INFINITY, 0.0f32), |(a, b), entry| (a.min(entry), b.max(entry)));
    [least, most]
}

/// Oklab to linear Rec.709, unclamped: Bjorn Ottosson, <https://bottosson.github.io/posts/oklab/>.
fn oklab(lightness: f32, a: f32, b: f32) -> [f32; 3] {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_93 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each number where it belongs: the first coordinate to the right, the second down.
    #[test]
    fn squares_stand_side_by_side() {
        // Three squares of 2x2; the largest number is the second square's at (1, 0).
        let mut entries = [1.0; 12];
        entries[4 + 2] = 9.0;
        let (pixels, picture) = squares(&entries, 2);
        let cell = pixels as usize / 6;
        let at = |x: usize, y: usize| picture[(y * cell + cell / 2) * pixels as usize + x * cell + cell / 2];
        let [most, least] = [1.0, 0.0].map(|share| color(&VIRIDIS, share));
        assert_eq!([at(4, 0), at(3, 0), at(4, 1), at(0, 3)], [most, least, least, least]);
        // Lines between, and no fourth square.
        assert_eq!([at(2, 0), at(0, 2), at(3, 3)], [[0; 3]; 3]);
    }
}
