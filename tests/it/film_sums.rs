//! Sums over many samples stay exact enough: the accumulating kernel, the host's sums, and the loop around them
//! (N-18).

use glam::{DVec3, Vec3};
use halfway::device::layout::{Batch, Counts, FilmPixel};
use halfway::device::{BufferTable, Kernel};
use halfway::film::average::average;
use halfway::film::sums::{FilmSums, PixelSums, SAMPLES_A_FLUSH};
use halfway::film::{Picture, exr, metric};
use halfway::integrator::View;
use halfway::render::{Budget, RenderOptions, Renderer, pixel_sums};
use halfway::scene::builtin::shapes::{looking_at, quad};
use halfway::scene::{Material, Scene};
use rayon::prelude::*;

use crate::gpu;

const PIXELS: u32 = 3;

/// What the device has summed over `samples` samples of every pixel, in batches of at most `batch`.
fn accumulated(radiance: &[[f32; 4]], samples: u32, batch: u32) -> Vec<FilmPixel> {
    let context = gpu::context();
    let kernel = Kernel::new(context, "film_accumulate", Default::default(), &[]).expect("a kernel");
    let mut buffers = BufferTable::default();
    buffers.upload(context, "radiance", radiance).expect("upload");
    buffers.create(context, "film", u64::from(PIXELS) * size_of::<FilmPixel>() as u64).expect("create");
    buffers.create(context, "counts", size_of::<Counts>() as u64).expect("create");
    buffers.upload_uniform(context, "batch", &[Batch::default()]).expect("upload");
    let bound = kernel.bind(context, &buffers).expect("all buffers named");
    for first_sample in (0..samples).step_by(batch as usize) {
        let sample_count = batch.min(samples - first_sample);
        let batch = Batch { pixel_count: PIXELS, first_sample, sample_count, ..Batch::default() };
        buffers.write(context, "batch", bytemuck::bytes_of(&batch)).expect("write");
        let mut encoder = context.device.create_command_encoder(&Default::default());
        bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), PIXELS);
        context.queue.submit([encoder.finish()]);
    }
    let bytes = u64::from(PIXELS) * size_of::<FilmPixel>() as u64;
    bytemuck::pod_collect_to_vec(&buffers.read(context, "film", bytes).expect("read"))
}

#[test]
fn n18_sums_of_many_samples_do_not_stall() {
    const SAMPLES: u32 = 65_536;
    let value = [0.1f32, 0.3, 1e-3];
    let radiance = vec![[value[0], value[1], value[2], 0.0]; (PIXELS * SAMPLES_A_FLUSH) as usize];
    let flushed = accumulated(&radiance, SAMPLES_A_FLUSH, SAMPLES_A_FLUSH);
    let mut sums = FilmSums::new(PIXELS, 1);
    for _ in 0..SAMPLES / SAMPLES_A_FLUSH {
        sums.add(flushed.par_iter().map(pixel_sums));
    }
    let picture = sums.picture(1.0);
    for (rgb, pixel) in picture.rgb.iter().zip(&sums.pixels) {
        assert_eq!(pixel.count, u64::from(SAMPLES));
        for channel in 0..3 {
            let relative = f64::from(rgb[channel]) / f64::from(value[channel]) - 1.0;
            assert!(relative.abs() <= 1e-5, "{relative:e}");
            // A constant has no variance; rounding may leave a share of the square.
            let noise = pixel.variance(channel).sqrt() / f64::from(value[channel]);
            assert!(noise <= 1e-5, "{noise:e}");
        }
    }
    // Without the host's sums the same samples are wrong, or this test would show nothing.
    let stalled = accumulated(&radiance, SAMPLES, SAMPLES_A_FLUSH)[0];
    let relative = f64::from(stalled.sum[0]) / f64::from(SAMPLES) / f64::from(value[0]) - 1.0;
    println!("in f32 alone: {relative:e}");
    assert!(relative.abs() > 1e-5, "{relative:e}");
}

#[test]
fn n18_batches_do_not_show_in_the_sums() {
    let samples = 64;
    let radiance: Vec<[f32; 4]> = (0..PIXELS * samples).map(|_| [0.1, 0.7, 1e-9, 0.0]).collect();
    let whole = accumulated(&radiance, samples, samples);
    for batch in [1, 7, 33] {
        assert_eq!(accumulated(&radiance, samples, batch), whole, "batches of {batch}");
    }
}

#[test]
fn n18_samples_that_are_not_finite_are_counted_and_left_out() {
    let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0, 2.0];
    let radiance: Vec<[f32; 4]> =
        values.iter().flat_map(|&x| [[x, 1.0, 1.0, 0.0], [1.0, 1.0, x, 0.0], [1.0, x, 1.0, 0.0]]).collect();
    for pixel in accumulated(&radiance, values.len() as u32, values.len() as u32).iter().map(pixel_sums) {
        assert_eq!((pixel.count, pixel.non_finite), (2, 3));
        let mut sum = pixel.sum;
        sum.sort_by(f64::total_cmp);
        assert_eq!(sum, [2.0, 2.0, 3.0]);
    }
}

