//! Samplers against their densities, at the ends of their range, and against the shaders.

use std::f32::consts::PI;

use glam::{DVec2, DVec3, Vec2, Vec3};
use halfway::math::frame::{Frame, safe_normalize};
use halfway::math::rng::uniform_from_word;
use halfway::math::{color, is_finite, sampling, scale};

use crate::gpu;
use crate::random::Stream;
use crate::stats::{FAMILY_ALPHA, direction_chi_square, grid_chi_square, sidak};

/// A coarse grid sees smooth faults of a density, a fine one local faults.
const GRIDS: [[usize; 2]; 2] = [[10, 21], [101, 202]];
const SAMPLES: u64 = 1_000_000;
/// Every chi-square test of this file: six samplers on two grids.
const TESTS: usize = 12;

fn assert_p(what: &str, grid: [usize; 2], p: f64) {
    assert!(p > sidak(FAMILY_ALPHA, TESTS), "{what} on {grid:?}: p = {p:e}");
}

fn check_directions(what: &str, sample: impl Fn(Vec2) -> Vec3, pdf_solid: impl Fn(Vec3) -> f32) {
    for grid in GRIDS {
        let mut stream = Stream::new(2);
        let draw = || Some(sample(stream.vec2()).as_dvec3());
        assert_p(
            what,
            grid,
            direction_chi_square(grid, SAMPLES, draw, |d| f64::from(pdf_solid(d.as_vec3()))),
        );
    }
}

#[test]
fn c02_cosine_hemisphere() {
    check_directions("cosine hemisphere", sampling::sample_cosine_hemisphere, |d| {
        sampling::cosine_hemisphere_pdf_solid(d.z)
    });
}

#[test]
fn c02_uniform_hemisphere() {
    // The density jumps at the horizon: the upper half alone is put on the grid.
    for grid in GRIDS {
        let mut stream = Stream::new(2);
        let draw = || {
            let d = sampling::sample_uniform_hemisphere(stream.vec2());
            Some([f64::from(d.z), f64::from(d.y.atan2(d.x) / (2.0 * PI)).rem_euclid(1.0)])
        };
        let density = |_| std::f64::consts::TAU * f64::from(sampling::uniform_hemisphere_pdf_solid());
        assert_p("uniform hemisphere", grid, grid_chi_square(grid, SAMPLES, draw, density));
    }
}

#[test]
fn c02_uniform_sphere() {
    check_directions("uniform sphere", sampling::sample_uniform_sphere, |_| {
        sampling::uniform_sphere_pdf_solid()
    });
}

#[test]
fn c02_uniform_cone() {
    let one_minus_cos = 0.01f32;
    for grid in GRIDS {
        let mut stream = Stream::new(2);
        let draw = || {
            let d = sampling::sample_uniform_cone(stream.vec2(), one_minus_cos);
            // sin^2 instead of 1 - z, which has few digits left.
            let sin_sq = f64::from(d.x).powi(2) + f64::from(d.y).powi(2);
            let height = (sin_sq / (1.0 + (1.0 - sin_sq).sqrt()) / f64::from(one_minus_cos)).min(1.0);
            Some([height, f64::from(d.y.atan2(d.x) / (2.0 * PI)).rem_euclid(1.0)])
        };
        let solid_angle = std::f64::consts::TAU * f64::from(one_minus_cos);
        let density = |_| solid_angle * f64::from(sampling::uniform_cone_pdf_solid(one_minus_cos));
        assert_p("cone", grid, grid_chi_square(grid, SAMPLES, draw, density));
    }
}

#[test]
fn c02_disk() {
    for grid in GRIDS {
        let mut stream = Stream::new(2);
        let draw = || {
            let d = sampling::sample_disk(stream.vec2()).as_dvec2();
            Some([d.length_squared(), (d.to_angle() / std::f64::consts::TAU).rem_euclid(1.0)])
        };
        assert_p("disk", grid, grid_chi_square(grid, SAMPLES, draw, |_| 1.0));
    }
}

