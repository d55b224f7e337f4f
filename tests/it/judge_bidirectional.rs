//! The bidirectional judge judged: every strategy by itself against closed forms, all of them together against the
//! judge's path tracer, and what must hold for any path.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};
use halfway::scene::builtin::{builtin, closed, shapes};
use halfway::scene::{Camera, Material, Scene};

use crate::judge::{self, grey, horizontal, lamp};
use crate::reference::bidirectional::{Options, render_bidirectional, render_paths, trace_full_paths};
use crate::reference::path_space::{LightEnd, PathSpace, Scaled, SurfaceVertex, weights};
use crate::reference::{self, render};
use crate::stats::{Moments, assert_equal_tiles, tile_means};

fn scene(name: &str) -> Scene {
    builtin(name).expect("a built-in scene")
}

/// Light of k scatterings, n = k + 1 edges, by each possible strategy alone. Light tracing finds too little of the
/// centre's half millimetre to be judged there.
fn assert_plates(view: &Camera, light_tracing: bool, closed_form: [f64; 5]) {
    let scene = closed::plates();
    // Long paths are rare; with s = 0 only one in ten lives through each plate.
    let largest_error = [1e-9, 1e-2, 1e-2, 4e-2, 1.2e-1];
    let options = Options {
        resolution: [64, 64],
        samples: 300,
        seed: 12,
        max_scatterings: 4,
        light_tracing,
        weighted: false,
        ..Options::default()
    };
    let picture = render_bidirectional(&scene, view, &options);
    for (k, expected) in closed_form.into_iter().enumerate() {
        let n = k + 1;
        for t in 1..=n + 1 {
            let s = n + 1 - t;
            let found = picture.strategy(s, t)[1];
            if (t == 1 && (!light_tracing || n == 1)) || (n == 1 && s > 0) {
                assert_eq!(found.mean, 0.0, "there is no strategy ({s}, {t})");
                continue;
            }
            let what = format!("plates {}, s = {s}, t = {t}", view.name);
            println!("{what}: {:.6e} +- {:.1e} of {expected:.6e}", found.mean, found.standard_error());
            // Every sample sees the plate itself.
            found.assert_mean(&what, expected, largest_error[k]);
        }
    }
}

#[test]
fn c05_every_strategy_alone_at_the_centre() {
    let view = &closed::plates().cameras[0];
    assert_plates(view, false, [1.0, 0.119_728_235, 0.012_200_323, 0.001_235_763, 0.000_125_144]);
}

#[test]
fn c05_every_strategy_alone_on_average() {
    let view = &closed::plates().cameras[1];
    assert_plates(view, true, [1.0, 0.099_912_448, 0.010_113_269, 0.001_024_130, 0.000_103_711]);
}

/// Tile means of the scattered light in independent pictures, by both of the judge's renderers. (Lights seen directly
/// are the same estimator in both, and noise.)
#[track_caller]
fn assert_same_as_path_tracer(name: &str, resolution: [u32; 2], samples: [u32; 2]) {
    assert_same_as_path_tracer_in(&scene(name), resolution, samples);
}

#[track_caller]
fn assert_same_as_path_tracer_in(scene: &Scene, resolution: [u32; 2], samples: [u32; 2]) {
    let name = &scene.name;
    let view = &scene.cameras[0];
    let (tile, runs, max_scatterings) = (resolution[1] / 2, 12, 12);
    let space = PathSpace::new(scene, view, resolution);
    let scattered = |by_scatterings: &[Vec<DVec3>]| -> Vec<DVec3> {
        let pixels = 0..by_scatterings[0].len();
        pixels.map(|pixel| by_scatterings[1..].iter().map(|picture| picture[pixel]).sum()).collect()
    };
    let bidirectional: Vec<Vec<f64>> = (0..runs)
        .map(|seed| {
            let options =
                Options { resolution, samples: samples[0], seed, max_scatterings, ..Options::default() };
            tile_means(&scattered(&render_paths(&space, &options).by_scatterings), resolution, tile)
        })
        .collect();
    let path_traced: Vec<Vec<f64>> = (0..runs)
        .map(|run| {
            let (seed, samples) = (1000 + run, samples[1]);
            let options =
                reference::Options { resolution, samples, seed, max_scatterings, ..Default::default() };
            tile_means(&scattered(&render(scene, view, &options).by_scatterings), resolution, tile)
        })
        .collect();
    let whole = |runs: &[Vec<f64>]| -> Moments {
        runs.iter().map(|tiles| tiles.iter().sum::<f64>() / tiles.len() as f64).collect()
    };
    let (a, b) = (whole(&bidirectional), whole(&path_traced));
    println!(
        "{name}: {:.6} +- {:.6} by all strategies, {:.6} +- {:.6} by paths",
        a.mean,
        a.standard_error(),
        b.mean,
        b.standard_error()
    );
    // A test that cannot see a fault must not pass.
    assert!(a.standard_error() < 0.02 * b.mean && b.standard_error() < 0.02 * b.mean, "{name}: too noisy");
    assert_equal_tiles(name, &bidirectional, &path_traced);
}

