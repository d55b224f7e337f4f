//! Bent normals: they lose no light (C-01), are drawn with their density (C-02), and both directions of transport agree
//! (C-11). The geometric normal is z.

use glam::{DVec3, Vec3};
use halfway::device::Feature;
use halfway::math::frame::Frame;

use super::{ALL_FEATURES, CONFIG, Config, DIELECTRIC, Factors, HEADER, direction, even_points};
use super::{coloured_materials, numbers::quantile, twin_albedo};
use crate::bsdf_f64::albedo_table;
use crate::gpu;
use crate::normals_f64::Normals;
use crate::random::Stream;
use crate::stats::{FAMILY_ALPHA, direction_chi_square, sidak};

/// A material as it is met from a direction, under a normal that is not z.
#[derive(Clone, Copy, Debug)]
struct Bent {
    /// Its direction is that of the world.
    config: Config,
    normal: Vec3,
}

/// A drawn direction of the world.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Drawn {
    w: Vec3,
    /// Probability of a delta event; 0 where the path ends.
    chance: f32,
    /// f |cos| / density.
    weight: Vec3,
    pdf_solid: f32,
    f: Vec3,
    pdf_back_solid: f32,
}

impl Bent {
    fn new(factors: &Factors, normal: Vec3, from: Vec3, from_eye: bool) -> Self {
        Self { config: Config::new(factors, from, from_eye), normal }
    }

    fn normals(&self) -> Normals {
        Normals::new(self.normal.as_dvec3().normalize(), DVec3::Z)
    }

    /// A direction as the BSDF knows it, with the solid angle there for solid angle here.
    fn local(&self, world: Vec3) -> (DVec3, f64) {
        let moved = self.normals().to_shading(world.as_dvec3().normalize());
        let frame = Frame::from_normal(self.normal);
        let axes = [frame.tangent, frame.bitangent, frame.normal];
        (DVec3::from(axes.map(|axis| moved.world.dot(axis.as_dvec3()))), moved.jacobian)
    }

    /// Density of going on along `to`.
    fn pdf(&self, to: Vec3) -> f64 {
        let (to, jacobian) = self.local(to);
        self.config.twin().pdf(self.local(self.config.w_from).0, to) * jacobian
    }
}

/// Each with every u, which its own `us` come from; u's innermost.
fn draw(cases: &[Bent], us: &[Vec3]) -> Vec<Drawn> {
    let kernel = format!(
        "{HEADER}{CONFIG}
        struct Drawn {{ w: vec3f, chance: f32, weight: vec3f, pdf_solid: f32, f: vec3f, pdf_back_solid: f32 }}
        @group(0) @binding(1) var<storage, read> us: array<vec4f>;
        @group(0) @binding(2) var<storage, read> normals: array<vec4f>;
        @group(0) @binding(3) var<storage, read_write> results: array<Drawn>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let index = invocation(id);
            if index >= {}u {{ return; }}
            let config = configs[index / {count}u];
            let s = surface_from_factors(config.factors);
            let from_eye = config.from_eye == 1u;
            let frame = shading_frame(normals[index / {count}u].xyz, vec3f(0.0, 0.0, 1.0));
            let u = us[index % {count}u].xyz;
            let sample = shading_sample_direction(s, frame, config.w_from, u, from_eye);
            if sample.pdf_solid == 0.0 {{ return; }}
            if (s.flags & SURFACE_DELTA) != 0u {{
                results[index] = Drawn(sample.w, sample.pdf_solid, sample.weight, 0.0, vec3f(0.0), 0.0);
                return;
            }}
            let value = shading_evaluate(s, frame, config.w_from, sample.w, from_eye);
            let weight = select(vec3f(0.0), value.f * abs(sample.w.z) / value.pdf_solid, value.pdf_solid > 0.0);
            results[index] = Drawn(
                sample.w, sample.pdf_solid, weight, value.pdf_solid, value.f, value.pdf_back_solid);
        }}",
        cases.len() * us.len(),
        count = us.len(),
    );
    let configs: Vec<Config> = cases.iter().map(|case| case.config).collect();
    let normals: Vec<_> = cases.iter().map(|case| case.normal.extend(0.0)).collect();
    let us: Vec<_> = us.iter().map(|u| u.extend(0.0)).collect();
    let total = cases.len() * us.len();
    let output = gpu::run(
        &kernel,
        &[ALL_FEATURES.as_slice(), &[Feature::BentNormals, Feature::Bidirectional]].concat(),
        &[
            ("configs", bytemuck::cast_slice(&configs)),
            ("us", bytemuck::cast_slice(&us)),
            ("normals", bytemuck::cast_slice(&normals)),
            ("albedo_table", bytemuck::cast_slice(&albedo_table().texels)),
        ],
        &[("results", total * size_of::<Drawn>())],
        total as u32,
    );
    bytemuck::pod_collect_to_vec(&output[0])
}