/// A picture may be dimmer than the strongest light of its scene by any factor that f32 knows, and the squares of its
/// samples lie below that range.
#[test]
fn n18_squares_of_dim_samples_do_not_vanish() {
    let groups = |groups: &[f32]| {
        let samples = groups.iter().flat_map(|&value| [value; 8 * PIXELS as usize]);
        let radiance: Vec<[f32; 4]> = samples.map(|value| [value, 0.0, 3.0 * value, 0.0]).collect();
        let samples = 8 * groups.len() as u32;
        pixel_sums(&accumulated(&radiance, samples, samples)[1])
    };
    let bright = groups(&[1.0, 5.0, 2.0]);
    assert_eq!(bright.sum_sq, [240.0, 0.0, 2160.0]);
    for k in [-20, -48, -53, -55, -63, -80, -100, -120] {
        let dim = groups(&[1.0, 5.0, 2.0].map(|value| value * 2f32.powi(k)));
        assert_eq!(dim.sum, bright.sum.map(|sum| sum * 2f64.powi(k)), "2^{k}");
        assert_eq!(dim.sum_sq, bright.sum_sq.map(|sum| sum * 2f64.powi(2 * k)), "2^{k}");
        assert!(dim.variance(0) > 0.0);
    }
    // Dim ones and others, in any order.
    let [dim, other] = [-53, -50].map(|k| 2f32.powi(k));
    let expected = 8.0 * (f64::from(dim).powi(2) + f64::from(other).powi(2));
    for order in [[dim, 0.0, other], [other, dim, 0.0], [0.0, dim, other]] {
        assert_eq!(groups(&order).sum_sq[0], expected, "{order:?}");
    }
    assert_eq!(groups(&[2f32.powi(-90), 1.0, 2f32.powi(-90)]).sum_sq[0], 8.0);
}

/// The layer of variances is in f32, and squares go twice as far as radiance does.
#[test]
fn variances_fit_their_layer_at_any_scale() {
    let folder = tempfile::tempdir().expect("a folder");
    let film = {
        let mut pixels = [PixelSums::default(); 2];
        for (pixel, sums) in pixels.iter_mut().zip([[8.0, 24.0], [80.0, 16.0]]) {
            sums.iter().for_each(|&sum| pixel.add_group([sum, 2.0 * sum, 0.5 * sum], 8));
        }
        let mut film = FilmSums::new(2, 1);
        film.add(pixels);
        film
    };
    let variances = |picture: &Picture| -> Vec<f64> {
        let variance = picture.variance().expect("a layer");
        (0..6).map(|index| variance.at(index % 3, index / 3)).collect()
    };
    let plain = film.picture(1.0);
    assert_eq!(plain.variance_scale, None);
    let expected: Vec<f64> =
        film.pixels.iter().flat_map(|pixel| [0, 1, 2].map(|channel| pixel.variance(channel))).collect();
    assert_eq!(variances(&plain), expected);
    for k in [-120, -100, -60, -20, 20, 60, 100, 120] {
        let picture = film.picture(2f64.powi(k));
        let path = folder.path().join("picture.exr");
        exr::write(&path, &picture).expect("written");
        let read = Picture::read(&path).expect("read");
        assert_eq!(read.variance_scale, picture.variance_scale);
        let expected: Vec<f64> = expected.iter().map(|variance| variance * 2f64.powi(2 * k)).collect();
        assert_eq!(variances(&read), expected, "2^{k}");
        let stored = read.channel("variance", "R").expect("a layer");
        assert!(stored.iter().all(|value| value.is_normal()), "2^{k}: {stored:?}");
        let both = average([&read, &picture], [1.0; 2]).expect("one size");
        let halves: Vec<f64> = expected.iter().map(|variance| 0.5 * variance).collect();
        assert_eq!(variances(&both), halves, "2^{k}");
        // What is said of the noise does not depend on the scale.
        let noise = |picture: &Picture| metric::reference_noise(picture).expect("light").expect("two groups");
        let difference = noise(&read).mape / noise(&plain).mape - 1.0;
        assert!(difference.abs() < 1e-6, "2^{k}: {difference:e}");
    }
}

/// Samples of a group depend on each other: what counts is how the groups scatter.
#[test]
fn variance_is_that_of_groups() {
    // Eleven samples, a group of eight and one of three.
    let value = |sample: u32| (sample * sample % 7) as f32;
    let radiance: Vec<[f32; 4]> =
        (0..11).flat_map(|sample| vec![[value(sample), 1.0, 0.0, 0.0]; PIXELS as usize]).collect();
    let sums = pixel_sums(&accumulated(&radiance, 11, 11)[1]);
    assert_eq!((sums.count, sums.groups), (11, 2));
    let total = |samples: std::ops::Range<u32>| samples.map(|sample| f64::from(value(sample))).sum::<f64>();
    let (first, second) = (total(0..8), total(8..11));
    let mean = (first + second) / 11.0;
    let scatter = 8.0 * (first / 8.0 - mean).powi(2) + 3.0 * (second / 3.0 - mean).powi(2);
    assert!((sums.variance(0) - scatter / 11.0).abs() < 1e-12, "{} {}", sums.variance(0), scatter / 11.0);
    assert!(sums.variance(1).abs() < 1e-12);
    // Of one group nothing is known.
    let sums = pixel_sums(&accumulated(&radiance, 8, 8)[1]);
    assert_eq!((sums.groups, sums.variance(0)), (1, 0.0));
}

