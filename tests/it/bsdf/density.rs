//! C-02: samples against the twin's density, by chi-square.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::{Config, DIELECTRIC, Factors, Sample, coloured_materials, direction, sample};
use crate::random::Stream;
use crate::stats::{FAMILY_ALPHA, direction_chi_square, grid_chi_square, sidak};

/// A coarse grid sees smooth faults of a density, a fine one local faults. Even numbers of rows: densities jump at
/// the horizon.
const GRIDS: [[usize; 2]; 2] = [[10, 21], [102, 202]];
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
    // Lobes that the fine grid resolves.
    let wide: Vec<(&str, Factors)> =
        coloured_materials().into_iter().filter(|(_, m)| m.roughness >= 0.5 && m.ior > 1.0).collect();
    assert_eq!(wide.len(), 11);
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
fn c02_narrow_lobes() {
    // In the square of half vectors that GGX itself maps to: x = tan^2 / (alpha^2 + tan^2) and the azimuth.
    // There the density of visible normals is smooth at every alpha.
    let us = random_us(21);
    let cases: Vec<(f64, f64)> =
        [0.032, 0.1, 0.3].into_iter().flat_map(|r| [0.95, 0.4, 0.05].map(|cos| (r, cos))).collect();
    let level = sidak(FAMILY_ALPHA, cases.len() * GRIDS.len());
    for (roughness, cos) in cases {
        let metal = Factors { metallic: 1.0, roughness, ..DIELECTRIC };
        let config = Config::new(&metal, direction(cos, -2.0), false);
        let samples = sample(&[config], &us);
        let (twin, from) = (config.twin(), config.w_from.as_dvec3());
        let alpha_sq = twin.alpha() * twin.alpha();
        let to_square = |w: DVec3| {
            let h = (w + from).normalize();
            let tan_sq = (h.x * h.x + h.y * h.y) / (h.z * h.z);
            [tan_sq / (alpha_sq + tan_sq), (h.y.atan2(h.x) / TAU).rem_euclid(1.0)]
        };
        let density = |[x, y]: [f64; 2]| {
            let tan_sq = alpha_sq * x / (1.0 - x);
            let cos_h = 1.0 / (1.0 + tan_sq).sqrt();
            let (sin, cos) = (TAU * y).sin_cos();
            let h = DVec3::new(tan_sq.sqrt() * cos, tan_sq.sqrt() * sin, 1.0) * cos_h;
            let from_h = from.dot(h);
            let to = 2.0 * from_h * h - from;
            if to.z <= 0.0 || from_h <= 0.0 {
                return 0.0;
            }
            // dx dy = D cos dh, and dw = 4 |w.h| dh.
            twin.pdf(from, to) * 4.0 * from_h / (twin.distribution(h) * cos_h)
        };
        for grid in GRIDS {
            let mut next = samples.iter();
            let draw = || next.next().and_then(drawn).map(to_square);
            let p = grid_chi_square(grid, SAMPLES as u64, draw, density);
            assert!(p > level, "roughness {roughness} from cosine {cos} on {grid:?}: p = {p:e}");
        }
    }
}