#[test]
fn bidirectional_cornell() {
    assert_same_as_path_tracer("cornell", [16, 16], [8, 32]);
}

#[test]
fn bidirectional_three_lights() {
    assert_same_as_path_tracer("three-lights", [24, 16], [8, 32]);
}

#[test]
fn bidirectional_spheres() {
    assert_same_as_path_tracer("spheres", [36, 16], [8, 24]);
}

#[test]
fn bidirectional_bumpy_plane() {
    assert_same_as_path_tracer("bumpy-plane", [16, 16], [16, 32]);
}

#[test]
fn bidirectional_glass_slab() {
    assert_same_as_path_tracer("glass-slab", [16, 16], [8, 32]);
}

/// A matte table inside a block of glass, lit from outside, seen from inside: only light that came through the glass
/// by itself (s = 0, or t = 1) reaches the picture, and radiance is larger in there by the index squared.
#[test]
fn bidirectional_inside_glass() {
    let glass = Material {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        volume: true,
        ior: 1.7,
        ..Material::default()
    };
    let block = shapes::cuboid(DVec3::new(-1.0, -0.5, -1.0), DVec3::new(1.0, 1.0, 1.0));
    let mut scene = judge::scene([
        (glass, block),
        (grey(0.6), horizontal(1.0, 0.0, true)),
        (lamp(1.0), horizontal(2.0, 1.5, false)),
    ]);
    scene.name = "inside glass".into();
    scene.cameras.push(shapes::looking_at("inside", DVec3::new(0.1, 0.9, 0.1), DVec3::ZERO, 50.0));
    assert_same_as_path_tracer_in(&scene, [16, 16], [16, 32]);
}

/// Direct light of every kind of light, by points drawn on the light and by light paths alone: what the density of
/// light paths holds, the cone of a spot and the disc of the sky included, is in this comparison.
#[test]
fn every_kind_of_light_by_light_paths() {
    let all = scene("three-lights");
    let dark = |scene: &mut Scene| {
        scene.materials.iter_mut().for_each(|material| material.emission = Vec3::ZERO);
        scene.environment = None;
        scene.lights.clear();
    };
    for kind in 0..5 {
        let mut scene = all.clone();
        dark(&mut scene);
        let what = match kind {
            0 => {
                scene.materials.clone_from(&all.materials);
                "lamp".into()
            }
            1 => {
                scene.environment.clone_from(&all.environment);
                "sky".into()
            }
            _ => {
                scene.lights.push(all.lights[kind - 2].clone());
                all.lights[kind - 2].name.clone()
            }
        };
        let options = Options {
            resolution: [24, 16],
            samples: 96,
            max_scatterings: 1,
            weighted: false,
            ..Options::default()
        };
        let picture = render_bidirectional(&scene, &scene.cameras[0], &options);
        let (by_light, by_eye) = (picture.strategy(2, 1)[1], picture.strategy(1, 2)[1]);
        println!(
            "{what}: {:.6} +- {:.6} by light paths, {:.6} +- {:.6} by connections",
            by_light.mean,
            by_light.standard_error(),
            by_eye.mean,
            by_eye.standard_error()
        );
        let error = by_light.standard_error().hypot(by_eye.standard_error());
        assert!(error < 0.03 * by_eye.mean, "{what}: too noisy");
        assert!((by_light.mean - by_eye.mean).abs() < 5.0 * error, "{what}");
    }
}

