//! How far a picture is from its reference, and whether noise explains it. All sums are `f64`.
//!
//! `a` is a value of the picture, `b` of the reference; both are scene-linear unless stated otherwise.

use std::f64::consts::FRAC_2_PI;

use serde::Serialize;

use super::flip::mean_flip;
use super::tonemap::{ViewTransform, srgb_encode};
use super::{Exposure, Picture, Variance};
use crate::film::FilmError;

/// Edge of the tiles whose means are compared, in pixels.
pub const TILE: u32 = 8;

/// Relative size of what sums in `f32` on different devices may differ by, in place of noise where there is none.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// How far a picture is from a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Mean of |a - b| / (b + e) over pixels and channels, e = 1 % of the reference's mean, so that exposure does not
    /// matter.
    pub mape: f64,
    /// Mean of (a - b)^2 / (b^2 + e^2), the same e.
    pub relmse: f64,
    /// The same without the largest 0.1 % of its terms.
    pub relmse_trimmed: f64,
}

/// What the noise of a reference, known by its variance layer, does to the errors of pictures compared with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReferenceNoise {
    /// What it adds to [`Errors::relmse`] on average: mean of variance / (b^2 + e^2).
    pub relmse: f64,
    /// [`Errors::mape`] to be expected of the reference itself, against the truth. It adds to that of pictures like the
    /// legs of a right triangle, roughly, so that it cannot be subtracted exactly.
    pub mape: f64,
    /// Standard error of the reference's mean, relative to that mean.
    pub mean: f64,
}

/// All metrics of a picture against a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// As in [`Errors`], with the two below.
    pub mape: f64,
    /// MAPE of the subspace-based bidirectional path tracing paper: mean over pixels of the channels' mean of
    /// |a - b| / (b + 0.01), at most 10 per pixel.
    pub mape_paper: f64,
    /// The same without the limit of 10.
    pub mape_paper_unclamped: f64,
    pub relmse: f64,
    pub relmse_trimmed: f64,
    pub mean: MeanRatio,
    /// Whether noise explains the difference of tiles; needs the variance of both pictures.
    pub tiles: Option<TileTest>,
    /// Peak signal-to-noise ratio in decibels of the sRGB signals seen through a view; infinite for equal pictures.
    pub psnr: f64,
    /// Mean LDR-FLIP through the same view, 0 (equal) to 1.
    pub flip: f64,
}

/// The picture's mean over the reference's: the bias, if noise does not explain it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanRatio {
    pub ratio: f64,
    /// Of the ratio; `None` where nothing is known about the noise.
    pub standard_error: Option<f64>,
    pub source: NoiseSource,
}

impl MeanRatio {
    /// Standard errors between the ratio and one; infinite for a bias where there is no noise.
    pub fn z(&self) -> Option<f64> {
        let bias = self.ratio - 1.0;
        self.standard_error.map(|error| if bias == 0.0 { 0.0 } else { bias / error })
    }
}

/// Where the standard error of [`MeanRatio`] comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseSource {
    /// The variance layers of both.
    Both,
    /// The picture's variance layer; the reference counts as exact.
    Picture,
    /// The reference's variance layer; the picture counts as exact.
    Reference,
    /// How much the ratios of 8x8-pixel tiles scatter; a bias that varies over the picture counts as noise.
    TileScatter,
}

/// The tile and channel that differs most, in standard errors of the difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TileTest {
    /// Difference over its standard error, signed: positive where the picture is too bright.
    pub worst_z: f64,
    /// First pixel of that tile.
    pub column: u32,
    pub row: u32,
    /// 0, 1, 2 for red, green, blue.
    pub channel: usize,
    /// Tiles times channels.
    pub tests: usize,
    /// Probability that noise alone brings any of them so far off (Sidak: tests taken as independent).
    pub p_value: f64,
}