/// A normal at that angle, in degrees.
fn tilted(degrees: f64, azimuth: f64) -> Vec3 {
    direction(degrees.to_radians().cos(), azimuth)
}

/// Kinds of surfaces, white.
fn white() -> [(&'static str, Factors); 6] {
    let metal = Factors { metallic: 1.0, ..DIELECTRIC };
    let glass = Factors { transmission: 1.0, volume: true, ..DIELECTRIC };
    [
        ("mirror", Factors { roughness: 0.0, delta: true, ..metal }),
        ("narrow metal", Factors { roughness: 0.05, ..metal }),
        ("metal", Factors { roughness: 0.3, ..metal }),
        ("lambert", Factors { specular: 0.0, ..DIELECTRIC }),
        ("dielectric", DIELECTRIC),
        ("glass", Factors { roughness: 0.3, ..glass }),
    ]
}

#[test]
fn the_map_of_directions_is_one_to_one() {
    let mut stream = Stream::new(66);
    for _ in 0..20_000 {
        let normals = Normals::new(tilted(90.0 * stream.f64(), 1.0).as_dvec3().normalize(), DVec3::Z);
        let w = direction(2.0 * stream.f64() - 1.0, 6.3 * stream.f64()).as_dvec3().normalize();
        let there = normals.to_shading(w);
        let back = normals.to_geometric(there.world, w.z);
        assert!((back.world - w).length() < 1e-9, "{w} came back as {}", back.world);
        assert!((there.jacobian * back.jacobian - 1.0).abs() < 1e-9);
        // The solid angle of a small triangle there for one here.
        let [a, b] = [w.any_orthonormal_vector(), w.cross(w.any_orthonormal_vector())];
        let near = |d: DVec3| normals.to_shading((w + 1e-6 * d).normalize()).world - there.world;
        let area = near(a).cross(near(b)).length() * 1e12;
        assert!((area - there.jacobian).abs() < 1e-3 * there.jacobian + 1e-4, "{w}: {area}, {there:?}");
    }
}

#[test]
fn c01_bent_normals_lose_no_light() {
    const POINTS: usize = 1 << 13;
    let us: Vec<Vec3> = even_points(POINTS).into_iter().map(DVec3::as_vec3).collect();
    // From above, from where the normal leans to, from the side, and from where it leans away from: 80 degrees there.
    let from = [Vec3::Z, direction(0.17, 1.0), direction(0.4, 2.5), direction(0.17, 4.14)];
    let mut cases = Vec::new();
    for (name, factors) in white() {
        for degrees in [5.0, 30.0, 50.0, 70.0, 89.0] {
            for from in from.into_iter().chain((name == "glass").then_some(-Vec3::Z)) {
                cases.push((name, degrees, Bent::new(&factors, tilted(degrees, 1.0), from, true)));
            }
        }
    }
    let drawn = draw(&cases.iter().map(|(_, _, case)| *case).collect::<Vec<_>>(), &us);
    let mut faults = Vec::new();
    for ((name, degrees, case), drawn) in cases.iter().zip(drawn.chunks_exact(POINTS)) {
        let albedo = drawn.iter().map(|drawn| f64::from(drawn.weight.x)).sum::<f64>() / POINTS as f64;
        let local = case.local(case.config.w_from).0;
        let unbent = match case.config.twin().delta {
            true => 1.0,
            false => twin_albedo(&case.config.twin(), local, true, POINTS).x,
        };
        // Nothing but what a rough lobe loses without a bend.
        let exact = match *name {
            "mirror" | "lambert" => Some(1.0),
            _ => None,
        };
        if (albedo - exact.unwrap_or(unbent)).abs() > 3e-3 * unbent {
            let w = case.config.w_from;
            faults.push(format!("{name} bent by {degrees}, seen from {w}: {albedo:.4}, not {unbent:.4}"));
        }
    }
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), cases.len(), faults.join("\n"));
}