#[test]
fn c02_triangle() {
    for grid in GRIDS {
        let mut stream = Stream::new(2);
        let draw = || {
            let b = sampling::sample_triangle(stream.vec2()).as_dvec3();
            // Equal areas: the square of the height above the base, and the share along it.
            Some([(1.0 - b.x).powi(2), (b.y / (b.y + b.z)).min(1.0)])
        };
        assert_p("triangle", grid, grid_chi_square(grid, SAMPLES, draw, |_| 1.0));
    }
}

/// Random words at the ends of their range, in every pair.
fn extreme_pairs() -> impl Iterator<Item = Vec2> {
    const WORDS: [u32; 9] =
        [0, 1, 0xff, 0x100, 0x7fff_ffff, 0x8000_0000, 0xffff_ff7f, 0xffff_ff80, 0xffff_ffff];
    WORDS.into_iter().flat_map(|a| WORDS.map(|b| Vec2::new(uniform_from_word(a), uniform_from_word(b))))
}

#[test]
fn n16_samplers_at_extremes() {
    let unit = |d: Vec3| assert!((d.length() - 1.0).abs() < 1e-6, "{d} is not a unit vector");
    for u in extreme_pairs() {
        let d = sampling::sample_cosine_hemisphere(u);
        unit(d);
        assert!(sampling::cosine_hemisphere_pdf_solid(d.z) > 0.0, "cosine hemisphere at {u}");
        let d = sampling::sample_uniform_hemisphere(u);
        unit(d);
        assert!(d.z > 0.0, "uniform hemisphere at {u}");
        unit(sampling::sample_uniform_sphere(u));
        for one_minus_cos in [1e-12, 1e-3, 1.0, 2.0] {
            unit(sampling::sample_uniform_cone(u, one_minus_cos));
            assert!(is_finite(sampling::uniform_cone_pdf_solid(one_minus_cos)));
        }
        assert!(sampling::sample_disk(u).length() <= 1.0 + 1e-7);
        let b = sampling::sample_triangle(u);
        assert!(b.min_element() >= 0.0 && (b.element_sum() - 1.0).abs() < 2e-7, "triangle at {u}: {b}");
    }
}

#[test]
fn narrow_cone_keeps_its_digits() {
    // A half angle of 1e-6: 1 - cos = 5e-13 vanishes beside 1 in f32.
    let d = sampling::sample_uniform_cone(Vec2::new(0.999_999_94, 0.3), 5e-13);
    assert!((f64::from(d.truncate().length()) / 1e-6 - 1.0).abs() < 1e-5);
}

#[test]
fn frame_is_orthonormal() {
    let mut stream = Stream::new(3);
    let mut normals: Vec<Vec3> =
        (0..10_000).map(|_| sampling::sample_uniform_sphere(stream.vec2())).collect();
    normals.extend([Vec3::Z, -Vec3::Z, Vec3::X, -Vec3::Y, Vec3::new(1.0, 0.0, -0.0)]);
    normals.extend([Vec3::new(1e-4, 0.0, -1.0).normalize(), Vec3::new(1e-10, 1e-10, -1.0)]);
    for normal in normals {
        let frame = Frame::from_normal(normal);
        let [t, b, n] = [frame.tangent, frame.bitangent, frame.normal].map(Vec3::as_dvec3);
        for product in [t.dot(b), b.dot(n), n.dot(t), t.length() - 1.0, b.length() - 1.0] {
            assert!(product.abs() < 1e-6, "{normal}: {product:e}");
        }
        assert!((t.cross(b) - n).length() < 1e-6, "{normal}: left-handed");
        let v = sampling::sample_uniform_sphere(stream.vec2());
        assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-6);
        assert!((frame.to_local(normal) - Vec3::Z).length() < 1e-6);
    }
}

