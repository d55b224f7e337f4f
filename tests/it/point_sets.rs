//! Samples that lie well apart: where their points are, and that their variance is not understated.

use glam::{DVec3, Vec3};
use halfway::device::layout::SAMPLES_A_GROUP;
use halfway::film::{Region, metric};
use halfway::integrator::{Connections, LvcBpt, Method, View};
use halfway::render::{Budget, RenderOptions, Renderer};
use halfway::scene::builtin::builtin;
use halfway::scene::builtin::shapes::{looking_at, quad};
use halfway::scene::{Material, Scene};

use crate::gpu;

/// Light paths: the powers of 1 / x, x^7 = x + 1. Groups: eight points, every number in each eighth once.
#[test]
fn steps_are_those_of_the_sequences() {
    let body = "fn twin(x: array<u32, 1>) -> array<u32, 16> {
        var all: array<u32, 16>;
        for (var i = 0u; i < 6u; i++) { var six = KRONECKER_6; all[i] = six[i]; }
        for (var i = 0u; i < 10u; i++) { var eight = LATTICE_8; all[6u + i] = eight[i]; }
        return all;
    }";
    let [all] = gpu::map::<1, 16>(&["lib/kronecker"], body, &[[0]])[..] else { panic!("one answer") };
    let x = (0..200).fold(1.5f64, |x, _| (1.0 + x).powf(1.0 / 7.0));
    for (power, &step) in (1..).zip(&all[..6]) {
        let expected = x.powi(-power).fract() * 2f64.powi(32);
        assert!((f64::from(step) - expected).abs() <= 2.0, "{power}: {step:x}, {expected}");
    }
    for step in &all[6..] {
        let mut eighths: Vec<u32> =
            (0..SAMPLES_A_GROUP).map(|point| point.wrapping_mul(*step) / (u32::MAX / 8 + 1)).collect();
        eighths.sort_unstable();
        assert_eq!(eighths, (0..8).collect::<Vec<_>>(), "{step:x}");
    }
}

