//! The renderer's pictures against closed forms: furnaces, form factors, skies, many lights, darkness.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3};
use halfway::integrator::{Bdpt, Method, View};
use halfway::render::RenderOptions;
use halfway::scene::builtin::{builtin, closed, shapes};
use halfway::scene::{Camera, Environment, LightKind, Material, Mesh, Projection, PunctualLight, Scene};

use crate::judge::{grey, horizontal, lamp, scene, spot_camera};
use crate::quadrature;
use crate::shots::{Estimate, options, render};

/// The spot camera's picture of light scattered once at most.
fn spot(scene: &Scene, samples: u32) -> Estimate {
    spot_to_depth(scene, samples, Some(2))
}

fn spot_to_depth(scene: &Scene, samples: u32, max_depth: Option<u32>) -> Estimate {
    let mut scene = scene.clone();
    scene.cameras = vec![spot_camera()];
    let options = options([16, 16], samples);
    render(&scene, RenderOptions { view: View { max_depth, ..options.view }, ..options }).channel(0)
}

/// Light of at most `depth` surfaces in an enclosure that emits 1 everywhere.
fn furnace(rho: f32, depth: Option<u32>) -> f64 {
    let rho = f64::from(rho);
    let left = depth.map_or(0.0, |depth| rho.powi(depth as i32));
    (1.0 - left) / (1.0 - rho)
}

/// One line of the furnace tests: albedo, longest path, samples per pixel, largest standard error.
type Furnace = (f32, Option<u32>, u32, f64);

/// Without a limit roulette alone ends paths; limits find a roulette or a count of surfaces that is off by one.
const FURNACES: [Furnace; 8] = [
    (0.0, None, 16, 1e-5),
    (0.5, None, 1024, 3e-3),
    (0.8, None, 512, 5e-3),
    (0.99, None, 96, 1e-2),
    (0.5, Some(1), 16, 1e-5),
    (0.8, Some(2), 1024, 2e-3),
    (0.8, Some(5), 1024, 2e-3),
    (0.99, Some(8), 512, 2e-3),
];

#[track_caller]
fn assert_furnaces(name: &str, furnaces: &[Furnace], make: impl Fn(f32) -> Scene) {
    for &(rho, max_depth, samples, error) in furnaces {
        let shot = render(
            &make(rho),
            RenderOptions {
                view: View { max_depth, ..options([16, 16], samples).view },
                ..options([16, 16], samples)
            },
        );
        let what = format!("{name}, albedo {rho}, depth {max_depth:?}");
        shot.channel(0).assert_mean(&what, furnace(rho, max_depth), error);
    }
}

#[test]
fn c04_furnace_box() {
    assert_furnaces("box", &FURNACES, |rho| closed::furnace_box(rho, 1.0));
}

#[test]
fn c04_furnace_sphere() {
    // Of many triangles, which take longer.
    assert_furnaces("sphere", &FURNACES[1..3], |rho| closed::furnace_sphere(rho, 1.0, 3));
}

/// Where next to nothing is absorbed, noise has a bound as well: n paths have it as 1 / sqrt(n) of the mean, since what they
/// carry does not grow. Roulette below the albedo would have three times that from this many, and no bound at all.
#[test]
fn c04_furnace_that_absorbs_next_to_nothing() {
    let shot = render(&closed::furnace_box(0.999, 1.0), options([8, 8], 16));
    shot.channel(0).assert_mean("albedo .999", 1000.0, 3.6e-2);
    let surfaces = shot.report.rays.deep_paths().expect("paths of about 1000 surfaces");
    assert!((900.0..1100.0).contains(&surfaces), "{surfaces}");
    // Ten surfaces are nothing to warn of.
    assert_eq!(render(&closed::furnace_box(0.9, 1.0), options([12, 12], 8)).report.rays.deep_paths(), None);
}