/// Number of pixels with a NaN or an infinity in the colours or in the variance.
pub fn non_finite_pixels(picture: &Picture) -> usize {
    let variance = ["R", "G", "B"].map(|channel| picture.channel("variance", channel));
    let is_bad = |(index, pixel): (usize, &[f32; 3])| {
        let bad_variance = variance.iter().flatten().any(|samples| !samples[index].is_finite());
        bad_variance || pixel.iter().any(|value| !value.is_finite())
    };
    picture.rgb.iter().enumerate().filter(|&pixel| is_bad(pixel)).count()
}

/// Compares a picture with its reference; `view` and `exposure` are how both are displayed for PSNR and FLIP.
///
/// # Errors
/// [`FilmError::Sizes`], [`FilmError::NonFiniteCompared`], [`FilmError::BlackReference`],
/// [`FilmError::NegativeReference`].
pub fn compare(
    picture: &Picture,
    reference: &Picture,
    view: ViewTransform,
    exposure: f32,
) -> Result<Comparison, FilmError> {
    let Errors { mape, relmse, relmse_trimmed } = errors(picture, reference)?;
    let display = |picture: &Picture| -> Vec<[f32; 3]> {
        picture.rgb.iter().map(|&radiance| view.display(exposure, radiance)).collect()
    };
    let (shown, shown_reference) = (display(picture), display(reference));
    Ok(Comparison {
        mape,
        mape_paper: mape_paper(picture, reference),
        mape_paper_unclamped: mean(paper_errors(picture, reference)),
        relmse,
        relmse_trimmed,
        mean: mean_ratio(picture, reference),
        tiles: tile_test(picture, reference)?,
        psnr: psnr(&shown, &shown_reference),
        flip: mean_flip(&shown, &shown_reference, picture.width as usize),
    })
}

/// The errors of pixels as [`Comparison::mape_paper`] has them, before their limit.
fn paper_errors<'a>(picture: &'a Picture, reference: &'a Picture) -> impl Iterator<Item = f64> + 'a {
    picture.rgb.iter().zip(&reference.rgb).map(|(a, b)| {
        let error = |c: usize| f64::from((a[c] - b[c]).abs()) / (f64::from(b[c]) + 0.01);
        (error(0) + error(1) + error(2)) / 3.0
    })
}

/// [`Comparison::mape_paper`] alone. They have the same size.
pub fn mape_paper(picture: &Picture, reference: &Picture) -> f64 {
    mean(paper_errors(picture, reference).map(|error| error.min(10.0)))
}

/// Mean LDR-FLIP by the default view, both at the exposure that suits the reference. They have the same size.
pub fn flip(picture: &Picture, reference: &Picture) -> f64 {
    let (view, exposure) = (ViewTransform::default(), Exposure::Auto.stops(reference));
    let display = |picture: &Picture| -> Vec<[f32; 3]> {
        picture.rgb.iter().map(|&radiance| view.display(exposure, radiance)).collect()
    };
    mean_flip(&display(picture), &display(reference), picture.width as usize)
}

/// The errors that need neither noise nor a view.
///
/// # Errors
/// As [`compare`].
pub fn errors(picture: &Picture, reference: &Picture) -> Result<Errors, FilmError> {
    let epsilon = check(picture, reference)?;
    let channels = || {
        let pairs = picture.rgb.as_flattened().iter().zip(reference.rgb.as_flattened());
        pairs.map(|(&a, &b)| (f64::from(a), f64::from(b)))
    };
    let mut squares: Vec<f64> =
        channels().map(|(a, b)| (a - b).powi(2) / (b * b + epsilon * epsilon)).collect();
    squares.sort_by(f64::total_cmp);
    // As many as the reference implementation keeps: the whole part of 99.9 %.
    let kept = (squares.len() as f64 * 0.999) as usize;
    Ok(Errors {
        mape: mean(channels().map(|(a, b)| (a - b).abs() / (b + epsilon))),
        relmse: mean(squares.iter().copied()),
        relmse_trimmed: mean(squares[..kept].iter().copied()),
    })
}