/// Vectors of every size that f32 has.
fn vectors_of_all_sizes() -> Vec<Vec3> {
    let mut stream = Stream::new(4);
    let mut vectors = vec![Vec3::ZERO, Vec3::splat(3e38), Vec3::new(f32::MAX, 1.0, 0.0), Vec3::splat(1e-30)];
    for exponent in -125..128 {
        let size = scale::scale_by_power_of_two(1.0, exponent) as f32;
        vectors.extend((0..16).map(|_| size * sampling::sample_uniform_sphere(stream.vec2())));
    }
    vectors
}

#[test]
fn safe_normalize_at_every_size() {
    for v in vectors_of_all_sizes() {
        let expected = v.as_dvec3().normalize_or_zero();
        let error = (safe_normalize(v).as_dvec3() - expected).length();
        assert!(error < 2e-7, "{v:?}: off by {error:e}");
    }
    assert_eq!(safe_normalize(Vec3::splat(f32::from_bits(1))), Vec3::ZERO);
    assert!(!is_finite(safe_normalize(Vec3::new(f32::NAN, 0.0, 1.0)).x));
    assert!(!is_finite(safe_normalize(Vec3::new(f32::INFINITY, 0.0, 1.0)).x));
}

#[test]
fn power_of_two_scaling_is_exact() {
    for magnitude in [1.0, 0.5, 0.999, 3.7e-310, 5e-324, 1e-30, 1e30, f64::MAX, f64::MIN_POSITIVE] {
        let k = scale::normalising_exponent(magnitude).unwrap();
        let scaled = scale::scale_by_power_of_two(magnitude, k);
        assert!((0.5..1.0).contains(&scaled), "{magnitude:e} became {scaled}");
        assert_eq!(scale::scale_by_power_of_two(scaled, -k), magnitude);
    }
    for nothing in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(scale::normalising_exponent(nothing), None);
    }
}

#[test]
fn area_and_solid_angle_densities_invert() {
    let (pdf_solid, cos, distance_sq) = (0.3, -0.2, 7.0);
    let pdf_area = sampling::pdf_area_from_solid(pdf_solid, cos, distance_sq);
    assert!((pdf_area - 0.3 * 0.2 / 7.0).abs() < 1e-8);
    assert!((sampling::pdf_solid_from_area(pdf_area, cos, distance_sq) - pdf_solid).abs() < 1e-7);
}

fn uniform_inputs(count: u32) -> Vec<[u32; 2]> {
    let mut stream = Stream::new(5);
    (0..count).map(|_| stream.vec2().to_array().map(f32::to_bits)).collect()
}

fn vec3_of(bits: &[u32]) -> Vec3 {
    Vec3::from_slice(&[0, 1, 2].map(|i| f32::from_bits(bits[i])))
}

