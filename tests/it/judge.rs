//! The judge judged: its pictures against closed forms.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use halfway::scene::builtin::{closed, shapes, surfaces};
use halfway::scene::{Camera, Environment, LightKind, Material, Mesh, Projection, PunctualLight, Scene};

use crate::quadrature;
use crate::reference::{Options, Render, render};
use crate::stats::{Moments, assert_equal_tiles, tile_means};

/// A scene of meshes with one material each.
pub fn scene<const N: usize>(parts: [(Material, Mesh); N]) -> Scene {
    let mut scene = Scene::default();
    for (index, (material, mesh)) in parts.into_iter().enumerate() {
        scene.materials.push(material);
        scene.meshes.push(Mesh { material: index as u32, ..mesh });
    }
    scene
}

pub fn lamp(radiance: f32) -> Material {
    Material { emission: Vec3::splat(radiance), ..Material::lambert("lamp", Vec3::ZERO) }
}

pub fn grey(albedo: f32) -> Material {
    Material::lambert("grey", Vec3::splat(albedo))
}

/// A horizontal square of side `side` about (0, height, 0) that faces up, or down.
pub fn horizontal(side: f64, height: f64, up: bool) -> Mesh {
    let corner = DVec3::new(-0.5 * side, height, -0.5 * side);
    let (x, z) = (DVec3::X * side, DVec3::Z * side);
    if up { shapes::quad(corner, z, x) } else { shapes::quad(corner, x, z) }
}

/// A camera that sees only the immediate neighbourhood of the origin, from the side.
pub fn spot_camera() -> Camera {
    shapes::looking_at("spot", DVec3::new(0.3, 0.2, 0.4), DVec3::ZERO, 1e-4_f32)
}

fn one_pixel(scene: &Scene, camera: &Camera, samples: u32, max_scatterings: usize) -> Render {
    // Many pixels that see the same, so that all threads have work.
    let options = Options {
        resolution: [16, 16],
        samples: samples / 256,
        seed: 1,
        max_scatterings,
        ..Options::default()
    };
    render(scene, camera, &options)
}

/// Statistics over independent pictures of the light of each number of scatterings.
fn by_scatterings(scene: &Scene, camera: &Camera, options: Options, runs: u64) -> Vec<Moments> {
    let mut moments = vec![Moments::default(); options.max_scatterings + 1];
    for seed in 0..runs {
        let picture = render(scene, camera, &Options { seed, ..options });
        moments.iter_mut().enumerate().for_each(|(k, all)| all.push(picture.grey_of(k)));
    }
    moments
}

#[test]
fn c07_point_to_square() {
    let mut scene =
        scene([(grey(0.5), horizontal(0.02, 0.0, true)), (lamp(1.0), horizontal(1.0, 1.0, false))]);
    let expected = 0.239_456_470_460_773_5;
    let kernel = |[x, y]: [f64; 2]| 1.0 / (PI * (x * x + y * y + 1.0).powi(2));
    let quarter = quadrature::rectangle([0.0; 2], [0.5; 2], kernel);
    assert!((4.0 * quarter / expected - 1.0).abs() < 1e-6, "the constant and the integral disagree");
    let picture = one_pixel(&scene, &spot_camera(), 1 << 19, 1);
    picture.channel(0).assert_mean("square lamp", 0.5 * expected, 5e-4);

    // Exposure: everything is proportional to the light, at any power.
    scene.materials[1].emission *= 1e20;
    let picture = one_pixel(&scene, &spot_camera(), 1 << 16, 1);
    picture.channel(0).assert_mean("bright square lamp", 0.5e20 * expected, 2e-3);
}

#[test]
fn c07_disk() {
    // A disk of radius 1 at distance 1: E = pi L / 2. A polygon of 4096 sides lacks 4e-7 of its area.
    let ring = |i: u32| TAU * f64::from(i) / 4096.0;
    let mut positions = vec![DVec3::Y];
    positions.extend((0..4096).map(|i| DVec3::new(ring(i).cos(), 1.0, ring(i).sin())));
    let triangles = (0..4096).map(|i| [0, 1 + i, 1 + (i + 1) % 4096]).collect();
    let disk = Mesh { positions, triangles, ..Mesh::default() };
    let scene = scene([(grey(0.8), horizontal(0.02, 0.0, true)), (lamp(2.0), disk)]);
    let picture = one_pixel(&scene, &spot_camera(), 1 << 18, 1);
    picture.channel(0).assert_mean("disk lamp", 0.8 / PI * 2.0 * 0.5 * PI, 1e-3);
}

