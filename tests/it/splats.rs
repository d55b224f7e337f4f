//! Sums of splats in fixed point: nothing is lost, nothing depends on the order (N-19).

use glam::DVec3;
use halfway::device::Feature;
use halfway::integrator::{Bdpt, LightTracing, Method, View};
use halfway::render::RenderOptions;
use halfway::scene::builtin::shapes;
use halfway::scene::{Material, Mesh, Scene};

use crate::gpu;
use crate::judge::{grey, horizontal, lamp, scene};
use crate::random::Stream;
use crate::shots::{options, render};

/// Units of `lib/splat` in one.
const UNITS: f64 = (1u64 << 44) as f64;
const WORDS: usize = 7;

/// Adds contributions to the pixels `index % pixels`, one invocation each; the words of every pixel.
fn added(contributions: &[[f32; 3]], pixels: usize) -> Vec<[u32; WORDS]> {
    let kernel = format!(
        "#import lib/splat
        @group(0) @binding(0) var<storage, read> contributions: array<f32>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let index = id.x + id.y * 65535u * 64u;
            if index < {count}u {{
                let first = 3u * index;
                let light =
                    vec3f(contributions[first], contributions[first + 1u], contributions[first + 2u]);
                add_splat(index % {pixels}u, light);
            }}
        }}",
        count = contributions.len()
    );
    let output = gpu::run(
        &kernel,
        &[Feature::SplatsAtomic],
        &[("contributions", bytemuck::cast_slice(contributions.as_flattened()))],
        &[("splats", pixels * WORDS * 4)],
        contributions.len() as u32,
    );
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&output[0]);
    words.as_chunks().0.to_vec()
}

fn units(pixel: &[u32; WORDS], channel: usize) -> u64 {
    u64::from(pixel[2 * channel]) | u64::from(pixel[2 * channel + 1]) << 32
}

#[test]
fn n19_sums_of_splats_are_exact_in_any_order() {
    let mut random = Stream::new(19);
    // All of them whole numbers of units. Half of the additions carry into the high word.
    let mut contributions: Vec<[f32; 3]> = (0..60_000)
        .map(|_| [-2, -10, -14].map(|exponent| (0.5 + random.f32()) * 2f32.powi(exponent)))
        .collect();
    let words = added(&contributions, 3);
    for (pixel, words) in words.iter().enumerate() {
        for channel in 0..3 {
            let mine = contributions.iter().skip(pixel).step_by(3);
            let expected: u64 = mine.map(|light| (f64::from(light[channel]) * UNITS) as u64).sum();
            assert_eq!(units(words, channel), expected, "pixel {pixel}, channel {channel}");
        }
        assert_eq!(words[6], 0, "nothing is lost");
    }
    // Each pixel keeps its own, in another order.
    contributions.rotate_left(3 * 12_345);
    contributions.chunks_mut(6).for_each(|six| {
        let (a, b) = six.split_at_mut(3);
        a.swap_with_slice(b);
    });
    assert_eq!(added(&contributions, 3), words);
}

/// What lies between two units goes to either, and the mean is right.
#[test]
fn n19_splats_below_a_unit_are_right_on_average() {
    let mut random = Stream::new(20);
    for exponent in [-46, -44, -34, -24] {
        let contributions: Vec<[f32; 3]> =
            (0..100_000).map(|_| [0; 3].map(|_| (1.0 + random.f32()) * 2f32.powi(exponent))).collect();
        let words = added(&contributions, 1);
        for channel in 0..3 {
            let exact = || contributions.iter().map(|light| f64::from(light[channel]) * UNITS);
            let variance: f64 = exact().map(|x| x.fract() * (1.0 - x.fract())).sum();
            let (sum, found) = (exact().sum::<f64>(), units(&words[0], channel) as f64);
            let z = (found - sum) / variance.max(1e-9).sqrt();
            println!("2^{exponent}: {found} units, {sum} exactly, z = {z:.2}");
            assert!(z.abs() < 5.0, "2^{exponent}: {found} units instead of {sum}");
        }
    }
}

/// What is not finite or too large is counted and stays out; the largest that is allowed arrives.
#[test]
fn n19_splats_that_do_not_fit_are_counted() {
    let largest = 2f32.powi(18).next_down();
    let bad = [f32::NAN, -f32::NAN, f32::INFINITY, f32::MAX, 2f32.powi(18)];
    let mut contributions: Vec<[f32; 3]> = bad.map(|bad| [0.5, bad, 0.25]).to_vec();
    contributions.extend([[largest, 0.0, 1.0]; 3]);
    let words = added(&contributions, 1);
    assert_eq!(words[0][6], bad.len() as u32);
    let expected = [3.0 * f64::from(largest), 0.0, 3.0];
    for (channel, expected) in expected.into_iter().enumerate() {
        assert_eq!(units(&words[0], channel), (expected * UNITS) as u64);
    }
    // Sums past the last word are seen as well.
    let words = added(&[[largest; 3]; 6], 1);
    assert!(words[0][6] > 0);
}

