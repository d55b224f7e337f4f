//! From a snapshot to the colours of a screen.

use std::sync::OnceLock;

use egui::{Color32, ColorImage};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::device::layout::SAMPLES_A_GROUP;
use crate::film::heatmap::{self, VIRIDIS};
use crate::film::tonemap::ViewTransform;
use crate::film::{Picture, false_color, png};
use crate::integrator::FirstSubspaces;

use super::snapshot::Snapshot;

/// Runs parallel work in threads of the window's own: training and building keep rayon's busy for seconds.
pub fn in_own_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let build = || {
        let threads = std::thread::available_parallelism().map_or(1, |all| all.get().min(8));
        ThreadPoolBuilder::new().num_threads(threads).build().ok()
    };
    match POOL.get_or_init(build) {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// What of a picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    #[default]
    Radiance,
    Denoised,
    Samples,
    Variance,
    /// Against the reference.
    Error,
    EyeSubspaces,
    LightSubspaces,
    NonFinite,
}

impl Show {
    pub const ALL: [Self; 8] = [
        Self::Radiance,
        Self::Denoised,
        Self::Samples,
        Self::Variance,
        Self::Error,
        Self::EyeSubspaces,
        Self::LightSubspaces,
        Self::NonFinite,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Radiance => "picture",
            Self::Denoised => "denoised",
            Self::Samples => "samples",
            Self::Variance => "standard error",
            Self::Error => "error against the reference",
            Self::EyeSubspaces => "eye subspaces",
            Self::LightSubspaces => "light subspaces",
            Self::NonFinite => "non-finite samples",
        }
    }

    /// What its colours mean.
    pub fn legend(self) -> &'static str {
        match self {
            Self::Radiance => "",
            Self::Denoised => "by Open Image Denoise, now and then; saved beside the picture",
            Self::Samples => "violet none, yellow as many as any pixel has",
            Self::Variance | Self::Error => heatmap::LEGEND,
            Self::EyeSubspaces | Self::LightSubspaces => {
                "one colour per subspace; black where a ray meets nothing, or a light"
            }
            Self::NonFinite => "magenta where samples were NaN or infinite, and were left out",
        }
    }
}

/// How a picture is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    pub show: Show,
    pub view: ViewTransform,
    /// Stops.
    pub exposure: f32,
}

const MAGENTA: [u8; 3] = [255, 0, 255];

/// The snapshot's picture, or what the look shows in its place; `None` where there is no such thing (yet).
pub fn image(snapshot: &Snapshot, look: &Look, reference: Option<&Picture>) -> Option<ColorImage> {
    let picture = &*snapshot.picture;
    let pixels: Vec<[u8; 3]> = match look.show {
        Show::Radiance => return radiance(picture, look),
        Show::Denoised => return radiance(snapshot.denoised.as_deref().unwrap_or(picture), look),
        Show::Samples => {
            let samples = picture.channel("samples", "Y")?;
            let most = samples.iter().copied().fold(0.0, f32::max).max(1.0);
            let color = |&count: &f32| heatmap::color(&VIRIDIS, f64::from(count / most));
            samples.par_iter().map(color).collect()
        }
        // A variance takes two groups of samples.
        Show::Variance if snapshot.figures.samples < 2 * SAMPLES_A_GROUP => return None,
        Show::Variance => heatmap::colors(&standard_errors(picture)?),
        Show::Error => heatmap::colors(&errors(picture, reference?)?),
        Show::EyeSubspaces | Show::LightSubspaces => {
            let side = usize::from(look.show == Show::LightSubspaces);
            let all = snapshot.subspaces.as_ref()?;
            let color =
                |seen: &FirstSubspaces| false_color::label_pixel(seen.labels.map(|labels| labels[side]), 1.0);
            all.par_iter().map(color).collect()
        }
        Show::NonFinite => {
            let counts = snapshot.non_finite.as_ref()?;
            let dim = Look { exposure: look.exposure - 2.0, ..*look };
            let pixel = |(&rgb, &count): (&[f32; 3], &u64)| {
                if count > 0 { MAGENTA } else { png::pixel(rgb, dim.view, dim.exposure) }
            };
            picture.rgb.par_iter().zip(counts.par_iter()).map(pixel).collect()
        }
    };
    to_image(picture.width, picture.height, &pixels)
}

/// A picture by the look's view transform and exposure.
pub fn radiance(picture: &Picture, look: &Look) -> Option<ColorImage> {
    let pixel = |&rgb: &[f32; 3]| match rgb.iter().all(|value| value.is_finite()) {
        true => png::pixel(rgb, look.view, look.exposure),
        false => MAGENTA,
    };
    let pixels: Vec<[u8; 3]> = picture.rgb.par_iter().map(pixel).collect();
    to_image(picture.width, picture.height, &pixels)
}