/// What a reference's own noise does to comparisons; `None` where its variance is not known.
///
/// # Errors
/// As [`compare`].
pub fn reference_noise(reference: &Picture) -> Result<Option<ReferenceNoise>, FilmError> {
    let epsilon = check(reference, reference)?;
    // The variance of a single sample is not known.
    let single = |samples: &[f32]| samples.iter().any(|&count| count < 2.0);
    let known = reference.variance().filter(|_| !reference.channel("samples", "Y").is_some_and(single));
    Ok(known.map(|known| {
        let values = reference
            .rgb
            .iter()
            .enumerate()
            .flat_map(|(i, pixel)| (0..3).map(move |c| (known.at(c, i), f64::from(pixel[c]))));
        let squares = values.clone().map(|(variance, b)| variance / (b * b + epsilon * epsilon));
        let sizes = values.map(|(variance, b)| variance.sqrt() / (b + epsilon));
        ReferenceNoise {
            relmse: mean(squares),
            mape: FRAC_2_PI.sqrt() * mean(sizes),
            mean: noise_of_sum(known).sqrt() / sum(reference),
        }
    }))
}

/// Refuses what cannot be compared; returns 1 % of the reference's mean.
fn check(picture: &Picture, reference: &Picture) -> Result<f64, FilmError> {
    if (picture.width, picture.height) != (reference.width, reference.height) {
        return Err(FilmError::Sizes {
            picture: [picture.width, picture.height],
            reference: [reference.width, reference.height],
        });
    }
    let (bad, bad_reference) = (non_finite_pixels(picture), non_finite_pixels(reference));
    if bad + bad_reference > 0 {
        return Err(FilmError::NonFiniteCompared { picture: bad, reference: bad_reference });
    }
    let negative = reference.rgb.iter().filter(|pixel| pixel.iter().any(|&value| value < 0.0)).count();
    if negative > 0 {
        return Err(FilmError::NegativeReference { count: negative });
    }
    let reference_mean = mean(reference.rgb.as_flattened().iter().map(|&b| f64::from(b)));
    if reference_mean == 0.0 {
        return Err(FilmError::BlackReference);
    }
    Ok(0.01 * reference_mean)
}

/// |a - b| / (b + e), the channels' mean, for each pixel; e as in [`Comparison::mape`].
///
/// # Errors
/// As [`compare`].
pub fn relative_error(picture: &Picture, reference: &Picture) -> Result<Vec<f64>, FilmError> {
    let epsilon = check(picture, reference)?;
    let error = |(a, b): (&[f32; 3], &[f32; 3])| {
        mean((0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).abs() / (f64::from(b[c]) + epsilon)))
    };
    Ok(picture.rgb.iter().zip(&reference.rgb).map(error).collect())
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value, count + 1));
    sum / count as f64
}

fn psnr(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    -10.0 * mean(pairs.map(|(&a, &b)| f64::from(srgb_encode(a) - srgb_encode(b)).powi(2))).log10()
}

/// Of all pixels and channels.
fn sum(picture: &Picture) -> f64 {
    picture.rgb.as_flattened().iter().map(|&value| f64::from(value)).sum()
}

/// Variance of that sum. Channels of a pixel come from the same paths: taken as fully correlated, which can only
/// overstate it.
fn noise_of_sum(variance: Variance) -> f64 {
    let pixels = 0..variance.pixels();
    pixels.map(|i| (0..3).map(|c| variance.at(c, i).sqrt()).sum::<f64>().powi(2)).sum()
}