/// Estimated variance of a picture's pixels, summed, over how much pictures of other seeds really scatter.
fn claimed_over_true(method: Method, samples: u32) -> f64 {
    const SEEDS: u64 = 64;
    let scene = builtin("cornell").expect("a built-in scene");
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    // Without the lamp, whose few pixels have most of the variance: their scatter would hide the rest.
    let crop = Some(Region::new(0, 12, 24, 12));
    let options = RenderOptions {
        view: View { width: 24, height: 24, crop, max_depth: Some(4), ..View::default() },
        method,
        budget,
        ..Default::default()
    };
    let mut renderer = Renderer::new(gpu::context(), &scene, options).expect("a renderer");
    let mut claimed = 0.0;
    let mut pictures = Vec::new();
    for seed in 0..SEEDS {
        renderer.restart(seed, None).expect("a renderer");
        renderer.run(|_| false).expect("a render");
        let picture = renderer.picture().expect("a picture");
        let variance = ["R", "G", "B"].map(|channel| picture.channel("variance", channel).expect("a layer"));
        claimed += variance.iter().flat_map(|channel| channel.iter()).map(|&v| f64::from(v)).sum::<f64>();
        pictures.push(picture.rgb);
    }
    let mut scatter = 0.0;
    for pixel in 0..pictures[0].len() {
        for channel in 0..3 {
            let values = || pictures.iter().map(|rgb| f64::from(rgb[pixel][channel]));
            let mean = values().sum::<f64>() / SEEDS as f64;
            scatter += values().map(|value| (value - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
        }
    }
    claimed / SEEDS as f64 / scatter
}

/// The samples of a group are not independent (they scatter less than as many independent ones), and where they share
/// light paths neither are their errors; the estimated variance must be right all the same. Of samples taken for
/// independent it would be a fifth too large for the path tracer.
#[test]
fn variance_is_calibrated() {
    let lvc = Method::LvcBpt(LvcBpt {
        light_paths: Some(64),
        connections: Connections::even(2),
        light_tracing: false,
    });
    for (method, samples) in [(Method::Path, 32), (lvc, 32)] {
        let ratio = claimed_over_true(method, samples);
        println!("{} {samples}: {ratio:.3}", method.name());
        assert!((ratio - 1.0).abs() < 0.08, "{} {samples}: {ratio}", method.name());
    }
}

/// Across the edge of a lamp the samples of a group scatter far less than independent ones: a pixel that it covers by a
/// share s would have s (1 - s) for each of them.
#[test]
fn samples_of_a_group_lie_apart() {
    const GROUPS: u32 = 64;
    let lamp = Material { emission: Vec3::ONE, ..Material::lambert("lamp", Vec3::ZERO) };
    let budget = Budget { samples: Some(GROUPS * SAMPLES_A_GROUP), ..Budget::default() };
    let options = RenderOptions {
        view: View { width: 1, height: 1, max_depth: Some(1), ..View::default() },
        budget,
        ..Default::default()
    };
    // Seen from one away with 2 x 2 in sight; the lamp ends within it, on one side or across.
    for (width, height) in [(1.3, 8.0), (8.0, 1.3), (1.3, 1.6)] {
        let wall = quad(DVec3::new(-1.0, -1.0, 0.0), width * DVec3::X, height * DVec3::Y);
        let cameras = vec![looking_at("camera", DVec3::Z, DVec3::ZERO, 90.0)];
        let scene = Scene { materials: vec![lamp.clone()], meshes: vec![wall], cameras, ..Scene::default() };
        let mut renderer = Renderer::new(gpu::context(), &scene, options.clone()).expect("a renderer");
        renderer.run(|_| false).expect("a render");
        let picture = renderer.picture().expect("a picture");
        let variance = f64::from(picture.channel("variance", "R").expect("a layer")[0]);
        let share = (width / 2.0).min(1.0) * (height / 2.0).min(1.0);
        assert!((f64::from(picture.rgb[0][0]) - share).abs() < 0.05, "{:?} is not {share}", picture.rgb[0]);
        let independent = share * (1.0 - share) / f64::from(GROUPS * SAMPLES_A_GROUP);
        println!("{width} x {height}: {:.3} of independent samples", variance / independent);
        assert!(variance < 0.5 * independent, "{width} x {height}: {variance:e}, {independent:e}");
    }
}

/// The estimated error is near the true one, where light is easy to find and where most pixels have missed most of it:
/// by each pixel's own variance it would be a quarter of the truth at 16 samples behind the door.
#[test]
fn estimated_error_is_near_the_true_one() {
    for (name, samples) in [("cornell", 16), ("door", 16)] {
        let scene = builtin(name).expect("a built-in scene");
        let render = |method: Method, samples: u32, seed: u64| {
            let budget = Budget { samples: Some(samples), ..Budget::default() };
            let options = RenderOptions {
                view: View { width: 48, height: 32, seed, ..View::default() },
                method,
                budget,
                ..RenderOptions::default()
            };
            let mut renderer = Renderer::new(gpu::context(), &scene, options).expect("a renderer");
            renderer.run(|_| false).expect("a render");
            let estimate = renderer.report().expect("a report").estimated_error.expect("two groups");
            (renderer.picture().expect("a picture"), estimate)
        };
        let lvc = Method::LvcBpt(LvcBpt {
            light_paths: None,
            connections: Connections::even(4),
            light_tracing: false,
        });
        let (truth, rest) = render(lvc, 256, 1);
        let (picture, estimate) = render(Method::Path, samples, 2);
        let error = metric::errors(&picture, &truth).expect("one size").mape;
        println!("{name}, {samples}: estimated {estimate:.3}, true {error:.3}, of the reference {rest:.3}");
        assert!(rest < 0.25 * error, "the reference has an error of {rest} itself");
        assert!((0.8..1.25).contains(&(estimate / error)), "{name}, {samples}: {estimate} for {error}");
    }
}