#[test]
fn c07_sphere() {
    // Radius 1/2 at distance 2: E / L = pi / 16. An icosphere of 20480 triangles inside it has 6e-4 less cross-section.
    let sphere = shapes::icosphere(DVec3::Y * 2.0, 0.5, 5);
    let scene = scene([(grey(1.0), horizontal(0.02, 0.0, true)), (lamp(1.0), sphere)]);
    let picture = one_pixel(&scene, &spot_camera(), 1 << 18, 1);
    picture.channel(0).assert_mean("sphere lamp", 0.196_349_540_849_362_07 / PI, 4e-3);
}

#[test]
fn c07_perpendicular_squares() {
    // The mean over a floor beside a wall that shares an edge with it.
    let wall = shapes::quad(DVec3::new(-0.5, 0.0, -0.5), DVec3::X, DVec3::Y);
    let scene = scene([(grey(1.0), horizontal(1.0, 0.0, true)), (lamp(1.0), wall)]);
    let view = shapes::looking_at("above", DVec3::Y * 3.0, DVec3::ZERO, 1.0);
    let view = Camera {
        right: Vec3::X,
        up: Vec3::NEG_Z,
        projection: Projection::Orthographic { xmag: 0.5, ymag: 0.5 },
        ..view
    };
    let options =
        Options { resolution: [32, 32], samples: 64, seed: 0, max_scatterings: 1, ..Options::default() };
    let light = by_scatterings(&scene, &view, options, 16);
    light[1].assert_mean("wall to floor", 0.200_043_776_075_403_16, 2e-3);
    assert_eq!(light[0].mean, 0.0);
}

#[test]
fn c07_punctual_lights() {
    let mut scene = scene([(grey(0.6), horizontal(0.02, 0.0, true))]);
    let at = |kind, position: DVec3, direction: DVec3| PunctualLight {
        name: String::new(),
        kind,
        intensity: Vec3::splat(3.0),
        position,
        direction: direction.normalize().as_vec3(),
    };
    let towards_origin = DVec3::new(-1.0, -2.0, -2.0);
    let far = |distance: f64| -towards_origin * (distance / 3.0);
    // Half-way in the cosine between the two angles: a quarter of the light.
    let halfway = (0.5 * (0.2f64.cos() + 0.5f64.cos())).acos();
    let aside = {
        let (axis, side) = (towards_origin / 3.0, DVec3::new(0.0, 1.0, -1.0).normalize());
        axis * halfway.cos() + side * halfway.sin()
    };
    let spot = LightKind::Spot { inner: 0.2, outer: 0.5 };
    let lambert = 0.6 / PI * 3.0 * (2.0 / 3.0);
    for (what, light, expected) in [
        ("point at 1", at(LightKind::Point, far(1.0), DVec3::Y), lambert),
        ("point at 10", at(LightKind::Point, far(10.0), DVec3::Y), lambert / 100.0),
        ("spot, inside", at(spot, far(2.0), towards_origin), lambert / 4.0),
        ("spot, halfway", at(spot, far(2.0), aside), lambert / 16.0),
        ("sun", at(LightKind::Directional, DVec3::ZERO, towards_origin), lambert),
    ] {
        scene.lights = vec![light];
        let mean = one_pixel(&scene, &spot_camera(), 4096, 1).channel(0).mean;
        // f32 directions, angles and normals of the scene carry 1e-7 of error each.
        assert!((mean / expected - 1.0).abs() < 1e-5, "{what}: {mean} instead of {expected}");
    }
}

#[test]
fn c04_furnace_box() {
    for rho in [0.0f32, 0.5, 0.8] {
        let scene = closed::furnace_box(rho, 1.0);
        let most = 200;
        let options = Options {
            resolution: [16, 16],
            samples: 64,
            seed: 4,
            max_scatterings: most,
            ..Options::default()
        };
        let picture = render(&scene, &scene.cameras[0], &options);
        let expected = (1.0 - f64::from(rho).powi(most as i32 + 1)) / (1.0 - f64::from(rho));
        picture.channel(0).assert_mean("furnace box", expected, 1e-2);
    }
}