/// What is caught between mirrors ends soon: the whole batch waits for it.
#[test]
fn c04_furnace_of_mirrors_ends() {
    let mut scene = closed::furnace_box(1.0, 1.0);
    for material in &mut scene.materials {
        (material.metallic, material.roughness) = (1.0, 0.0);
    }
    // Light paths have as many, and count as paths. In path, it is the least of q and .95 beyond.
    let bdpt = Method::Bdpt(Bdpt { light_tracing: false });
    for (method, expected) in [(Method::default(), 34.3), (bdpt, 33.0)] {
        let rays = render(&scene, RenderOptions { method, ..options([8, 8], 16) }).report.rays;
        let surfaces = rays.closest_hit as f64 / rays.paths as f64;
        println!("{}: {surfaces:.1} surfaces", method.name());
        // The sum of q^k up to 16 surfaces, q = 255/256, and of (.95 q)^k beyond; three standard errors of 1024 paths. (Of
        // q alone: 256.)
        assert!((expected - surfaces).abs() < 1.8, "{}: {surfaces}", method.name());
    }
}

#[test]
fn c07_form_factors() {
    let floor = |albedo| (grey(albedo), horizontal(0.02, 0.0, true));
    let square = scene([floor(0.5), (lamp(1.0), horizontal(1.0, 1.0, false))]);
    spot(&square, 2048).assert_mean("square", 0.5 * 0.239_456_470_460_773_5, 1e-3);

    // A disk of radius 1 at distance 1; a polygon of 4096 sides lacks 4e-7 of its area.
    let ring = |i: u32| TAU * f64::from(i) / 4096.0;
    let mut positions = vec![DVec3::Y];
    positions.extend((0..4096).map(|i| DVec3::new(ring(i).cos(), 1.0, ring(i).sin())));
    let triangles = (0..4096).map(|i| [0, 1 + i, 1 + (i + 1) % 4096]).collect();
    let disk = scene([floor(0.8), (lamp(2.0), Mesh { positions, triangles, ..Mesh::default() })]);
    spot(&disk, 2048).assert_mean("disk", 0.8, 1e-3);

    // Radius 1/2 at distance 2; the icosphere inside it has 6e-4 less of a cross-section.
    let ball = scene([floor(1.0), (lamp(1.0), shapes::icosphere(DVec3::Y * 2.0, 0.5, 5))]);
    let expected = 0.196_349_540_849_362_07 / PI;
    let found = spot(&ball, 3072);
    found.assert_mean("sphere", expected * (1.0 - 3e-4), 2e-3);
}

/// A square lamp at the far end of a square pipe of mirrors lights a floor as if it were at the near end.
pub fn pipe_of_mirrors(length: f64) -> Scene {
    let mirror = || Material { metallic: 1.0, roughness: 0.0, ..grey(1.0) };
    let corner = |x: f64, z: f64| DVec3::new(x, 1.0, z);
    let along = DVec3::Y * length;
    let (near, far) = (corner(-0.5, -0.5), [corner(0.5, -0.5), corner(-0.5, 0.5)]);
    let mut scene = scene([
        (grey(0.5), horizontal(1.0, 0.0, true)),
        (lamp(1.0), horizontal(1.0, 1.0 + length, false)),
        (mirror(), shapes::quad(near, along, DVec3::Z)),
        (mirror(), shapes::quad(far[0], DVec3::Z, along)),
        (mirror(), shapes::quad(near, DVec3::X, along)),
        (mirror(), shapes::quad(far[1], along, DVec3::X)),
    ]);
    scene.name = "pipe of mirrors".into();
    scene.cameras.push(shapes::looking_at("floor", DVec3::new(0.0, 0.8, 1.5), DVec3::ZERO, 45.0));
    scene
}

/// Up to sixty mirrors in a row, more than roulette passes like any others.
#[test]
fn c07_pipe_of_mirrors() {
    let found = spot_to_depth(&pipe_of_mirrors(60.0), 1024, None);
    found.assert_mean("pipe", 0.5 * 0.239_456_470_460_773_5, 1e-2);
}

#[test]
fn c07_squares_that_share_an_edge() {
    let wall = shapes::quad(DVec3::new(-0.5, 0.0, -0.5), DVec3::X, DVec3::Y);
    let mut scene = scene([(grey(1.0), horizontal(1.0, 0.0, true)), (lamp(1.0), wall)]);
    scene.cameras.push(from_above(0.5));
    let shot = render(
        &scene,
        RenderOptions {
            view: View { max_depth: Some(2), ..options([32, 32], 512).view },
            ..options([32, 32], 512)
        },
    );
    shot.channel(0).assert_mean("wall to floor", 0.200_043_776_075_403_16, 2e-3);
}