/// Inside a furnace light of one scattering is the same everywhere; light paths draw it by where they are seen.
#[test]
fn light_tracing_reaches_the_border() {
    let scene = closed::furnace_box(0.5, 1.0);
    let (resolution, only) = ([24, 16], Some((2, 1)));
    let options = Options {
        resolution,
        samples: 1600,
        max_scatterings: 1,
        only,
        weighted: false,
        ..Options::default()
    };
    let picture = render_bidirectional(&scene, &scene.cameras[0], &options);
    let mut parts = [Moments::default(); 2];
    for (pixel, [_, found, _]) in (0u32..).zip(&picture.moments) {
        let [x, y] = [pixel % resolution[0], pixel / resolution[0]];
        let border = x == 0 || y == 0 || x + 1 == resolution[0] || y + 1 == resolution[1];
        let by_scatterings = picture.by_scatterings.iter().map(|picture| picture[pixel as usize].y);
        assert!((by_scatterings.sum::<f64>() - picture.mean[pixel as usize].y).abs() < 1e-9);
        // One light path is seen once at most: pixels are as good as independent.
        parts[usize::from(border)] = parts[usize::from(border)].merge(*found);
    }
    for (part, what) in parts.iter().zip(["middle", "border"]) {
        println!("{what}: {:.5} +- {:.5}", part.mean, part.standard_error());
        part.assert_mean(what, 0.5, 1e-2);
    }
}

/// Weights of paths found in every way, through every kind of surface, to every kind of light.
#[test]
fn weights_sum_to_one() {
    let mut kinds = BTreeSet::new();
    for name in ["cornell", "three-lights", "spheres", "bumpy-plane", "glass-slab"] {
        let scene = scene(name);
        let space = PathSpace::new(&scene, &scene.cameras[0], [16, 16]);
        let options = Options { samples: 4, max_scatterings: 8, ..Options::default() };
        let paths = trace_full_paths(&space, &options);
        assert!(paths.len() > 200, "{name}: only {} paths", paths.len());
        for path in &paths {
            let n = path.edges();
            let strategies = space.strategies(path, |edge, _| 0.5 + edge as f64, 2.0, 256.0);
            assert_eq!(strategies.len(), n + 1);
            assert!(strategies.iter().all(|strategy| strategy.s + strategy.t == n + 1));
            let weights = weights(&strategies);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{name}: {weights:?} of {path:?}");
            // Seen directly, a light has no other strategy; a light without a surface cannot be hit.
            if n == 1 {
                assert_eq!(weights, [0.0, 1.0]);
            }
            if matches!(path.end, LightEnd::Punctual(_)) {
                assert_eq!(weights[n], 0.0);
            }
            assert!(!space.contribution(path).is_zero(), "{name}: nothing comes along {path:?}");
            for vertex in &path.surfaces {
                let (mesh, triangle) = vertex.scene_triangle;
                assert_eq!(space.world.tree_triangle(mesh, triangle), Some(vertex.triangle));
                let corners = scene.meshes[mesh].triangles[triangle];
                let [a, b, c] = corners.map(|corner| scene.meshes[mesh].positions[corner as usize]);
                let [u, v] = vertex.b;
                assert!((a + u * (b - a) + v * (c - a)).distance(vertex.position) < 1e-12);
            }
            kinds.insert(match path.end {
                LightEnd::Emitter(_) => "emitter".into(),
                LightEnd::Environment(_) => "environment".into(),
                LightEnd::Punctual(index) => format!("{:?}", scene.lights[index].kind),
            });
        }
    }
    assert_eq!(kinds.len(), 5, "lights of every kind: {kinds:?}");
}

/// A path of the furnace box, back and forth between its walls.
fn long_path(n: usize) -> Vec<(usize, [f64; 2])> {
    let walls = [0, 4, 8, 2, 6, 10, 1, 5, 9, 3, 7, 11];
    (0..n).map(|i| (walls[(5 * i) % 12], [0.1 + 0.3 * ((7 * i) % 5) as f64 / 5.0, 0.35])).collect()
}