#[test]
fn c04_furnace_sphere_by_scatterings() {
    let rho = 0.8f32;
    let scene = closed::furnace_sphere(rho, 1.0, 2);
    let options =
        Options { resolution: [16, 16], samples: 24, seed: 0, max_scatterings: 6, ..Options::default() };
    let light = by_scatterings(&scene, &scene.cameras[0], options, 16);
    for (k, light) in light.iter().enumerate() {
        light.assert_mean(&format!("furnace sphere, {k} scatterings"), f64::from(rho).powi(k as i32), 1e-2);
    }
}

#[test]
fn c05_plates_by_scatterings() {
    let scene = closed::plates();
    let centre = [1.0, 0.119_728_235, 0.012_200_323, 0.001_235_763, 0.000_125_144];
    let average = [1.0, 0.099_912_448, 0.010_113_269, 0.001_024_130, 0.000_103_711];
    // Long paths are rare.
    let largest_error = [1e-9, 3e-3, 1e-2, 3e-2, 7e-2];
    for (camera, expected) in scene.cameras.iter().zip([centre, average]) {
        let options =
            Options { resolution: [16, 16], samples: 256, seed: 0, max_scatterings: 4, ..Options::default() };
        let light = by_scatterings(&scene, camera, options, 16);
        for (k, light) in light.iter().enumerate() {
            light.assert_mean(
                &format!("plates {}, {k} scatterings", camera.name),
                expected[k],
                largest_error[k],
            );
        }
    }
}

fn sky(texels: Vec<[f32; 3]>, width: u32) -> Environment {
    let height = texels.len() as u32 / width;
    Environment { name: String::new(), width, height, texels, scale: 1.0, rotation: 0.0 }
}

#[test]
fn n20_plane_under_the_sky() {
    // Radiance that falls linearly with the polar angle, as two rows interpolate it: E = pi L only for a constant.
    let mut scene = scene([(grey(1.0), horizontal(0.02, 0.0, true))]);
    scene.environment = Some(sky(vec![[0.7; 3]; 8], 4));
    one_pixel(&scene, &spot_camera(), 1 << 16, 1).channel(0).assert_mean("uniform sky", 0.7, 5e-3);

    let rows = [2.0, 1.5, 0.5, 0.0].map(|value| [[value; 3]; 3]);
    scene.environment = Some(sky(rows.concat(), 3));
    // Rows of pi/4, held beyond the outer centres.
    let radiance = |polar: f64| {
        let v = (polar / PI * 4.0 - 0.5).clamp(0.0, 3.0);
        let row = [2.0, 1.5, 0.5, 0.0, 0.0];
        let upper = v.floor() as usize;
        row[upper] + (row[upper + 1] - row[upper]) * (v - v.floor())
    };
    let integrand = |polar: f64| 2.0 * radiance(polar) * polar.sin() * polar.cos();
    let expected = quadrature::interval(0.0, 0.5 * PI, 64, integrand);
    one_pixel(&scene, &spot_camera(), 1 << 18, 1).channel(0).assert_mean("rows of sky", expected, 2e-3);
}

#[test]
fn n20_sky_looks_where_it_should() {
    // One bright column of eight: the middle of the picture is -z, three quarters +x, the ends +z, and a column's
    // centre is an eighth of a half turn beyond its left edge.
    let bright = |column: usize| (0..8).map(|i| [if i == column { 1.0 } else { 0.0 }; 3]).collect();
    let (sin, cos) = (PI / 8.0).sin_cos();
    for (column, rotation, direction) in [
        (4, 0.0, DVec3::new(sin, 0.0, -cos)),
        (6, 0.0, DVec3::new(cos, 0.0, sin)),
        (0, 0.0, DVec3::new(-sin, 0.0, cos)),
        // A quarter turn counter-clockwise seen from above brings -z to -x.
        (4, 0.5 * PI, DVec3::new(-cos, 0.0, -sin)),
    ] {
        let mut environment = sky(bright(column), 8);
        environment.rotation = rotation as f32;
        let scene = Scene { environment: Some(environment), ..Scene::default() };
        let view = shapes::looking_at("out", DVec3::ZERO, direction, 0.01);
        let mean = one_pixel(&scene, &view, 256, 0).channel(0).mean;
        assert!(
            (mean - 1.0).abs() < 1e-3,
            "column {column}, rotation {rotation}: {mean} towards {direction}"
        );
    }
}