/// Tolerance 1e-5 where a sine is involved (lavapipe is good to 1e-7, WGSL promises 5e-4 only), 2e-7 elsewhere.
#[test]
fn c15_sampling_twins() {
    let mut inputs = uniform_inputs(100_000);
    inputs.extend(extreme_pairs().map(|u| u.to_array().map(f32::to_bits)));
    let outputs: Vec<[u32; 20]> = gpu::map(
        &["lib/sampling"],
        "fn twin(x: array<u32, 2>) -> array<u32, 20> {
            let u = vec2f(bitcast<f32>(x[0]), bitcast<f32>(x[1]));
            let a = bitcast<vec3u>(sample_cosine_hemisphere(u));
            let b = bitcast<vec3u>(sample_uniform_hemisphere(u));
            let c = bitcast<vec3u>(sample_uniform_sphere(u));
            let d = bitcast<vec3u>(sample_uniform_cone(u, 0.01));
            let e = bitcast<vec3u>(vec3f(sample_disk(u), cosine_hemisphere_pdf_solid(u.x)));
            let f = bitcast<vec3u>(sample_triangle(u));
            let g = bitcast<vec2u>(disk_to_square(sample_disk(u)));
            return array<u32, 20>(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z,
                                  d.x, d.y, d.z, e.x, e.y, e.z, f.x, f.y, f.z, g.x, g.y);
        }",
        &inputs,
    );
    for (bits, out) in inputs.into_iter().zip(outputs) {
        let u = Vec2::from_array(bits.map(f32::from_bits));
        let expected = [
            sampling::sample_cosine_hemisphere(u),
            sampling::sample_uniform_hemisphere(u),
            sampling::sample_uniform_sphere(u),
            sampling::sample_uniform_cone(u, 0.01),
            sampling::sample_disk(u).extend(sampling::cosine_hemisphere_pdf_solid(u.x)),
            sampling::sample_triangle(u),
        ];
        for (sampler, expected) in expected.into_iter().enumerate() {
            let found = vec3_of(&out[3 * sampler..]);
            let tolerance = if sampler == 5 { 2e-7 } else { 1e-5 };
            assert!(
                (found - expected).abs().max_element() <= tolerance,
                "sampler {sampler} at {u}: {found} instead of {expected}"
            );
        }
        // Back to the square: of the host's disk by the host, of the shader's by the shader.
        let back = Vec2::new(f32::from_bits(out[18]), f32::from_bits(out[19]));
        for (back, tolerance) in [(sampling::disk_to_square(sampling::sample_disk(u)), 1e-6), (back, 1e-5)] {
            assert!((back - u).abs().max_element() <= tolerance, "{u} comes back as {back}");
        }
        let z = f32::from_bits(out[2]);
        assert!(z > 0.0, "the shader's cosine hemisphere touches the horizon at {u}");
    }
}

#[test]
fn c15_sampling_constant_twins() {
    let inputs: Vec<[u32; 2]> = vec![[0.3f32.to_bits(), 0.02f32.to_bits()]];
    let outputs: Vec<[u32; 6]> = gpu::map(
        &["lib/sampling", "lib/color"],
        "fn twin(x: array<u32, 2>) -> array<u32, 6> {
            let pdf = bitcast<f32>(x[0]);
            let y = bitcast<f32>(x[1]);
            return array<u32, 6>(
                bitcast<u32>(uniform_hemisphere_pdf_solid()), bitcast<u32>(uniform_sphere_pdf_solid()),
                bitcast<u32>(uniform_cone_pdf_solid(y)), bitcast<u32>(pdf_area_from_solid(pdf, -y, 7.0)),
                bitcast<u32>(pdf_solid_from_area(pdf, -y, 7.0)),
                bitcast<u32>(luminance(vec3f(pdf, y, 0.5)) * max_component(vec3f(pdf, y, 0.5))));
        }",
        &inputs,
    );
    let expected = [
        sampling::uniform_hemisphere_pdf_solid(),
        sampling::uniform_sphere_pdf_solid(),
        sampling::uniform_cone_pdf_solid(0.02),
        sampling::pdf_area_from_solid(0.3, -0.02, 7.0),
        sampling::pdf_solid_from_area(0.3, -0.02, 7.0),
        color::luminance(Vec3::new(0.3, 0.02, 0.5)) * 0.5,
    ];
    for (found, expected) in outputs[0].map(f32::from_bits).into_iter().zip(expected) {
        assert!((found - expected).abs() <= 4e-7 * expected, "{found} instead of {expected}");
    }
}

