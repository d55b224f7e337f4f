//! One picture from two.

use super::Picture;
use crate::film::FilmError;

/// The mean of two independent pictures of the same, weighted by their numbers of samples, with the layers `variance` and
/// `samples` where both have them; other layers and metadata are left out.
///
/// # Errors
/// [`FilmError::Sizes`].
pub fn average(pictures: [&Picture; 2], samples: [f64; 2]) -> Result<Picture, FilmError> {
    let [a, b] = pictures;
    if (a.width, a.height) != (b.width, b.height) {
        return Err(FilmError::Sizes { picture: [a.width, a.height], reference: [b.width, b.height] });
    }
    let weights = samples.map(|count| count / (samples[0] + samples[1]));
    let sum = |a: f32, b: f32, [wa, wb]: [f64; 2]| (wa * f64::from(a) + wb * f64::from(b)) as f32;
    let rgb = a.rgb.iter().zip(&b.rgb).map(|(a, b)| [0, 1, 2].map(|c| sum(a[c], b[c], weights))).collect();
    let mut picture = Picture::new(a.width, a.height, rgb);
    if let (Some(a), Some(b)) = (a.variance(), b.variance()) {
        // Of the mean: it goes with the squares of the weights.
        let [wa, wb] = weights.map(|weight| weight * weight);
        let joined = |channel: usize| {
            (0..a.pixels()).map(|pixel| wa * a.at(channel, pixel) + wb * b.at(channel, pixel)).collect()
        };
        picture.push_variance([0, 1, 2].map(joined));
    }
    if let (Some(a), Some(b)) = (a.channel("samples", "Y"), b.channel("samples", "Y")) {
        picture.push_channel("samples", "Y", a.iter().zip(b).map(|(a, b)| a + b).collect());
    }
    Ok(picture)
}