/// The film finds what was added, for each of the samples that share it.
#[test]
fn n19_splats_stay_and_what_is_lost_counts_once() {
    let sum = [5.0 + 2f64.powi(-20), 2f64.powi(-44), 3e5f32.into()];
    let mut words = [0u32; 2 * WORDS];
    for (channel, sum) in sum.into_iter().enumerate() {
        let units = (sum * UNITS) as u64;
        words[WORDS + 2 * channel] = units as u32;
        words[WORDS + 2 * channel + 1] = (units >> 32) as u32;
    }
    words[WORDS + 6] = 3;
    let kernel = "#import lib/splat
        @group(0) @binding(0) var<storage, read> words: array<u32>;
        @group(0) @binding(1) var<storage, read_write> found: array<vec4f>;
        @compute @workgroup_size(1)
        fn main() {
            for (var word = 0u; word < 14u; word++) {
                splats[word] = words[word];
            }
            found[0] = splat_of(1u);
            found[1] = splat_of(1u);
        }";
    let inputs = [("words", bytemuck::cast_slice(&words))];
    let output = gpu::run(kernel, &[], &inputs, &[("splats", 8 * WORDS), ("found", 32)], 1);
    let [first, second]: [[f32; 4]; 2] = bytemuck::pod_read_unaligned(&output[1]);
    for (found, expected) in first.iter().zip(sum) {
        assert!((f64::from(*found) / expected - 1.0).abs() < 2e-7, "{found} instead of {expected}");
    }
    assert_eq!(first[3], 3.0);
    let [light @ .., lost] = second;
    assert_eq!((light.as_slice(), lost), (&first[..3], 0.0));
}

/// A lamp of 10^-18 units of area and 2 10^17 of radiance: what it lights is 10^-18 times as bright, far below a unit of the
/// strongest light.
pub fn dim_lamp() -> Scene {
    let mut scene =
        scene([(grey(0.5), horizontal(2.0, 0.0, true)), (lamp(2e17), horizontal(1e-9, 0.5, false))]);
    scene.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 0.4, 0.1), DVec3::ZERO, 90.0));
    scene
}

#[test]
fn n19_light_is_summed_in_units_of_the_picture() {
    let scene = dim_lamp();
    let picture = |method: Method, samples| {
        let size = options([16, 16], samples);
        render(&scene, RenderOptions { view: View { max_depth: Some(2), ..size.view }, method, ..size })
    };
    let expected = picture(Method::Path, 64).channel(1);
    let light = picture(Method::Light(LightTracing { light_paths: None }), 64);
    let found = light.channel(1);
    println!("light {found:?}, path {expected:?}");
    assert!(found.error < 0.02 * found.mean && found.z(expected).abs() < 5.0, "{found:?}, not {expected:?}");
    assert!(light.report.caveats.is_empty(), "{:?}", light.report.caveats);
}

/// A picture that stays black by `light` says so.
#[test]
fn light_that_cannot_reach_the_camera_is_named() {
    let mirror = Material { metallic: 1.0, roughness: 0.0, name: "glaze".into(), ..Material::default() };
    let mut scene =
        scene([(mirror.clone(), horizontal(2.0, 0.0, true)), (lamp(1.0), horizontal(1.0, 1.0, false))]);
    scene.cameras.push(shapes::looking_at("down", DVec3::new(0.0, 0.5, 0.1), DVec3::ZERO, 40.0));
    let caveats = |scene: &Scene, method| {
        render(scene, RenderOptions { method, ..options([16, 16], 1) }).report.caveats
    };
    let light = caveats(&scene, Method::Light(LightTracing { light_paths: None }));
    assert!(light.len() == 2 && light[0].contains("\"glaze\"") && light[1].contains("none"), "{light:?}");
    // What path finds by way of the mirror on the floor below it is found by accident; nothing is lit here but the lamp.
    scene.meshes.push(Mesh { material: 2, ..horizontal(4.0, -1.0, true) });
    scene.materials.push(grey(0.5));
    let bdpt = |light_tracing| Method::Bdpt(Bdpt { light_tracing });
    for (method, remedy) in [(Method::Path, "-i bdpt"), (bdpt(false), "add --light-tracing")] {
        let lines = caveats(&scene, method);
        assert!(lines.len() == 1 && lines[0].contains(remedy) && lines[0].contains("\"glaze\""), "{lines:?}");
    }
    assert_eq!(caveats(&scene, bdpt(true)), [""; 0]);
    scene.materials[0] = Material { roughness: 0.5, ..mirror };
    assert_eq!(caveats(&scene, Method::Path), [""; 0]);
}