fn to_image(width: u32, height: u32, pixels: &[[u8; 3]]) -> Option<ColorImage> {
    let size = [width as usize, height as usize];
    let colors: Vec<Color32> = pixels.iter().map(|&[r, g, b]| Color32::from_rgb(r, g, b)).collect();
    // What was requested may be of another size than the picture, for a moment.
    (!colors.is_empty() && colors.len() == size[0] * size[1]).then(|| ColorImage::new(size, colors))
}

/// Standard error of each pixel over its value, with a hundredth of the picture's mean added to that.
fn standard_errors(picture: &Picture) -> Option<Vec<f64>> {
    let known = picture.variance()?;
    let epsilon = 0.01 * mean(picture);
    let relative = |(index, rgb): (usize, &[f32; 3])| {
        let variance: f64 = (0..3).map(|channel| known.at(channel, index)).sum();
        3f64.sqrt() * variance.sqrt() / (sum(rgb) + 3.0 * epsilon).max(f64::MIN_POSITIVE)
    };
    Some(picture.rgb.iter().enumerate().map(relative).collect())
}

/// Absolute difference over the reference, with a hundredth of its mean added to that.
fn errors(picture: &Picture, reference: &Picture) -> Option<Vec<f64>> {
    if [picture.width, picture.height] != [reference.width, reference.height] {
        return None;
    }
    let epsilon = 0.01 * mean(reference);
    let relative = |(a, b): (&[f32; 3], &[f32; 3])| {
        let difference: f64 = (0..3).map(|c| f64::from((a[c] - b[c]).abs())).sum();
        difference / (sum(b) + 3.0 * epsilon).max(f64::MIN_POSITIVE)
    };
    Some(picture.rgb.iter().zip(&reference.rgb).map(relative).collect())
}

fn sum(rgb: &[f32; 3]) -> f64 {
    rgb.iter().map(|&channel| f64::from(channel)).sum()
}

/// Of all channels of all pixels, those that are numbers.
fn mean(picture: &Picture) -> f64 {
    let finite = picture.rgb.iter().map(sum).filter(|sum| sum.is_finite());
    finite.sum::<f64>() / (3 * picture.rgb.len()).max(1) as f64
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::film::Layer;

    fn snapshot(samples: u32) -> Snapshot {
        let mut picture = Picture::new(2, 1, vec![[0.5; 3], [f32::NAN, 0.0, 0.0]]);
        let variance = ["R", "G", "B"].map(|name| (name.to_string(), vec![0.0, 1.0])).into();
        picture.layers.push(Layer { name: "variance".into(), channels: variance });
        let mut snapshot = Snapshot { picture: Arc::new(picture), ..Snapshot::default() };
        snapshot.figures.samples = samples;
        snapshot.non_finite = Some(Arc::new(vec![3, 0]));
        snapshot
    }

    fn look(show: Show) -> Look {
        Look { show, view: ViewTransform::Srgb, exposure: 0.0 }
    }

    fn pixels(snapshot: &Snapshot, show: Show, reference: Option<&Picture>) -> Option<Vec<[u8; 3]>> {
        let image = image(snapshot, &look(show), reference)?;
        assert_eq!(image.size, [2, 1]);
        Some(image.pixels.iter().map(|color| [color.r(), color.g(), color.b()]).collect())
    }

    #[test]
    fn what_is_no_number_is_magenta() {
        // Linear 0.5 is 188 of sRGB.
        assert_eq!(pixels(&snapshot(1), Show::Radiance, None), Some(vec![[188; 3], MAGENTA]));
        // By their counts, over the picture two stops darker: .125 is 99.
        let finite = Snapshot { picture: Arc::new(Picture::new(2, 1, vec![[0.5; 3]; 2])), ..snapshot(1) };
        assert_eq!(pixels(&finite, Show::NonFinite, None), Some(vec![MAGENTA, [99; 3]]));
    }

    #[test]
    fn what_is_not_known_is_not_shown() {
        assert_eq!(pixels(&snapshot(15), Show::Variance, None), None);
        let shown = pixels(&snapshot(16), Show::Variance, None).expect("two groups");
        // No error is black, or nearly so in this map.
        assert!(shown[0].iter().all(|&channel| channel < 8), "{shown:?}");
        assert_eq!(pixels(&snapshot(16), Show::EyeSubspaces, None), None);
        assert_eq!(pixels(&snapshot(16), Show::Error, None), None);
        assert_eq!(pixels(&snapshot(16), Show::Error, Some(&Picture::new(1, 1, vec![[1.0; 3]]))), None);
        let same = Picture::new(2, 1, vec![[0.5; 3], [1.0; 3]]);
        let error = pixels(&snapshot(16), Show::Error, Some(&same)).expect("of the same size");
        assert!(error[0].iter().all(|&channel| channel < 8), "{error:?}");
    }
}