#[test]
fn c15_frame_twins() {
    let mut stream = Stream::new(6);
    let inputs: Vec<[u32; 6]> = (0..100_000)
        .map(|_| {
            let [n, v] =
                [0; 2].map(|_| sampling::sample_uniform_sphere(stream.vec2()).to_array().map(f32::to_bits));
            [n[0], n[1], n[2], v[0], v[1], v[2]]
        })
        .collect();
    let outputs: Vec<[u32; 12]> = gpu::map(
        &["lib/frame"],
        "fn twin(x: array<u32, 6>) -> array<u32, 12> {
            let frame = frame_from_normal(bitcast<vec3f>(vec3u(x[0], x[1], x[2])));
            let v = bitcast<vec3f>(vec3u(x[3], x[4], x[5]));
            let t = bitcast<vec3u>(frame.tangent);
            let b = bitcast<vec3u>(frame.bitangent);
            let l = bitcast<vec3u>(to_local(frame, v));
            let w = bitcast<vec3u>(to_world(frame, v));
            return array<u32, 12>(t.x, t.y, t.z, b.x, b.y, b.z, l.x, l.y, l.z, w.x, w.y, w.z);
        }",
        &inputs,
    );
    for (bits, out) in inputs.iter().zip(outputs) {
        let (n, v) = (vec3_of(&bits[..3]), vec3_of(&bits[3..]));
        let frame = Frame::from_normal(n);
        let expected = [frame.tangent, frame.bitangent, frame.to_local(v), frame.to_world(v)];
        for (i, expected) in expected.into_iter().enumerate() {
            let found = vec3_of(&out[3 * i..]);
            assert!((found - expected).abs().max_element() <= 1e-6, "{n}: {found} instead of {expected}");
        }
    }
}

#[test]
fn c15_safe_normalize_twin() {
    let vectors = vectors_of_all_sizes();
    let inputs: Vec<[u32; 3]> = vectors.iter().map(|v| v.to_array().map(f32::to_bits)).collect();
    let outputs: Vec<[u32; 4]> = gpu::map(
        &["lib/math"],
        "fn twin(x: array<u32, 3>) -> array<u32, 4> {
            let n = bitcast<vec3u>(safe_normalize(bitcast<vec3f>(vec3u(x[0], x[1], x[2]))));
            return array<u32, 4>(n.x, n.y, n.z, 0u);
        }",
        &inputs,
    );
    for (v, out) in vectors.into_iter().zip(outputs) {
        let error = (vec3_of(&out) - safe_normalize(v)).length();
        assert!(error < 5e-7, "{v:?}: off by {error:e}");
    }
}

#[test]
fn n03_is_finite_twin() {
    let values =
        [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -3e38, 0.0, 1e-40, f32::MAX, 1.0];
    let inputs: Vec<[u32; 1]> = values.iter().map(|x| [x.to_bits()]).collect();
    let outputs: Vec<[u32; 2]> = gpu::map(
        &["lib/math"],
        "fn twin(x: array<u32, 1>) -> array<u32, 2> {
            let value = bitcast<f32>(x[0]);
            return array<u32, 2>(u32(is_finite(value)), u32(is_finite3(vec3f(0.0, value, 1.0))));
        }",
        &inputs,
    );
    for (value, out) in values.into_iter().zip(outputs) {
        assert_eq!(out, [u32::from(value.is_finite()); 2], "{value}");
        assert_eq!(is_finite(value), value.is_finite());
    }
}

/// The mean of cos over cosine-weighted directions is 2/3, of position over the disk 0: moments that a grid cannot
/// mistake.
#[test]
fn sampler_moments() {
    let mut stream = Stream::new(7);
    let n = 1_000_000;
    let (mut cosine, mut disk, mut sphere) = (0.0, DVec2::ZERO, DVec3::ZERO);
    for _ in 0..n {
        cosine += f64::from(sampling::sample_cosine_hemisphere(stream.vec2()).z);
        disk += sampling::sample_disk(stream.vec2()).as_dvec2();
        sphere += sampling::sample_uniform_sphere(stream.vec2()).as_dvec3();
    }
    let n = f64::from(n);
    assert!((cosine / n - 2.0 / 3.0).abs() < 5.0 * (1.0f64 / 18.0 / n).sqrt());
    assert!((disk / n).abs().max_element() < 5.0 * (0.25 / n).sqrt());
    assert!((sphere / n).abs().max_element() < 5.0 * (1.0 / 3.0 / n).sqrt());
}
