//! White furnaces, the albedo table, reciprocity.

use glam::{DVec3, Vec3};
use halfway::math::ggx_albedo::MARGIN;

use super::{
    Config, DIELECTRIC, Factors, coloured_materials, direction, evaluate, even_points, sample, twin_albedo,
    white_materials,
};
use crate::bsdf_f64::{Bsdf, albedo_table};
use crate::random::Stream;

/// Cosines of the furnace's five angles.
const COSINES: [f64; 5] = [1.0, 0.8, 0.5, 0.2, 0.03];
const POINTS: usize = 1 << 15;

/// Mean weights on the device for every material, both sides and five angles; both transports where they differ.
fn device_albedos(materials: &[(&'static str, Factors)]) -> Vec<(&'static str, Config, bool, Vec3)> {
    let us: Vec<Vec3> = even_points(POINTS).into_iter().map(DVec3::as_vec3).collect();
    let mut albedos = Vec::new();
    for (name, material) in materials {
        let angles = COSINES.into_iter().chain(COSINES.map(|c| -c));
        let configs: Vec<(Config, bool)> = angles
            .flat_map(|cos| [true, false].map(|eye| (cos, eye)))
            .filter(|(cos, eye)| material.volume || (*cos > 0.0) == *eye)
            .map(|(cos, eye)| (Config::new(material, direction(cos, 0.7), eye), eye))
            .collect();
        let samples = sample(&configs.iter().map(|(config, _)| *config).collect::<Vec<_>>(), &us);
        for ((config, from_eye), samples) in configs.into_iter().zip(samples.chunks_exact(POINTS)) {
            assert!(samples.iter().all(|s| s.weight.is_finite() && s.pdf_solid.is_finite()), "{name}");
            let mean = samples.iter().map(|s| s.weight.as_dvec3()).sum::<DVec3>() / POINTS as f64;
            albedos.push((*name, config, from_eye, mean.as_vec3()));
        }
    }
    albedos
}

#[test]
fn c01_furnace_of_white_materials() {
    for (name, config, from_eye, albedo) in device_albedos(&white_materials()) {
        let what = format!("{name} at cosine {} from the eye {from_eye}: {albedo}", config.w_from.z);
        let expected = twin_albedo(&config.twin(), config.w_from.as_dvec3(), from_eye, POINTS).as_vec3();
        assert!(
            (albedo - expected).abs().max_element() <= 2e-3 * expected.max_element(),
            "{what}, {expected}"
        );
        // Radiance is squeezed by refraction; power never grows.
        if !from_eye {
            assert!(albedo.max_element() <= 1.001, "{what}");
        }
        match name {
            "lambert" => assert!((albedo - 1.0).abs().max_element() <= 1e-3, "{what}"),
            // Single scattering loses nothing at narrow lobes, and the diffuse layer returns what the interface of
            // an opaque dielectric lets through.
            "narrow metal" | "dielectric" | "polished dielectric" | "chalky dielectric" => {
                assert!((albedo - 1.0).abs().max_element() <= 0.01, "{what}");
            }
            _ => {}
        }
    }
}

#[test]
fn c01_furnace_of_coloured_materials() {
    for (name, config, from_eye, albedo) in device_albedos(&coloured_materials()) {
        let what = format!("{name} at cosine {} from the eye {from_eye}: {albedo}", config.w_from.z);
        let expected = twin_albedo(&config.twin(), config.w_from.as_dvec3(), from_eye, POINTS).as_vec3();
        assert!(
            (albedo - expected).abs().max_element() <= 2e-3 * expected.max_element(),
            "{what}, {expected}"
        );
    }
}

#[test]
fn c01_albedo_table() {
    // a + b is the albedo of a metal with f0 = 1, b that of one with f0 = 0.
    let (mut worst, mut worst_steep, mut below) = (0.0f64, 0.0f64, 0.0f64);
    for roughness in [0.032, 0.04, 0.1, 0.17, 0.3, 0.44, 0.6, 0.77, 0.9, 1.0] {
        for cos in [0.001, 0.003, 0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95, 1.0] {
            let metal = Factors { metallic: 1.0, roughness, ..DIELECTRIC };
            let w = direction(cos, 0.0).as_dvec3();
            let white = Bsdf::new(&metal);
            let black = Bsdf::new(&Factors { base_color: DVec3::ZERO, ..metal });
            let [full, b] = [white, black].map(|bsdf| twin_albedo(&bsdf, w, true, 1 << 15).x);
            let table = albedo_table().directional(cos, white.alpha());
            for (part, exact) in [full - b, b].into_iter().enumerate() {
                let error = table[part] - MARGIN * exact;
                worst = worst.max(error.abs());
                if cos >= 0.1 {
                    worst_steep = worst_steep.max(error.abs());
                }
                below = below.max(exact - table[part]);
            }
        }
    }
    println!("albedo table off by {worst:.1e}, {worst_steep:.1e} from cosine 0.1, low by {below:.1e}");
    assert!(worst < 1e-2 && worst_steep < 3e-3, "{worst}, {worst_steep}");
    // Too low is too much energy.
    assert!(below < 1e-3, "{below}");
}

#[test]
fn c03_reciprocity() {
    let mut stream = Stream::new(3);
    let mut pairs = Vec::new();
    for (name, material) in coloured_materials() {
        for _ in 0..10_000 {
            let [a, b] = [(); 2].map(|()| direction(2.0 * stream.f64() - 1.0, 6.0 * stream.f64()));
            pairs.push((name, material, a, b));
        }
    }
    let forward: Vec<_> = pairs.iter().map(|(_, m, a, b)| (Config::new(m, *a, true), *b)).collect();
    let backward: Vec<_> = pairs.iter().map(|(_, m, a, b)| (Config::new(m, *b, true), *a)).collect();
    let (forward, backward) = (evaluate(&forward), evaluate(&backward));
    for (((name, m, a, b), (f, _)), (g, _)) in pairs.into_iter().zip(forward).zip(backward) {
        // f / n^2 on the eye's side is symmetric.
        let n = |w: Vec3| if w.z > 0.0 || !m.volume { 1.0 } else { m.ior.max(1.02) as f32 };
        let (f, g) = (f / (n(a) * n(a)), g / (n(b) * n(b)));
        let same = (f - g).abs().cmple(1e-5 * f.max(g)).all();
        assert!(same, "{name}: f({a}, {b}) = {f}, but {g} the other way round");
    }
}
