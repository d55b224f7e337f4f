//! The BSDF's numbers: at the extremes, against the twin, and through the world-space wrapper.

use glam::{DVec3, Vec3};
use halfway::device::Feature;
use halfway::device::shader::stitch_text;

use super::{
    ALL_FEATURES, Config, DIELECTRIC, Factors, HEADER, coloured_materials, direction, evaluate, of_surfaces,
    sample, white_materials,
};
use crate::bsdf_f64::{Bsdf, albedo_table, fresnel};
use crate::gpu;
use crate::random::Stream;

fn random_us(seed: u64, count: usize) -> Vec<Vec3> {
    let mut stream = Stream::new(seed);
    (0..count).map(|_| Vec3::new(stream.f32(), stream.f32(), stream.f32())).collect()
}

fn random_direction(stream: &mut Stream) -> Vec3 {
    direction(2.0 * stream.f64() - 1.0, std::f64::consts::TAU * stream.f64())
}

/// The value that all but a share of `values` stay below.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

#[test]
fn n09_grazing() {
    let materials = coloured_materials();
    let cosines = (1..=7).flat_map(|k| [0.1f64.powi(k), -0.1f64.powi(k)]);
    let mut us = random_us(9, 2000);
    us.extend(
        [0.0, 0.5, 0.999_999_94].into_iter().flat_map(|a| [0.0, 0.999_999_94].map(|b| Vec3::new(a, b, b))),
    );
    let configs: Vec<Config> = cosines
        .flat_map(|cos| materials.iter().map(move |(_, m)| Config::new(m, direction(cos, 2.0), cos > 0.0)))
        .collect();
    let samples = sample(&configs, &us);
    let mut queries = Vec::new();
    for (config, samples) in configs.iter().zip(samples.chunks_exact(us.len())) {
        for s in samples {
            assert!(s.w.is_finite() && s.weight.is_finite() && s.pdf_solid.is_finite(), "{config:?} {s:?}");
            assert!(s.weight.min_element() >= 0.0 && s.pdf_solid >= 0.0, "{config:?} {s:?}");
            if s.pdf_solid > 0.0 {
                assert!((s.w.length() - 1.0).abs() < 1e-6 && s.w.z.abs() >= 1e-7, "{config:?} {s:?}");
                queries.push((*config, s.w, s.pdf_solid));
            }
        }
        let drawn = samples.iter().filter(|s| s.pdf_solid > 0.0).count();
        assert!(drawn > 0 || config.w_from.z.abs() < 1e-7, "{config:?}: everything absorbed");
    }
    let values = evaluate(&queries.iter().map(|(config, w, _)| (*config, *w)).collect::<Vec<_>>());
    for ((config, w, pdf), (f, again)) in queries.into_iter().zip(values) {
        assert!(f.is_finite() && f.min_element() >= 0.0, "{config:?} to {w}: {f}");
        assert!((again - pdf).abs() <= 1e-3 * pdf, "{config:?} to {w}: density {again}, sampled with {pdf}");
    }
}

#[test]
fn n12_ggx() {
    let mut stream = Stream::new(12);
    let mut inputs = Vec::new();
    for alpha in [1.0f32, 0.1, 1e-2, 1e-3, 1e-4] {
        for _ in 0..4000 {
            let u = stream.f64();
            let tan_sq = f64::from(alpha).powi(2) * u / (1.0 - u);
            let h = direction(1.0 / (1.0 + tan_sq).sqrt(), 6.0 * stream.f64());
            inputs.push([h.x, h.y, h.z, alpha].map(f32::to_bits));
        }
    }
    let body = "fn twin(x: array<u32, 4>) -> array<u32, 1> {
        let h = vec3f(bitcast<f32>(x[0]), bitcast<f32>(x[1]), bitcast<f32>(x[2]));
        return array(bitcast<u32>(ggx_normals(h, bitcast<f32>(x[3]))));
    }";
    let outputs: Vec<[u32; 1]> = gpu::map(&["lib/ggx"], body, &inputs);
    for (input, [d]) in inputs.into_iter().zip(outputs) {
        let [x, y, z, alpha] = input.map(|bits| f64::from(f32::from_bits(bits)));
        let (d, h) = (f64::from(f32::from_bits(d)), DVec3::new(x, y, z).normalize());
        let width = alpha * alpha * h.z * h.z + h.x * h.x + h.y * h.y;
        let exact = alpha * alpha / (std::f64::consts::PI * width * width);
        assert!((d - exact).abs() <= 2e-6 * exact, "alpha {alpha}, h {h}: {d}, exactly {exact}");
    }
}

