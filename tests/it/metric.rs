//! Metrics against independent implementations, and the noise tests against noise that is known.

use halfway::film::flip::mean_flip;
use halfway::film::metric::{
    Comparison, NoiseSource, any_beyond, compare, errors, reference_noise, relative_error,
};
use halfway::film::tonemap::ViewTransform;
use halfway::film::{FilmError, Picture, heatmap};
use halfway::math::rng::{RandomKey, uniform4};

const WIDTH: u32 = 53;
const HEIGHT: u32 = 40;

/// Numbers in [0, 1) that the scripts behind the expected values can repeat.
fn hashed(seed: u64) -> Vec<f32> {
    let mask = 0xffff_ffff;
    (0..u64::from(3 * WIDTH * HEIGHT))
        .map(|i| {
            let x = (i * 2_654_435_761 + seed * 40503 * 65537) & mask;
            let x = ((x ^ (x >> 15)) * 2_246_822_519) & mask;
            let x = ((x ^ (x >> 13)) * 3_266_489_917) & mask;
            let x = x ^ (x >> 16);
            (x >> 8) as f32 / (1 << 24) as f32
        })
        .collect()
}

fn pixels(values: Vec<f32>) -> Vec<[f32; 3]> {
    values.as_chunks().0.to_vec()
}

/// A noisy picture, 19 % too bright, with one firefly, and its reference with black parts.
fn noisy_pair() -> [Picture; 2] {
    let (first, second, third) = (hashed(1), hashed(2), hashed(3));
    let reference = first.iter().zip(&second).map(|(a, b)| a * b * 2.0);
    let reference: Vec<f32> = reference.map(|value| if value < 0.01 { 0.0 } else { value }).collect();
    let picture = reference.iter().zip(&third).map(|(value, noise)| value * (0.6 + noise)).collect();
    let mut picture = Picture::new(WIDTH, HEIGHT, pixels(picture));
    picture.rgb[(5 * WIDTH + 7) as usize] = [300.0, 0.5, 0.25];
    [picture, Picture::new(WIDTH, HEIGHT, pixels(reference))]
}

fn of(picture: &Picture, reference: &Picture) -> Comparison {
    compare(picture, reference, ViewTransform::Srgb, 0.0).expect("comparable")
}

fn assert_close(have: f64, want: f64, relative: f64) {
    assert!((have - want).abs() <= relative * want.abs(), "{have} instead of {want}");
}

/// Expected values: NumPy, from the definitions (f64, `int(0.999 n)` kept terms).
#[test]
fn metrics_match_numpy() {
    let [picture, reference] = noisy_pair();
    let comparison = of(&picture, &reference);
    assert_close(comparison.mape, 0.322_642_330_115_928_8, 1e-9);
    assert_close(comparison.relmse, 40.331_490_023_746_966, 1e-9);
    assert_close(comparison.relmse_trimmed, 0.090_396_889_258_086_6, 1e-9);
    assert_close(comparison.mean.ratio, 1.194_093_352_081_955_2, 1e-9);
    assert_close(comparison.mape_paper, 0.241_581_680_210_878_34, 1e-6);
    assert_close(comparison.mape_paper_unclamped, 0.315_268_911_876_864_9, 1e-6);
    assert_close(comparison.psnr, 23.048_631_718_872_41, 1e-6);
    let errors = relative_error(&picture, &reference).expect("comparable");
    assert_close(errors.iter().sum::<f64>() / errors.len() as f64, comparison.mape, 1e-12);
}