/// In a uniform sky, what neither absorbs nor hides is invisible.
#[test]
fn c12_white_furnace_of_materials() {
    let glass = |roughness| Material {
        metallic: 0.0,
        transmission: 1.0,
        volume: true,
        roughness,
        ..Material::default()
    };
    let thin = Material { volume: false, ..glass(0.0) };
    let mirror = Material { roughness: 0.0, ..Material::default() };
    for (what, material) in [("matte", grey(1.0)), ("mirror", mirror), ("glass", glass(0.0)), ("pane", thin)]
    {
        let mut scene = scene([(material, shapes::icosphere(DVec3::ZERO, 1.0, 2))]);
        scene.environment = Some(sky(vec![[1.0; 3]; 2], 2));
        let view = shapes::looking_at("front", DVec3::Z * 4.0, DVec3::ZERO, 20.0);
        let options = Options {
            resolution: [16, 16],
            samples: 64,
            seed: 3,
            max_scatterings: 200,
            ..Options::default()
        };
        render(&scene, &view, &options).channel(0).assert_mean(what, 1.0, 1e-2);
    }
}

#[test]
fn c12_glass_slab_is_neutral() {
    // A mean over the picture must not know the index, but for what the slab reflects: with white under it and white
    // above it, nothing.
    let mut scene = surfaces::glass_slab(1.5);
    for material in scene.materials.iter_mut().filter(|material| material.is_lambert()) {
        *material = grey(1.0);
    }
    let options =
        Options { resolution: [24, 24], samples: 32, seed: 5, max_scatterings: 400, ..Options::default() };
    render(&scene, &scene.cameras[0], &options).channel(0).assert_mean("glass slab", 1.0, 1e-2);
}

/// Lights found by points drawn on them, weighed against directions drawn from the BSDF, and by the latter alone: every
/// density that the weights hold is in this comparison, and tiles see what a whole picture's mean would hide.
#[test]
fn connections_change_nothing_but_noise() {
    let scene = surfaces::spheres();
    let tiles = |connect: bool| -> Vec<Vec<f64>> {
        let options = |run| Options {
            resolution: [56, 24],
            samples: if connect { 8 } else { 24 },
            seed: if connect { run } else { 100 + run },
            max_scatterings: 16,
            connect,
        };
        let picture = |run| render(&scene, &scene.cameras[0], &options(run)).mean;
        (0..16).map(|run| tile_means(&picture(run), [56, 24], 8)).collect()
    };
    assert_equal_tiles("spheres", &tiles(true), &tiles(false));
}

#[test]
fn absorption_follows_beer_and_lambert() {
    // Straight through a slab of index 1 (no reflection), 0.5 thick, that halves the light every 0.25.
    let medium = Material {
        metallic: 0.0,
        transmission: 1.0,
        volume: true,
        roughness: 0.0,
        ior: 1.0,
        attenuation_distance: 0.25,
        attenuation_color: Vec3::splat(0.5),
        ..Material::default()
    };
    let slab = shapes::cuboid(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.5));
    let mut scene = scene([(medium, slab)]);
    scene.environment = Some(sky(vec![[1.0; 3]; 2], 2));
    let view = shapes::looking_at("through", DVec3::Z * 3.0, DVec3::ZERO, 0.01);
    let mean = one_pixel(&scene, &view, 256, 4).channel(0).mean;
    assert!((mean - 0.25).abs() < 1e-6, "{mean}");
}

#[test]
fn opacity_is_a_probability() {
    // A half transparent lamp before a lit wall; and the shadow of a half transparent sheet.
    let sheet = Material { alpha: 0.25, alpha_mode: halfway::scene::AlphaMode::Blend, ..grey(0.0) };
    let mut scene = scene([(grey(0.5), horizontal(0.02, 0.0, true)), (sheet, horizontal(4.0, 0.01, true))]);
    scene.lights.push(PunctualLight {
        name: String::new(),
        kind: LightKind::Directional,
        intensity: Vec3::splat(PI as f32),
        position: DVec3::ZERO,
        direction: Vec3::NEG_Y,
    });
    let picture = one_pixel(&scene, &spot_camera(), 1 << 16, 1);
    picture.channel(0).assert_mean("through the sheet twice", 0.75 * 0.75 * 0.5, 5e-3);
}