/// The ratio of the means with its standard error.
pub fn mean_ratio(picture: &Picture, reference: &Picture) -> MeanRatio {
    let (total, reference_total) = (sum(picture), sum(reference));
    let ratio = total / reference_total;
    let (own, others) = (picture.variance().map(noise_of_sum), reference.variance().map(noise_of_sum));
    let error = |own: f64, others: f64| Some((own + ratio * ratio * others).sqrt() / reference_total);
    let (standard_error, source) = match (own, others) {
        (Some(own), Some(others)) => (error(own, others), NoiseSource::Both),
        (Some(own), None) => (error(own, 0.0), NoiseSource::Picture),
        (None, Some(others)) => (error(0.0, others), NoiseSource::Reference),
        (None, None) => (tile_scatter(picture, reference, ratio), NoiseSource::TileScatter),
    };
    MeanRatio { ratio, standard_error, source }
}

/// Standard error of the ratio of sums from tiles taken as independent: Cochran, Sampling Techniques, 1977, eq. 2.46.
/// `None` for a single tile.
fn tile_scatter(picture: &Picture, reference: &Picture, ratio: f64) -> Option<f64> {
    let sum = |picture: &Picture, tile: &[usize]| -> f64 {
        tile.iter().flat_map(|&i| picture.rgb[i]).map(f64::from).sum()
    };
    let (mut squares, mut total, mut count) = (0.0, 0.0, 0usize);
    for (_, _, tile) in tiles(reference) {
        let (a, b) = (sum(picture, &tile), sum(reference, &tile));
        squares += (a - ratio * b).powi(2);
        total += b;
        count += 1;
    }
    (count > 1).then(|| (squares * count as f64 / (count - 1) as f64).sqrt() / total)
}

/// Whether noise explains the difference of tiles; `None` where the variance of one is not known.
///
/// # Errors
/// As [`compare`].
pub fn tile_test(picture: &Picture, reference: &Picture) -> Result<Option<TileTest>, FilmError> {
    check(picture, reference)?;
    let (Some(own), Some(others)) = (picture.variance(), reference.variance()) else { return Ok(None) };
    let mut worst = TileTest { worst_z: 0.0, column: 0, row: 0, channel: 0, tests: 0, p_value: 1.0 };
    for (column, row, tile) in tiles(picture) {
        for channel in 0..3 {
            let sum = |rgb: &[[f32; 3]]| tile.iter().map(|&i| f64::from(rgb[i][channel])).sum::<f64>();
            let noise = |variance: Variance| tile.iter().map(|&i| variance.at(channel, i)).sum::<f64>();
            let (a, b) = (sum(&picture.rgb), sum(&reference.rgb));
            let difference = a - b;
            let error = (noise(own) + noise(others) + (ROUNDING * a.abs().max(b.abs())).powi(2)).sqrt();
            worst.tests += 1;
            // Without noise and light on both sides there is nothing to test.
            if difference != 0.0 && (difference / error).abs() > worst.worst_z.abs() {
                worst = TileTest { worst_z: difference / error, column, row, channel, ..worst };
            }
        }
    }
    worst.p_value = any_beyond(worst.worst_z, worst.tests);
    Ok(Some(worst))
}

/// Probability that the largest of `tests` independent standard normal values is beyond `z` on either side.
/// Sidak, Rectangular Confidence Regions for the Means of Multivariate Normal Distributions, JASA 62, 1967.
pub fn any_beyond(z: f64, tests: usize) -> f64 {
    let one = libm::erfc(z.abs() * std::f64::consts::FRAC_1_SQRT_2);
    -f64::exp_m1(tests as f64 * f64::ln_1p(-one))
}

/// First column, first row and pixel indices of every tile; those at the right and lower edge may be smaller.
fn tiles(picture: &Picture) -> impl Iterator<Item = (u32, u32, Vec<usize>)> {
    let (width, height) = (picture.width, picture.height);
    let corners = (0..height)
        .step_by(TILE as usize)
        .flat_map(move |row| (0..width).step_by(TILE as usize).map(move |column| (column, row)));
    corners.map(move |(column, row)| {
        let rows = row..height.min(row + TILE);
        let pixels =
            rows.flat_map(|y| (column..width.min(column + TILE)).map(move |x| (y * width + x) as usize));
        (column, row, pixels.collect())
    })
}
