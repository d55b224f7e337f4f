//! LDR-FLIP: how different two pictures look when flipped back and forth on a screen.
//!
//! Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild, FLIP: A Difference Evaluator for Alternating
//! Images, Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020. Names and constants follow sections 4.1 to 4.3.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Observer 0.7 m from a 0.7 m wide screen of 3840 pixels, the paper's default: about 67.
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// Exponent of the colour difference, section 4.1.3.
const COLOR_EXPONENT: f64 = 0.7;
/// Share of the largest colour difference that maps to [`CUT_VALUE`], section 4.1.3.
const CUT_SHARE: f64 = 0.4;
const CUT_VALUE: f64 = 0.95;
/// Width of the feature detectors in degrees of visual angle, section 4.2.
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f64 = 0.5;

/// Contrast sensitivity of the achromatic, red-green and blue-yellow channels as (a1, b1, a2, b2), table 1.
const SENSITIVITY: [[f64; 4]; 3] =
    [[1.0, 0.0047, 0.0, 1e-5], [1.0, 0.0053, 0.0, 1e-5], [34.1, 0.04, 13.5, 0.025]];

/// Linear Rec.709 to CIE XYZ under D65, columns of red, green and blue.
fn rgb_to_xyz() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
        DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
        DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
    )
}

/// Mean over the pixels of two display pictures (linear Rec.709 in [0, 1], rows of `width`) of equal size.
pub fn mean_flip(test: &[[f32; 3]], reference: &[[f32; 3]], width: usize) -> f64 {
    let (test, reference) = (Seen::new(test, width), Seen::new(reference, width));
    let largest = hyab(hunt(lab(DVec3::Y)), hunt(lab(DVec3::Z))).powf(COLOR_EXPONENT);
    let errors = (0..test.colors.len()).into_par_iter().map(|i| {
        let color = hyab(test.colors[i], reference.colors[i]).powf(COLOR_EXPONENT);
        let color = redistribute(color, largest);
        let feature =
            (test.edges[i] - reference.edges[i]).abs().max((test.points[i] - reference.points[i]).abs());
        let feature = (FRAC_1_SQRT_2 * feature).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature)
    });
    // Collected first: a sum in the order of threads would differ from run to run.
    let errors: Vec<f64> = errors.collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// What an observer makes of a picture.
struct Seen {
    /// Hunt-adjusted L*a*b* after the eye's filter.
    colors: Vec<DVec3>,
    /// Strength of edges and of points in the unfiltered luminance.
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Seen {
    fn new(linear: &[[f32; 3]], width: usize) -> Self {
        let to_xyz = rgb_to_xyz();
        let white = to_xyz * DVec3::ONE;
        let opponent: Vec<DVec3> = linear
            .par_iter()
            .map(|rgb| {
                let xyz = to_xyz * DVec3::from(rgb.map(f64::from)) / white;
                // YCxCz, a linear relative of L*a*b*.
                DVec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
            })
            .collect();
        let plane = |channel: usize| -> Vec<f64> { opponent.iter().map(|color| color[channel]).collect() };
        let filtered = [0, 1, 2].map(|channel| contrast_filter(&plane(channel), width, SENSITIVITY[channel]));
        let to_rgb = to_xyz.inverse();
        let colors = (0..linear.len()).into_par_iter().map(|i| {
            let y = (filtered[0][i] + 16.0) / 116.0;
            let xyz = DVec3::new(y + filtered[1][i] / 500.0, y, y - filtered[2][i] / 200.0);
            hunt(lab((to_rgb * (xyz * white)).clamp(DVec3::ZERO, DVec3::ONE)))
        });
        let luminance: Vec<f64> = opponent.iter().map(|color| (color.x + 16.0) / 116.0).collect();
        let [edges, points] = features(&luminance, width);
        Self { colors: colors.collect(), edges, points }
    }
}

/// Equation 5: the sum of two Gaussians in degrees, each separable, together of weight one.
fn contrast_filter(plane: &[f64], width: usize, [a1, b1, a2, b2]: [f64; 4]) -> Vec<f64> {
    let widest = SENSITIVITY.iter().flat_map(|s| [s[1], s[3]]).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let mut sum = vec![0.0; plane.len()];
    let mut weight = 0.0;
    for (a, b) in [(a1, b1), (a2, b2)] {
        if a == 0.0 {
            continue;
        }
        let gaussian = |x: i32| (-PI * PI / b * (f64::from(x) / PIXELS_PER_DEGREE).powi(2)).exp();
        let kernel: Vec<f64> = (-radius..=radius).map(gaussian).collect();
        let height = a * (PI / b).sqrt();
        weight += height * kernel.iter().sum::<f64>().powi(2);
        let filtered = convolve(plane, width, &kernel, &kernel);
        sum.iter_mut().zip(filtered).for_each(|(sum, value)| *sum += height * value);
    }
    sum.iter_mut().for_each(|value| *value /= weight);
    sum
}

/// Section 4.2: lengths of the gradients by first (edges) and second (points) derivatives of a Gaussian.
fn features(luminance: &[f64], width: usize) -> [Vec<f64>; 2] {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let offsets = || (-radius..=radius).map(f64::from);
    let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let smooth = normalize(offsets().map(gaussian).collect());
    let edge = normalize(offsets().map(|x| -x * gaussian(x)).collect());
    let point = normalize(offsets().map(|x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)).collect());
    [edge, point].map(|kernel| {
        let across = convolve(luminance, width, &kernel, &smooth);
        let along = convolve(luminance, width, &smooth, &kernel);
        across.into_iter().zip(along).map(|(x, y)| x.hypot(y)).collect()
    })
}