/// A parallel camera high above the origin that sees a square of half side `half`; +x to the right, -z up.
fn from_above(half: f32) -> Camera {
    Camera {
        name: "above".into(),
        position: DVec3::Y * 3.0,
        right: Vec3::X,
        up: Vec3::NEG_Z,
        forward: Vec3::NEG_Y,
        projection: Projection::Orthographic { xmag: half, ymag: half },
    }
}

#[test]
fn c07_inverse_square() {
    let mut scene = scene([(grey(0.6), horizontal(0.02, 0.0, true))]);
    let towards_origin = DVec3::new(-1.0, -2.0, -2.0) / 3.0;
    let lambert = 0.6 / PI * 3.0 * (2.0 / 3.0);
    for (kind, distance, expected) in [
        (LightKind::Point, 1.0, lambert),
        (LightKind::Point, 10.0, lambert / 1e2),
        (LightKind::Point, 1e4, lambert / 1e8),
        (LightKind::Spot { inner: 0.2, outer: 0.5 }, 2.0, lambert / 4.0),
        (LightKind::Directional, 0.0, lambert),
    ] {
        scene.lights = vec![PunctualLight {
            name: String::new(),
            kind,
            intensity: Vec3::splat(3.0),
            position: towards_origin * -distance,
            direction: towards_origin.as_vec3(),
        }];
        spot(&scene, 32).assert_mean(&format!("{kind:?} at {distance}"), expected, 1e-5);
    }
}

/// One bright texel of a coarse latitude-longitude picture over a white plane. A texel's value falls linearly to its
/// neighbours' centres, so its integral over the azimuth is one column, and its row is a trapezoid at the pole.
#[test]
fn n20_one_texel_lights_a_plane() {
    for ([width, height], column, row) in
        [([4, 2], 0, 0), ([4, 2], 3, 0), ([4, 2], 2, 1), ([1, 4], 0, 1), ([8, 8], 5, 0)]
    {
        let mut texels = vec![[0.0; 3]; (width * height) as usize];
        texels[(row * width + column) as usize] = [1e6; 3];
        let mut scene = scene([(grey(1.0), horizontal(0.02, 0.0, true))]);
        scene.environment = Some(sky(width, texels));
        let row_step = PI / f64::from(height);
        let value = |polar: f64| {
            let place = (polar / row_step - 0.5).clamp(0.0, f64::from(height - 1));
            (1.0 - (place - f64::from(row)).abs()).max(0.0)
        };
        let column_step = TAU / f64::from(width);
        let over_rows = quadrature::interval(0.0, FRAC_PI_2, 256, |t| value(t) * t.sin() * t.cos());
        let expected = 1e6 / PI * column_step * over_rows;
        let found = spot(&scene, 2048);
        println!(
            "{width}x{height}, column {column}, row {row}: {} of the closed form",
            found.mean / expected
        );
        assert!(found.error < 3e-3 * expected, "{found:?}");
        // The map of equal areas averages the picture's texels: 0.2 % is what it may differ by.
        assert!((found.mean - expected).abs() < 5.0 * found.error + 2e-3 * expected, "{found:?}, {expected}");
    }
    let mut dark = scene([(grey(1.0), horizontal(0.02, 0.0, true))]);
    dark.environment = Some(sky(4, vec![[0.0; 3]; 8]));
    assert_eq!(spot(&dark, 16).mean, 0.0);
}

fn sky(width: u32, texels: Vec<[f32; 3]>) -> Environment {
    let height = texels.len() as u32 / width;
    Environment { name: String::new(), width, height, texels, scale: 1.0, rotation: 0.0 }
}