/// Earlier samples that weigh less: their mean and its variance, whether or not the weights are the best.
#[test]
fn earlier_samples_have_their_weight() {
    let groups = |sums: &[f64]| {
        let mut pixel = PixelSums::default();
        sums.iter().for_each(|&sum| pixel.add_group([sum, 1.0, 0.0], 8));
        pixel
    };
    let parts = [groups(&[40.0, 8.0, 24.0]), groups(&[12.0, 4.0]), groups(&[7.0, 9.0, 8.0, 12.0])];
    let mut film = FilmSums::new(1, 1);
    film.add([parts[0]]);
    film.settle();
    film.add([parts[1]]);
    film.weigh_earlier(0.25);
    film.settle();
    film.weigh_earlier(0.5);
    film.add([parts[2]]);
    let weights = [0.125, 0.5, 1.0];
    let say = |part: usize| weights[part] * parts[part].count as f64;
    let whole: f64 = (0..3).map(say).sum();
    let mean: f64 = (0..3).map(|part| say(part) / whole * parts[part].mean()[0]).sum();
    let variance: f64 = (0..3).map(|part| (say(part) / whole).powi(2) * parts[part].variance(0)).sum();
    let picture = film.picture(1.0);
    assert!((f64::from(picture.rgb[0][0]) / mean - 1.0).abs() < 1e-6, "{} {mean}", picture.rgb[0][0]);
    let claimed = f64::from(picture.channel("variance", "R").expect("a layer")[0]);
    assert!((claimed / variance - 1.0).abs() < 1e-6, "{claimed} {variance}");
    assert_eq!(picture.channel("samples", "Y").expect("a layer")[0], 72.0);
    // A single group has no variance of its own: with the right weights it scatters as the others.
    let mut film = FilmSums::new(1, 1);
    film.add([parts[0]]);
    film.settle();
    film.weigh_earlier(0.5);
    let alone = film.picture(1.0).channel("variance", "R").expect("a layer")[0];
    assert!((f64::from(alone) / parts[0].variance(0) - 1.0).abs() < 1e-6);
    film.add([groups(&[16.0])]);
    let more = film.picture(1.0).channel("variance", "R").expect("a layer")[0];
    // 12 samples' worth before, 8 more.
    assert!((f64::from(more / alone) - 12.0 / 20.0).abs() < 1e-6, "{more} {alone}");
}

/// Pixels that have found nothing are as wrong as they can be where light is rare, and right where all around is sure.
#[test]
fn black_pixels_are_believed_where_their_surroundings_are_sure() {
    let estimate = |lit: fn(usize, usize) -> Option<[f64; 2]>| {
        let pixel = |i: usize| {
            let mut pixel = PixelSums::default();
            let groups = lit(i % 30, i / 30).unwrap_or([0.0; 2]);
            groups.iter().for_each(|&sum| pixel.add_group([sum; 3], 8));
            pixel
        };
        let mut film = FilmSums::new(30, 30);
        film.add((0..900).map(pixel).collect::<Vec<_>>());
        film.estimated_error().expect("two groups")
    };
    // One sample in the whole picture has found the lamp.
    let rare = estimate(|x, y| (x == 14 && y == 14).then_some([800.0, 0.0]));
    // Its 8 neighbours and itself think about their common error, the others know nothing.
    assert!((0.98..1.1).contains(&rare), "{rare}");
    // A thing before a black background, known to 1 %.
    let thing = estimate(|x, y| ((10..20).contains(&x) && (5..25).contains(&y)).then_some([8.08, 7.92]));
    assert!((1e-3..0.02).contains(&thing), "{thing}");
}

/// The loop around it all: a wall that glows with 0.1 and reflects nothing, sampled 8192 times.
#[test]
fn n18_the_renderer_takes_the_sums_in_time() {
    let material = Material { emission: Vec3::splat(0.1), ..Material::lambert("lamp", Vec3::ZERO) };
    let scene = Scene {
        materials: vec![material],
        meshes: vec![quad(DVec3::new(-1.0, -1.0, 0.0), 2.0 * DVec3::X, 2.0 * DVec3::Y)],
        cameras: vec![looking_at("camera", DVec3::Z, DVec3::ZERO, 30.0)],
        ..Scene::default()
    };
    let budget = Budget { samples: Some(8192), ..Budget::default() };
    let options = RenderOptions {
        view: View { width: 1, height: 1, max_depth: Some(1), ..View::default() },
        budget,
        ..Default::default()
    };
    let mut renderer = Renderer::new(gpu::context(), &scene, options).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    let picture = renderer.picture().expect("a picture");
    let relative = f64::from(picture.rgb[0][0]) / f64::from(0.1f32) - 1.0;
    println!("relative error {relative:e}");
    assert!(relative.abs() <= 1e-6, "{relative:e}");
}