/// 32 edges in rooms of a micrometre to a thousand kilometres: products of 32 densities are out of range there, their
/// ratios are what they are in a room of a metre.
#[test]
fn long_paths_of_any_size() {
    let mut expected: Option<(Vec<f64>, f64)> = None;
    for scale in [1.0, 1e-6, 1e6] {
        let mut scene = closed::furnace_box(0.5, 1.0);
        scene.meshes[0].positions.iter_mut().for_each(|position| *position *= scale);
        scene.cameras[0].position *= scale;
        let space = PathSpace::new(&scene, &scene.cameras[0], [8, 8]);
        let mut vertices = long_path(32).into_iter().map(|(triangle, b)| {
            let [a, b1, c] = space.world.corners(triangle);
            let position = a + b[0] * (b1 - a) + b[1] * (c - a);
            SurfaceVertex { position, triangle, scene_triangle: (0, triangle), b }
        });
        let surfaces: Vec<SurfaceVertex> = vertices.by_ref().take(31).collect();
        let end = LightEnd::Emitter(vertices.next().expect("the last vertex"));
        let camera = scene.cameras[0].position;
        let path = reference::path_space::FullPath { camera, surfaces, end };
        let strategies = space.strategies(&path, |_, _| 1.0, 1.0, 64.0);
        let weights = weights(&strategies);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
        // f/p of the path tracer's own strategy has no unit.
        let throughput = space.contribution(&path).over(strategies[32].ln_pdf).y;
        let (first, first_throughput) = expected.get_or_insert((weights.clone(), throughput));
        assert!(throughput > 0.0 && (throughput / *first_throughput - 1.0).abs() < 1e-9, "{throughput}");
        for (weight, first) in weights.iter().zip(first) {
            assert!((weight - *first).abs() <= 1e-9 * *first, "{weight} instead of {first} at {scale}");
        }
    }
}

/// f, p and w of a path that can be written down: a point of one plate that lights a point of the other.
#[test]
fn a_path_by_hand() {
    use std::f64::consts::PI;
    let scene = closed::plates();
    // The whole plate in one pixel: the camera's density is one per area.
    let space = PathSpace::new(&scene, &scene.cameras[1], [1, 1]);
    let on = |mesh: usize, b: [f64; 2]| {
        let triangle = space.world.tree_triangle(mesh, 0).expect("a triangle with area");
        let [a, b1, c] = space.world.corners(triangle);
        SurfaceVertex {
            position: a + b[0] * (b1 - a) + b[1] * (c - a),
            triangle,
            scene_triangle: (mesh, 0),
            b,
        }
    };
    let (lit, lamp) = (on(0, [0.2, 0.3]), on(1, [0.1, 0.6]));
    let camera = DVec3::new(lit.position.x, lit.position.y, 0.0);
    let path = reference::path_space::FullPath { camera, surfaces: vec![lit], end: LightEnd::Emitter(lamp) };
    let distance_sq = lit.position.distance_squared(lamp.position);
    // Two cosines, both 1 / d.
    let geometry = 1.0 / (distance_sq * distance_sq);
    let lambert = geometry / PI;
    let close = |what: &str, found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-6, "{what}: {found} instead of {expected}");
    };
    close("f", space.contribution(&path).over(0.0).y, 0.5 * lambert);
    // Albedo 0.5 survives half of the time; two plates of area 1 share the light paths.
    let strategies = space.strategies(&path, |_, _| 3.0, 1.0, 7.0);
    let expected = [7.0 * 0.5 * lambert, 3.0 * 0.5, 0.5 * lambert];
    for (strategy, expected) in strategies.iter().zip(expected) {
        close("p", strategy.ln_pdf.exp(), expected);
    }
    let sum: f64 = expected.iter().sum();
    for (weight, expected) in weights(&strategies).into_iter().zip(expected) {
        close("w", weight, expected / sum);
    }
    assert!(Scaled::ONE.times(DVec3::ZERO).is_zero());
}
