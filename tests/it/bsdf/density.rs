//! C-02: samples against the twin's density, by chi-square.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3, Vec4};

use super::{Config, Factors, Sample, coloured_materials, direction, sample};
use crate::gpu;
use crate::random::Stream;
use crate::stats::{FAMILY_ALPHA, direction_chi_square, grid_chi_square, sidak};

/// A coarse grid sees smooth faults of a density, a fine one local faults. Rows end where densities jump: at the
/// horizon, and where glass of index 1.5 runs out of facets (z = -0.2, -0.6, 0.9 for the angles below).
const GRIDS: [[usize; 2]; 2] = [[10, 21], [100, 202]];
const SAMPLES: usize = 1_000_000;

fn random_us(seed: u64) -> Vec<Vec3> {
    let mut stream = Stream::new(seed);
    (0..SAMPLES).map(|_| Vec3::new(stream.f32(), stream.f32(), stream.f32())).collect()
}

fn drawn(sample: &Sample) -> Option<DVec3> {
    (sample.pdf_solid > 0.0).then(|| sample.w.as_dvec3())
}

#[test]
fn c02_bsdf_samples() {
    const WIDE: [&str; 7] =
        ["lambert", "dielectric", "rough metal", "half pane", "glass", "rough glass", "half glass"];
    let wide: Vec<(&str, Factors)> =
        coloured_materials().into_iter().filter(|(name, _)| WIDE.contains(name)).collect();
    assert_eq!(wide.len(), WIDE.len());
    let us = random_us(20);
    let angles = [0.9, 0.3, -0.6];
    let level = sidak(FAMILY_ALPHA, wide.len() * angles.len() * GRIDS.len());
    for (name, material) in &wide {
        for cos in angles {
            let config = Config::new(material, direction(cos, 1.0), true);
            let samples = sample(&[config], &us);
            let (twin, from) = (config.twin(), config.w_from.as_dvec3());
            for grid in GRIDS {
                let mut next = samples.iter();
                let draw = || next.next().and_then(drawn);
                let p = direction_chi_square(grid, SAMPLES as u64, draw, |w| twin.pdf(from, w));
                assert!(p > level, "{name} from cosine {cos} on {grid:?}: p = {p:e}");
            }
        }
    }
}

#[test]
fn c02_visible_normals() {
    // On a square where the density is smooth at every alpha: GGX normals themselves are uniform in
    // tan^2 / (alpha^2 + tan^2) and the azimuth; the square root takes the pole at the horizon away.
    let cases: Vec<(f32, f32)> = [1e-3f32, 1e-2, 0.1, 1.0]
        .into_iter()
        .flat_map(|alpha| [0.95, 0.4, 0.05].map(|z| (alpha, z)))
        .collect();
    let kernel = "
#import lib/ggx
@group(0) @binding(0) var<storage, read> us: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> normals: array<vec4f>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&us) { return; }
    let w = us[0].xyz;
    normals[id.x] = vec4f(ggx_sample_visible_normal(w, us[0].w, us[id.x].xy), 0.0);
}";
    let level = sidak(FAMILY_ALPHA, cases.len() * GRIDS.len());
    for (alpha, z) in cases {
        let w = direction(z.into(), -2.0);
        // The first entry is the case itself.
        let us: Vec<Vec4> =
            [w.extend(alpha)].into_iter().chain(random_us(21).into_iter().map(|u| u.extend(0.0))).collect();
        let output = gpu::run(
            kernel,
            &[],
            &[("us", bytemuck::cast_slice(&us))],
            &[("normals", us.len() * 16)],
            us.len() as u32,
        );
        let normals: Vec<Vec4> = bytemuck::pod_collect_to_vec(&output[0]);
        let (w, alpha_sq) = (w.as_dvec3(), f64::from(alpha).powi(2));
        let lambda = 0.5 * ((1.0 + alpha_sq * (1.0 - w.z * w.z) / (w.z * w.z)).sqrt() - 1.0);
        // G1 max(w.h, 0) D / w.z over the density D cos of the square, times that of its root.
        let density = |[x, y]: [f64; 2]| {
            let left = (1.0 - x) * (1.0 - x);
            let tan = (alpha_sq * (1.0 - left) / left).sqrt();
            let (sin, cos) = (TAU * y).sin_cos();
            let slope = w.x * tan * cos + w.y * tan * sin + w.z;
            2.0 * (1.0 - x) * slope.max(0.0) / (w.z * (1.0 + lambda))
        };
        for grid in GRIDS {
            let mut next = normals[1..].iter().map(|h| h.truncate().as_dvec3());
            let draw = || {
                let h = next.next()?;
                let tan_sq = (h.x * h.x + h.y * h.y) / (h.z * h.z);
                let left = alpha_sq / (alpha_sq + tan_sq);
                Some([1.0 - left.sqrt(), (h.y.atan2(h.x) / TAU).rem_euclid(1.0)])
            };
            let p = grid_chi_square(grid, SAMPLES as u64, draw, density);
            assert!(p > level, "alpha {alpha} from cosine {z} on {grid:?}: p = {p:e}");
        }
    }
}