/// Expected values: flip-evaluator 1.7, the authors' own code in f32, at the default 67.02 pixels a degree.
#[test]
fn flip_matches_its_authors() {
    let [picture, reference] = noisy_pair();
    let shown = |picture: &Picture| -> Vec<[f32; 3]> {
        picture.rgb.iter().map(|&color| ViewTransform::Srgb.display(0.0, color)).collect()
    };
    let width = WIDTH as usize;
    assert_close(mean_flip(&shown(&picture), &shown(&reference), width), 0.178_294_66, 1e-4);
    assert_eq!(mean_flip(&shown(&reference), &shown(&reference), width), 0.0);

    let coordinates = || (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let first =
        |x: u32, y: u32| [x as f32 / WIDTH as f32, y as f32 / HEIGHT as f32, ((x * y) % 17) as f32 / 17.0];
    let second = |x: u32, y: u32| {
        let stripe = if (x + 2 * y).is_multiple_of(7) { 0.2 } else { 0.0 };
        let grey = (30..45).contains(&x) && (10..20).contains(&y);
        first(x, y).map(|v| if grey { 0.5 } else { (v * 0.9 + 0.05 + stripe).clamp(0.0, 1.0) })
    };
    let a: Vec<[f32; 3]> = coordinates().map(|(x, y)| first(x, y)).collect();
    let b: Vec<[f32; 3]> = coordinates().map(|(x, y)| second(x, y)).collect();
    assert_close(mean_flip(&b, &a, width), 0.252_307_18, 1e-4);

    let black_and_white = mean_flip(&vec![[0.0; 3]; a.len()], &vec![[1.0; 3]; a.len()], width);
    assert_close(black_and_white, 0.967_401_27, 1e-4);
}

#[test]
fn exposure_changes_no_relative_metric() {
    let [mut picture, mut reference] = noisy_pair();
    let before = of(&picture, &reference);
    for value in picture.rgb.iter_mut().chain(&mut reference.rgb) {
        *value = value.map(|channel| channel * 1024.0);
    }
    let after = of(&picture, &reference);
    assert_close(after.mape, before.mape, 1e-12);
    assert_close(after.relmse, before.relmse, 1e-12);
    assert_close(after.mean.ratio, before.mean.ratio, 1e-12);
}

/// A picture of `mean` everywhere with Gaussian noise of deviation `sigma` and its true variance as a layer.
fn noise(seed: u32, mean: f32, sigma: f32, with_variance: bool) -> Picture {
    let (width, height) = (128, 96);
    let gaussian = |u: f32, v: f32| {
        (-2.0 * (1.0 - f64::from(u)).ln()).sqrt() * (std::f64::consts::TAU * f64::from(v)).cos()
    };
    let rgb = (0..width * height).map(|pixel| {
        let key = RandomKey { pixel, sample: 0, seed };
        [0, 1, 2].map(|channel| {
            let u = uniform4(key, channel);
            mean + sigma * gaussian(u.x, u.y) as f32
        })
    });
    let mut picture = Picture::new(width, height, rgb.collect());
    if with_variance {
        for channel in ["R", "G", "B"] {
            picture.push_channel("variance", channel, vec![sigma * sigma; (width * height) as usize]);
        }
    }
    picture
}

#[test]
fn noise_alone_is_no_bias() {
    let (mut beyond, mut z_sq_sum, mut small) = (0, 0.0, 0);
    for seed in 0..40 {
        let comparison = of(&noise(2 * seed, 1.0, 0.1, true), &noise(2 * seed + 1, 1.0, 0.05, true));
        assert_eq!(comparison.mean.source, NoiseSource::Both);
        let tiles = comparison.tiles.expect("both variances");
        assert_eq!(tiles.tests, 16 * 12 * 3);
        beyond += usize::from(tiles.worst_z.abs() > 5.0);
        small += usize::from(tiles.p_value < 0.5);
        z_sq_sum += comparison.mean.z().expect("known noise").powi(2);
    }
    assert_eq!(beyond, 0, "5 standard errors among 576 tests: 3e-4 a run");
    assert!((10..=30).contains(&small), "p-values are uniform: {small} of 40 below one half");
    // Channels here are independent, and counted as correlated: z has the variance 1/3, not 1.
    let z_variance = z_sq_sum / 40.0;
    assert!((0.15..0.7).contains(&z_variance), "{z_variance}");
}

/// A reference's noise adds to the relMSE of what is compared with it; without what it adds, the error is that against
/// the exact picture.
#[test]
fn the_noise_of_a_reference_can_be_subtracted() {
    let picture = noise(3, 1.0, 0.2, false);
    let exact = errors(&picture, &noise(4, 1.0, 0.0, false)).expect("comparable");
    let mut reference = noise(4, 1.0, 0.05, true);
    let noisy = errors(&picture, &reference).expect("comparable");
    let added = reference_noise(&reference).expect("a reference").expect("its variance");
    assert!(noisy.relmse > 1.05 * exact.relmse, "{noisy:?} against {exact:?}");
    assert_close(noisy.relmse - added.relmse, exact.relmse, 0.03);
    // Channels counted as correlated: 0.05 / sqrt(pixels).
    assert_close(added.mean, 0.05 / (128.0f64 * 96.0).sqrt(), 0.01);

    assert_eq!(reference_noise(&picture).expect("a reference"), None);
    // The variance of one sample is not known, whatever the layer holds.
    reference.push_channel("samples", "Y", vec![1.0; 128 * 96]);
    assert_eq!(reference_noise(&reference).expect("a reference"), None);
}

#[test]
fn a_bias_of_one_tile_is_found() {
    let mut picture = noise(7, 1.0, 0.1, true);
    let reference = noise(8, 1.0, 0.001, true);
    for y in 40..48 {
        for x in 64..72 {
            picture.rgb[y * 128 + x][1] *= 1.1;
        }
    }
    let comparison = of(&picture, &reference);
    let tiles = comparison.tiles.expect("both variances");
    assert_eq!((tiles.column, tiles.row, tiles.channel), (64, 40, 1));
    // 0.1 against 0.1 / 8.
    assert!((4.0..12.0).contains(&tiles.worst_z), "{tiles:?}");
    assert!(tiles.p_value < 0.01, "{tiles:?}");
    assert!(comparison.mean.z().expect("known noise").abs() < 3.0, "too small for the mean");
}

#[test]
fn a_global_bias_is_found_from_any_source() {
    for (own, others, source) in [
        (true, true, NoiseSource::Both),
        (true, false, NoiseSource::Picture),
        (false, true, NoiseSource::Reference),
        (false, false, NoiseSource::TileScatter),
    ] {
        let biased = of(&noise(1, 1.01, 0.1, own), &noise(2, 1.0, 0.1, others)).mean;
        assert_eq!(biased.source, source);
        assert!((biased.ratio - 1.01).abs() < 0.005, "{biased:?}");
        assert!(biased.z().expect("known noise") > 4.0, "{biased:?}");
        let fair = of(&noise(3, 1.0, 0.1, own), &noise(4, 1.0, 0.1, others)).mean;
        assert!(fair.z().expect("known noise").abs() < 4.0, "{fair:?}");
        // Independent channels: truly sqrt(2) 0.1 / sqrt(3 pixels); the layers are taken as correlated.
        let truth = 0.1 * 2f64.sqrt() / f64::from(3 * 128 * 96).sqrt();
        let expected = match source {
            NoiseSource::Both => 3f64.sqrt(),
            NoiseSource::TileScatter => 1.0,
            _ => (3f64 / 2.0).sqrt(),
        };
        for mean in [fair, biased] {
            let share = mean.standard_error.expect("known noise") / truth;
            assert!((share / expected - 1.0).abs() < 0.15, "{source:?}: {share} instead of {expected}");
        }
    }
}

#[test]
fn bias_without_noise_is_infinitely_far_off() {
    let (picture, reference) = (noise(1, 2.0, 0.0, true), noise(1, 1.0, 0.0, true));
    assert_eq!(of(&picture, &reference).mean.z(), Some(f64::INFINITY));
    assert_eq!(of(&reference, &reference).mean.z(), Some(0.0));
}

#[test]
fn light_without_noise_is_judged_by_rounding() {
    let mut picture = noise(1, 17.0, 0.0, true);
    let reference = picture.clone();
    assert_eq!(of(&picture, &reference).tiles.expect("variances").worst_z, 0.0);
    picture.rgb.iter_mut().for_each(|pixel| pixel[0] *= 1.0 + 4e-7);
    assert!(of(&picture, &reference).tiles.expect("variances").worst_z.abs() < 1.0);
    picture.rgb[0][0] *= 1.01;
    assert!(of(&picture, &reference).tiles.expect("variances").worst_z > 5.0);
}

#[test]
fn sidak_against_tables() {
    assert_close(any_beyond(1.959_963_984_540_054, 1), 0.05, 1e-12);
    assert_close(any_beyond(-1.959_963_984_540_054, 2), 1.0 - 0.95 * 0.95, 1e-12);
    // Mathematica: 2 (1 - CDF[NormalDistribution[], 8]), times a thousand.
    assert_close(any_beyond(8.0, 1000), 1.244_192_114_854_357e-12, 1e-9);
    assert_eq!(any_beyond(0.0, 5), 1.0);
}

#[test]
fn r09_non_finite_pixels_are_counted_never_skipped() {
    let [picture, reference] = noisy_pair();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut broken = picture.clone();
        broken.rgb[3][2] = value;
        broken.rgb[99] = [value; 3];
        match compare(&broken, &reference, ViewTransform::Srgb, 0.0) {
            Err(FilmError::NonFiniteCompared { picture: 2, reference: 0 }) => {}
            other => panic!("{other:?}"),
        }
        assert!(compare(&picture, &broken, ViewTransform::Srgb, 0.0).is_err());
    }
    let mut broken = picture.clone();
    let mut samples = vec![1.0; picture.rgb.len()];
    samples[5] = f32::NAN;
    for channel in ["R", "G", "B"] {
        broken.push_channel("variance", channel, samples.clone());
    }
    assert!(matches!(
        compare(&broken, &reference, ViewTransform::Srgb, 0.0),
        Err(FilmError::NonFiniteCompared { picture: 1, reference: 0 })
    ));
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let [picture, mut reference] = noisy_pair();
    let small = Picture::new(2, 1, vec![[1.0; 3]; 2]);
    let message = compare(&small, &reference, ViewTransform::Srgb, 0.0).unwrap_err().to_string();
    assert!(message.contains("2 x 1") && message.contains("53 x 40"), "{message}");
    let black = Picture::new(WIDTH, HEIGHT, vec![[0.0; 3]; picture.rgb.len()]);
    assert!(matches!(compare(&picture, &black, ViewTransform::Srgb, 0.0), Err(FilmError::BlackReference)));
    reference.rgb[17][0] = -0.5;
    let negative = compare(&picture, &reference, ViewTransform::Srgb, 0.0);
    assert!(matches!(negative, Err(FilmError::NegativeReference { count: 1 })));
}

#[test]
fn heatmap_is_ordered_by_lightness() {
    let errors: Vec<f64> = (0..=60).map(|i| 1e-3 * 10f64.powf(f64::from(i) / 20.0)).collect();
    let colors = heatmap::colors(&errors);
    let lightness =
        |c: &[u8; 3]| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
    for pair in colors.windows(2) {
        assert!(lightness(&pair[1]) > lightness(&pair[0]) - 0.5, "{pair:?}");
    }
    assert_eq!(heatmap::colors(&[0.0, 1e-3, 1.0, 50.0])[..2], [colors[0]; 2]);
    assert_eq!(heatmap::colors(&[1.0, f64::MAX]), [colors[60]; 2]);
}