/// Scales the positive weights to the sum 1 and the negative ones to -1.
fn normalize(kernel: Vec<f64>) -> Vec<f64> {
    let sum = |sign: f64| kernel.iter().filter(|&&w| w * sign > 0.0).sum::<f64>().abs();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    kernel.iter().map(|&w| if w < 0.0 { w / negative } else { w / positive }).collect()
}

/// Separable convolution, the border's values continued outwards.
fn convolve(plane: &[f64], width: usize, horizontal: &[f64], vertical: &[f64]) -> Vec<f64> {
    let height = plane.len() / width;
    // Both kernels are mirrored with respect to a textbook convolution, as in the authors' code; lengths of gradients
    // do not notice.
    let near = |position: usize, tap: usize, kernel: &[f64], size: usize| {
        (position + tap).saturating_sub(kernel.len() / 2).min(size - 1)
    };
    let rows = plane.par_chunks_exact(width).flat_map_iter(|row| {
        (0..width).map(move |x| {
            let taps = horizontal.iter().enumerate();
            taps.map(|(tap, weight)| weight * row[near(x, tap, horizontal, width)]).sum::<f64>()
        })
    });
    let rows: Vec<f64> = rows.collect();
    let columns = (0..plane.len()).into_par_iter().map(|i| {
        let (x, y) = (i % width, i / width);
        let taps = vertical.iter().enumerate();
        taps.map(|(tap, weight)| weight * rows[near(y, tap, vertical, height) * width + x]).sum::<f64>()
    });
    columns.collect()
}

/// CIE L*a*b* of linear Rec.709, relative to its white.
fn lab(rgb: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let curve = |t: f64| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let to_xyz = rgb_to_xyz();
    let xyz = to_xyz * rgb / (to_xyz * DVec3::ONE);
    let (x, y, z) = (curve(xyz.x), curve(xyz.y), curve(xyz.z));
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// The Hunt effect: colours look less colourful in the dark, section 4.1.3.
fn hunt(lab: DVec3) -> DVec3 {
    DVec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
}

/// Distance that adds lightness to the Euclidean distance of the other two (Abasi and others 2020).
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// Spreads small colour differences over most of [0, 1], section 4.1.3.
fn redistribute(difference: f64, largest: f64) -> f64 {
    let cut = CUT_SHARE * largest;
    if difference < cut {
        CUT_VALUE / cut * difference
    } else {
        CUT_VALUE + (difference - cut) / (largest - cut) * (1.0 - CUT_VALUE)
    }
}