#[test]
fn n12_sampled_density() {
    // The density that a sample reports against the twin's at the very direction.
    let us = random_us(13, 4000);
    let narrow = white_materials().into_iter().filter(|(name, _)| !name.contains("faint"));
    for (name, material) in narrow {
        // Where cosine and alpha are both tiny, the last bits of two f32 directions that nearly cancel are a visible
        // share of a lobe.
        let angles = [(0.9, 5e-3), (0.2, 5e-3), (0.05, 5e-3), (1e-3, 0.1), (-0.5, 5e-3)];
        let configs = angles.map(|(cos, _)| Config::new(&material, direction(cos, 4.0), true));
        let samples = sample(&configs, &us);
        let samples = samples.chunks_exact(us.len());
        for ((config, samples), (_, tolerance)) in configs.iter().zip(samples).zip(angles) {
            let (twin, from) = (config.twin(), config.w_from.as_dvec3().normalize());
            let errors: Vec<f64> = samples
                .iter()
                .filter(|s| s.pdf_solid > 0.0)
                .map(|s| (f64::from(s.pdf_solid) / twin.pdf(from, s.w.as_dvec3().normalize()) - 1.0).abs())
                .collect();
            assert!(errors.len() > 100 && errors.iter().all(|e| e.is_finite()), "{name} {config:?}");
            let p99 = quantile(errors, 0.99);
            assert!(p99 <= tolerance, "{name} from {from}: p99 {p99:e}");
        }
    }
}

#[test]
fn n13_fresnel_and_refraction() {
    let etas = [1.0f32, 1.0 + 1e-7, 1.000_1, 1.02, 1.5, 2.4, 1.0 / 1.02, 1.0 / 1.5, 1.0 / 2.4];
    let cosines = (0..=1000).map(|i| i as f32 / 1000.0).chain([1e-7, 1e-6, 1e-5, 1e-4]);
    let inputs: Vec<[u32; 2]> = cosines.flat_map(|c| etas.map(|eta| [c.to_bits(), eta.to_bits()])).collect();
    let body = "fn twin(x: array<u32, 2>) -> array<u32, 4> {
        let c = bitcast<f32>(x[0]);
        let eta = bitcast<f32>(x[1]);
        let w = vec3f(sqrt((1.0 - c) * (1.0 + c)), 0.0, c);
        let t = refracted(w, vec3f(0.0, 0.0, 1.0), eta);
        return array(bitcast<u32>(fresnel_dielectric(c, eta)), bitcast<u32>(t.x), bitcast<u32>(t.y), bitcast<u32>(t.z));
    }";
    let body = format!("fn ggx_albedo_texel(i: u32) -> vec2f {{ return vec2f(0.0); }}\n{body}");
    let outputs: Vec<[u32; 4]> = gpu::map(&["lib/dielectric"], &body, &inputs);
    let mut total_reflection = 0;
    for (input, output) in inputs.into_iter().zip(outputs) {
        let [c, eta] = input.map(|bits| f64::from(f32::from_bits(bits)));
        let [r, x, y, z] = output.map(|bits| f64::from(f32::from_bits(bits)));
        let what = format!("cosine {c}, eta {eta}: {r}, ({x}, {y}, {z})");
        assert!(r.is_finite() && (0.0..=1.0).contains(&r), "{what}");
        let sin_sq = (1.0 - c * c) / (eta * eta);
        // Where the f32 radicand decides which side of the critical angle it is, either answer is right.
        let critical = ((eta - 1.0) * (eta + 1.0) + c * c).abs() < 1e-6;
        if sin_sq > 1.0 && !critical {
            total_reflection += 1;
            assert!(r == 1.0 && (x, y, z) == (0.0, 0.0, 0.0), "{what}");
        } else if !critical {
            assert!((r - fresnel(c, 1.0, eta)).abs() <= 1e-5, "{what}, {}", fresnel(c, 1.0, eta));
            assert!(
                (x + sin_sq.sqrt()).abs() < 1e-6 && (z + (1.0 - sin_sq).max(0.0).sqrt()).abs() < 2e-4,
                "{what}"
            );
            assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5, "{what}");
        }
        if eta == 1.0 && c > 0.0 {
            assert!(r == 0.0 && z == -c, "index-matched is passed through: {what}");
        }
    }
    assert!(total_reflection > 1000);
}