/// Sixteen open boxes seen from above, each with a lamp that lights nothing but its own box. Powers over twenty
/// decades.
fn boxes(radiances: [f32; 16]) -> Scene {
    let white = (grey(0.6), horizontal(4.0, 0.0, true));
    let mut scene = scene([white]);
    let mut add = |material, mesh| scene.meshes.push(Mesh { material, ..mesh });
    for i in 0..5 {
        let at = f64::from(i) - 2.0;
        let (x, y, z) = (DVec3::X * 4.0, DVec3::Y * 0.7, DVec3::Z * 4.0);
        add(0, shapes::quad(DVec3::new(at, -0.1, -2.0), y, z));
        add(0, shapes::quad(DVec3::new(-2.0, -0.1, at), x, y));
    }
    for (i, radiance) in (0..16).zip(radiances) {
        let corner = DVec3::new(f64::from(i % 4) - 1.6, 0.4, f64::from(i / 4) - 1.6);
        add(1 + i, shapes::quad(corner, DVec3::X * 0.2, DVec3::Z * 0.2));
        scene.materials.push(lamp(radiance));
    }
    scene.cameras.push(from_above(2.0));
    scene
}

#[test]
fn n21_every_light_gives_its_own() {
    // In an order that has nothing to do with the places.
    let radiance = |i: usize| 10f64.powf(20.0 * ((7 * i) % 16) as f64 / 15.0 - 10.0) as f32;
    let all = render(&boxes(std::array::from_fn(radiance)), options([32, 32], 2048));
    let place = |i: usize| [(i % 4 * 8) as u32, (i / 4 * 8) as u32];
    // The light of one box, by itself; the boxes are alike but for the lamp's radiance.
    let alone = render(&boxes([1.0; 16]), options([32, 32], 512));
    for i in 0..16 {
        let scale = f64::from(radiance(i));
        let Estimate { mean, error } = alone.part(0, place(i), [8, 8]);
        let expected = Estimate { mean: mean * scale, error: error * scale };
        let found = all.part(0, place(i), [8, 8]);
        let z = found.z(expected);
        println!("box {i}, radiance {scale:e}: {:.4} of its own, z = {z:.2}", found.mean / expected.mean);
        assert!(found.error < 0.1 * expected.mean, "box {i}: too noisy to judge, {found:?}");
        assert!(z.abs() < 5.0, "box {i}: {found:?} instead of {expected:?}");
    }
    for i in [0, 7, 13] {
        // The same with every other lamp off.
        let mut only = [0.0; 16];
        only[i] = radiance(i);
        let only = render(&boxes(only), options([32, 32], 128));
        let (own, found) = (only.part(0, place(i), [8, 8]), all.part(0, place(i), [8, 8]));
        assert!(found.z(own).abs() < 5.0, "box {i}: {found:?} with all, {own:?} alone");
        let total = only.channel(0).mean * 16.0;
        assert!((total / own.mean - 1.0).abs() < 1e-6, "box {i} lights other boxes: {total} of {own:?}");
    }
}

/// Surfaces that reflect nothing show the lamps only; lamps that emit nothing show nothing.
#[test]
fn c24_black_surfaces_and_dark_lamps() {
    let cornell = builtin("cornell").expect("a built-in scene");
    let mut black = cornell.clone();
    black.materials.iter_mut().for_each(|material| material.base_color = Vec3::ZERO);
    let all = render(&black, options([16, 16], 16)).picture;
    let seen = render(
        &cornell,
        RenderOptions {
            view: View { max_depth: Some(1), ..options([16, 16], 16).view },
            ..options([16, 16], 16)
        },
    )
    .picture;
    assert_eq!(all.rgb, seen.rgb);
    assert!(seen.rgb.iter().any(|pixel| pixel[0] > 0.0), "the lamp is in view");

    let mut dark = cornell;
    dark.materials.iter_mut().for_each(|material| material.emission = Vec3::ZERO);
    let dark = render(&dark, options([16, 16], 16)).picture;
    assert!(dark.rgb.iter().flatten().all(|&value| value == 0.0));

    // A mirror before a dark sky and a lamp that is off: other features, the same darkness.
    let mut mirror = scene([(Material::default(), horizontal(1.0, 0.0, true))]);
    mirror.environment = Some(sky(1, vec![[0.0; 3]; 2]));
    assert_eq!(spot(&mirror, 16).mean, 0.0);
}