#[test]
fn c02_bent_normals_have_their_density() {
    const SAMPLES: usize = 100_000;
    const GRID: [usize; 2] = [20, 42];
    let mut stream = Stream::new(22);
    let us: Vec<Vec3> = (0..SAMPLES).map(|_| Vec3::new(stream.f32(), stream.f32(), stream.f32())).collect();
    let materials = coloured_materials();
    let find = |name| materials.iter().find(|(known, _)| *known == name).expect("a known material").1;
    let from = [direction(0.9, 1.0), direction(0.3, 4.0)];
    let names = ["lambert", "rough metal", "rough glass"];
    let cases: Vec<(&str, Bent)> = names
        .into_iter()
        .flat_map(|name| [25.0, 65.0].map(|degrees| (name, degrees)))
        .flat_map(|(name, degrees)| {
            from.map(|from| (name, Bent::new(&find(name), tilted(degrees, 1.0), from, true)))
        })
        .collect();
    let level = sidak(FAMILY_ALPHA, cases.len());
    let drawn = draw(&cases.iter().map(|(_, case)| *case).collect::<Vec<_>>(), &us);
    for ((name, case), drawn) in cases.iter().zip(drawn.chunks_exact(SAMPLES)) {
        let mut next = drawn.iter();
        let draw = || next.next().and_then(|s| (s.chance > 0.0).then(|| s.w.as_dvec3()));
        let p = direction_chi_square(GRID, SAMPLES as u64, draw, |w| case.pdf(w.as_vec3()));
        assert!(p > level, "{name}, {case:?}: p = {p:e}");
    }
}

#[test]
fn c11_shading_normals_weigh_both_transports_alike() {
    // f |w_light.ns| / |w_light.ng| of the directions that the BSDF knows, whichever end is traced from, and a mirror's
    // weight times the same.
    let mut stream = Stream::new(11);
    let mirror = Factors { metallic: 1.0, delta: true, roughness: 0.0, ..DIELECTRIC };
    let rough = coloured_materials().into_iter().filter(|(_, m)| m.roughness >= 0.5);
    let materials: Vec<Factors> = rough.map(|(_, m)| m).chain([mirror]).collect();
    let cases: Vec<Bent> = (0..4000)
        .map(|i| {
            let normal = tilted(89.0 * stream.f64(), 6.3 * stream.f64());
            let from = direction(2.0 * stream.f64() - 1.0, 6.3 * stream.f64());
            Bent::new(&materials[i % materials.len()], normal, from, i % 2 == 0)
        })
        .collect();
    let us: Vec<Vec3> = even_points(5).into_iter().map(DVec3::as_vec3).collect();
    let drawn = draw(&cases, &us);
    let [mut mirrors, mut densities, mut back, mut values] = [const { Vec::new() }; 4];
    for (case, drawn) in cases.iter().zip(drawn.chunks_exact(us.len())) {
        let (twin, w_from) = (case.config.twin(), case.config.w_from);
        let from_eye = case.config.is_from_eye();
        for drawn in drawn.iter().filter(|drawn| drawn.chance > 0.0) {
            let (from, to) = (case.local(w_from), case.local(drawn.w));
            let ends = [(w_from, from), (drawn.w, to)];
            assert!(ends.iter().all(|(w, local)| f64::from(w.z) * local.0.z > 0.0), "light leaks: {case:?}");
            let [(_, eye), (light, light_local)] = if from_eye { ends } else { [ends[1], ends[0]] };
            let bend = |world: Vec3, local: (DVec3, f64)| (local.0.z * local.1 / f64::from(world.z)).abs();
            let bent = bend(light, light_local);
            let error = |value: Vec3, exact: DVec3| {
                (value.as_dvec3() - exact).abs().max_element() / exact.max_element()
            };
            if twin.delta {
                // Reflectance 1, over the probability 1, as f |w.ng| / pdf, where pdf is that of a mirror.
                mirrors.push(error(drawn.weight, DVec3::splat(bent / bend(drawn.w, to))));
                continue;
            }
            densities.push((f64::from(drawn.pdf_solid) / case.pdf(drawn.w) - 1.0).abs());
            let pdf_back = twin.pdf(to.0, from.0) * from.1;
            back.push((f64::from(drawn.pdf_back_solid) / pdf_back - 1.0).abs());
            values.push(error(drawn.f, twin.eval(eye.0, light_local.0) * bent));
        }
    }
    // At the horizon of the shading normal, where cosines have few digits, directions are up to nine times as dense.
    for (what, errors) in [("mirror", mirrors), ("density", densities), ("back", back), ("f", values)] {
        let [p90, p99, worst] = [0.9, 0.99, 1.0].map(|share| quantile(errors.clone(), share));
        println!("{what}: {} samples, p90 {p90:.1e}, p99 {p99:.1e}, largest {worst:.1e}", errors.len());
        assert!(errors.len() > 500 && p90 < 5e-5 && p99 < 4e-4, "{what}: {p90:e} {p99:e}");
    }
}