#[test]
fn n13_smooth_glass() {
    let glass = Factors { transmission: 1.0, volume: true, delta: true, roughness: 0.0, ..DIELECTRIC };
    let coloured = DVec3::new(0.9, 0.5, 0.1);
    let mirror = Factors { metallic: 1.0, base_color: coloured, transmission: 0.0, volume: false, ..glass };
    let pane = Factors { volume: false, ..glass };
    let materials =
        [glass, Factors { ior: 1.0, ..glass }, Factors { ior: 1.0 + 1e-7, ..glass }, mirror, pane];
    let cosines = [1.0, 0.9, 0.75, 0.7, 0.3, 1e-3, 1e-6, -1e-6, -1e-3, -0.3, -0.7, -0.75, -1.0];
    for material in materials {
        for from_eye in [true, false] {
            let configs = cosines.map(|cos| Config::new(&material, direction(cos, 1.0), from_eye));
            let us = [Vec3::splat(1e-4), Vec3::splat(0.999_999_94)];
            for (config, samples) in configs.iter().zip(sample(&configs, &us).chunks_exact(2)) {
                let (twin, from) = (config.twin(), config.w_from.as_dvec3());
                let expected = us.map(|u| twin.sample(from, u.as_dvec3().to_array(), from_eye));
                let probability: f32 = if samples[0].event == samples[1].event {
                    samples[0].pdf_solid
                } else {
                    samples.iter().map(|s| s.pdf_solid).sum()
                };
                assert!((probability - 1.0).abs() <= 1e-6, "{config:?}: probabilities {probability}");
                for (s, e) in samples.iter().zip(expected) {
                    let e = e.expect("the twin scatters");
                    let what = format!("{config:?}\n{s:?}\n{e:?}");
                    assert!(s.event & 1 == 1 && (s.event & 2 == 2) == (e.w.z * from.z < 0.0), "{what}");
                    assert!((s.w.as_dvec3() - e.w).length() < 1e-3, "{what}");
                    assert!((s.weight.as_dvec3() - e.weight).abs().max_element() < 1e-4, "{what}");
                    assert!((f64::from(s.pdf_solid) - e.pdf).abs() < 1e-4, "{what}");
                }
            }
        }
    }
}

#[test]
fn c15_eval_and_density() {
    let mut stream = Stream::new(15);
    let materials = coloured_materials();
    let queries: Vec<(Config, Vec3)> = (0..100_000)
        .map(|i| {
            let (_, material) = materials[i % materials.len()];
            let from = random_direction(&mut stream);
            (Config::new(&material, from, true), random_direction(&mut stream))
        })
        .collect();
    let mut errors = vec![Vec::new(); 2];
    let mut positive = 0;
    for ((config, to), (f, pdf)) in queries.iter().zip(evaluate(&queries)) {
        let twin = config.twin();
        let (from, to) = (config.w_from.as_dvec3().normalize(), to.as_dvec3().normalize());
        let (exact, exact_pdf) = (twin.eval(from, to), twin.pdf(from, to));
        let error = |value: f64, exact: f64| {
            if value == exact { 0.0 } else { (value - exact).abs() / value.max(exact) }
        };
        errors[0].push(error(f.as_dvec3().max_element(), exact.max_element()));
        errors[1].push(error(pdf.into(), exact_pdf));
        positive += usize::from(exact_pdf > 0.0);
    }
    assert!(positive > 50_000, "{positive}");
    for (what, errors) in ["f", "density"].into_iter().zip(errors) {
        let [p99, p999, worst] = [0.99, 0.999, 1.0].map(|share| quantile(errors.clone(), share));
        println!("{what}: p99 {p99:.1e}, p99.9 {p999:.1e}, largest {worst:.1e}");
        assert!(p99 < 2e-5 && p999 < 2e-4, "{what}: {p99:e} {p999:e}");
    }
}

