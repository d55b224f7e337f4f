//! The exposure of a picture: what it is by default, which one shows the picture, and whether a given one does.

use std::fmt;

use super::Picture;
use super::png;
use super::tonemap::ViewTransform;
use crate::math::color::luminance;

/// The most stops up or down: a factor of 2^100.
pub const MAX_STOPS: f32 = 100.0;

/// The luminance that a picture of average brightness is shown with: middle grey.
const MIDDLE_GREY: f64 = 0.18;

/// The share of a picture's lit pixels at either end, the darkest and the brightest, that [`auto`] does not look at: a
/// lamp that is seen, or traces of light in a shadow, say nothing of the rest.
const ENDS: f64 = 0.1;

/// A picture is lost when this share of its lit pixels is black, or white.
const NEARLY_ALL: f64 = 0.95;

/// A pixel is black when none of its bytes is larger, and white when none is smaller.
const BLACK: u8 = 5;
const WHITE: u8 = 250;

/// What was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Factors of 2 on the radiance.
    Stops(f32),
    /// What [`auto`] makes of the picture.
    Auto,
}

impl Exposure {
    /// The stops for this picture.
    pub fn stops(self, picture: &Picture) -> f32 {
        match self {
            Self::Stops(stops) => stops,
            Self::Auto => auto(picture).unwrap_or(0.0),
        }
    }
}

/// The exposure in stops, a multiple of 0.1 within [`MAX_STOPS`], that brings the average of a picture to middle grey
/// (0.18). The average is the mean of log2(luminance) over the lit pixels, those with a luminance above 0, but for the
/// darkest and the brightest tenth of them. `None` where no pixel is lit.
///
/// Source: Reinhard et al., Photographic Tone Reproduction for Digital Images, SIGGRAPH 2002, equation 1 (log-average
/// luminance) and section 3.1 (key value 0.18).
pub fn auto(picture: &Picture) -> Option<f32> {
    let lit = picture.rgb.iter().map(|&pixel| brightness(pixel)).filter(|&value| value > 0.0);
    let mut stops: Vec<f64> = lit.filter(|value| value.is_finite()).map(f64::log2).collect();
    stops.sort_unstable_by(f64::total_cmp);
    let left_out = (ENDS * stops.len() as f64) as usize;
    let middle = &stops[left_out..stops.len() - left_out];
    let mean = (!middle.is_empty()).then(|| middle.iter().sum::<f64>() / middle.len() as f64)?;
    let tenths = (10.0 * (MIDDLE_GREY.log2() - mean)).round();
    // Adding 0 makes 0 of -0, which would be printed with its sign.
    Some(((tenths / 10.0) as f32).clamp(-MAX_STOPS, MAX_STOPS) + 0.0)
}

/// A picture of which next to nothing is to be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lost {
    /// Not one pixel has light.
    Unlit,
    /// Shown at `stops`, the `share` of its lit pixels is black; `better` is what [`auto`] makes of it.
    Black { share: f64, stops: f32, better: f32 },
    /// The same in white.
    White { share: f64, stops: f32, better: f32 },
}

impl Lost {
    /// Whether the picture is lost through `view` at `stops`.
    pub fn judge(picture: &Picture, view: ViewTransform, stops: f32) -> Option<Self> {
        let Some(better) = auto(picture) else { return Some(Self::Unlit) };
        let [mut lit, mut black, mut white] = [0u64; 3];
        for &pixel in picture.rgb.iter().filter(|&&pixel| brightness(pixel) > 0.0) {
            let shown = png::pixel(pixel, view, stops);
            lit += 1;
            black += u64::from(shown.iter().all(|&byte| byte <= BLACK));
            white += u64::from(shown.iter().all(|&byte| byte >= WHITE));
        }
        let share = |count: u64| count as f64 / lit as f64;
        if share(black) >= NEARLY_ALL {
            Some(Self::Black { share: share(black), stops, better })
        } else if share(white) >= NEARLY_ALL {
            Some(Self::White { share: share(white), stops, better })
        } else {
            None
        }
    }
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (color, share, stops, better) = match *self {
            Self::Unlit => {
                return write!(
                    f,
                    "the picture is black: no light reached the camera. Check where the camera stands and what lights \
                     there are"
                );
            }
            Self::Black { share, stops, better } => ("black", share, stops, better),
            Self::White { share, stops, better } => ("white", share, stops, better),
        };
        write!(
            f,
            "{:.0} % of the pixels that have light are shown {color} at --exposure {stops}; --exposure {better} shows \
             them, and --exposure auto finds it",
            100.0 * share
        )
    }
}

/// Luminance, in the precision that logarithms are added up in.
fn brightness(pixel: [f32; 3]) -> f64 {
    f64::from(luminance(pixel.into()))
}