#[test]
fn c15_albedo() {
    let mut configs = Vec::new();
    for (_, m) in coloured_materials() {
        configs.push(Config::new(&m, Vec3::Z, true));
    }
    let albedos: Vec<[f32; 4]> =
        of_surfaces(&configs, "alias Found = vec4f;", "found[id.x] = vec4f(bsdf_albedo(s), 0.0);");
    for (config, [r, g, b, _]) in configs.iter().zip(albedos) {
        let albedo = DVec3::new(r.into(), g.into(), b.into());
        assert!((albedo - config.twin().albedo()).abs().max_element() < 1e-6, "{config:?}: {albedo}");
        assert!(albedo.min_element() >= 0.0 && albedo.max_element() <= 1.0, "{config:?}: {albedo}");
    }
}

#[test]
fn s03_every_combination_of_features_is_valid() {
    let users = "
#import lib/shading
#if !lambert_only
#import bind/ggx_albedo
#endif
@group(0) @binding(0) var<storage, read_write> out: array<vec4f>;
@compute @workgroup_size(1)
fn main() {
    let s = surface_lambert(vec3f(0.5));
    let frame = shading_frame(vec3f(0.0, 0.0, 1.0), vec3f(0.0, 0.0, 1.0));
    let sample = shading_sample_direction(s, frame, out[0].xyz, out[1].xyz, true);
    let value = shading_evaluate(s, frame, sample.w, out[2].xyz, true);
    out[0] = vec4f(value.f, value.pdf_solid);
    out[1] = vec4f(bsdf_albedo(s), 1.0);
}";
    for features in [&[Feature::LambertOnly][..], &[], &[Feature::Transmission], &ALL_FEATURES] {
        let stitched = stitch_text("user", users, features.iter().copied().collect()).expect("directives");
        stitched.validate().unwrap_or_else(|error| panic!("{features:?}: {error}"));
    }
}

#[test]
fn s01_lambert_only_is_the_same_lambert() {
    let us: Vec<_> = random_us(1, 1000).into_iter().map(|u| u.extend(0.0)).collect();
    let kernel = format!(
        "{HEADER}
        @group(0) @binding(1) var<storage, read> us: array<vec4f>;
        @group(0) @binding(2) var<storage, read_write> samples: array<BsdfSample>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            if id.x >= arrayLength(&us) {{ return; }}
            let s = surface_lambert(vec3f(0.9, 0.5, 0.1));
            samples[id.x] = bsdf_sample(s, vec3f(0.6, 0.0, -0.8), us[id.x].xyz, true);
        }}"
    );
    let run = |features: &[Feature], table: &[(&str, &[u8])]| {
        let inputs: Vec<_> =
            [("us", bytemuck::cast_slice(&us))].into_iter().chain(table.iter().copied()).collect();
        let output = gpu::run(&kernel, features, &inputs, &[("samples", us.len() * 32)], us.len() as u32);
        bytemuck::pod_collect_to_vec::<u8, [f32; 8]>(&output[0])
    };
    let only = run(&[Feature::LambertOnly], &[]);
    let general = run(&ALL_FEATURES, &[("albedo_table", bytemuck::cast_slice(&albedo_table().texels))]);
    for (a, b) in only.into_iter().zip(general) {
        for (a, b) in a.into_iter().zip(b) {
            assert!((a - b).abs() <= 1e-5, "{a} and {b}");
        }
    }
}

#[test]
fn the_twin_is_sane_where_it_judges() {
    // Delta lobes have no density; opposite sides of an opaque surface exchange nothing.
    let mirror = Bsdf::new(&Factors { metallic: 1.0, delta: true, ..DIELECTRIC });
    assert_eq!(mirror.pdf(DVec3::Z, DVec3::Z), 0.0);
    assert_eq!(Bsdf::new(&DIELECTRIC).eval(DVec3::Z, -DVec3::Z), DVec3::ZERO);
    assert!(mirror.delta);
}
