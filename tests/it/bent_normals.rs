//! Meshes of few triangles with smooth normals: they lose no light (C-01), and all integrators see them alike (C-08, C-11).

use glam::{DVec3, Vec3};
use halfway::integrator::{Bdpt, Connections, LvcBpt, METHODS, Method};
use halfway::render::RenderOptions;
use halfway::scene::builtin::shapes;
use halfway::scene::{Environment, Material, Mesh, Scene};
use serde_json::json;

use crate::bidirectional::{assert_same_as_path, mean, renders};
use crate::gltf_file::GltfFile;
use crate::judge::{grey, horizontal, lamp, scene};
use crate::shots::{options, render};
use crate::stats::Moments;

const METAL: Vec3 = Vec3::ONE;

/// A cube about the origin whose corners have one normal each, along the diagonal.
fn smooth_cube(half: f64) -> Mesh {
    let corner =
        |i: usize| DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(|bit| if bit == 1 { half } else { -half }));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        normals: Some((0..8).map(|i| corner(i).normalize().as_vec3()).collect()),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

fn metal(roughness: f32) -> Material {
    Material { base_color: METAL, metallic: 1.0, roughness, ..Material::default() }
}

fn white_sky() -> Environment {
    Environment {
        name: "white".into(),
        width: 8,
        height: 4,
        texels: vec![[1.0; 3]; 32],
        scale: 1.0,
        rotation: 0.0,
    }
}

fn corner_view() -> halfway::scene::Camera {
    shapes::looking_at("corner", DVec3::new(2.0, 1.6, 3.0), DVec3::ZERO, 32.0)
}

fn furnace(material: Material) -> Scene {
    let mut scene = scene([(material, smooth_cube(0.6))]);
    scene.name = "smooth cube".into();
    scene.environment = Some(white_sky());
    scene.cameras.push(corner_view());
    scene
}

#[test]
fn c01_a_smooth_cube_is_as_bright_as_its_surroundings() {
    let matte = Material { specular: 0.0, ..grey(1.0) };
    for (name, material) in [("mirror", metal(0.0)), ("metal", metal(0.2)), ("matte", matte)] {
        let shot = render(&furnace(material), options([24, 24], 64));
        let darkest = shot.picture.rgb.iter().map(|rgb| rgb[0]).fold(f32::INFINITY, f32::min);
        let found = shot.channel(0);
        println!("{name}: mean {:.4} +- {:.4}, darkest pixel {darkest:.3}", found.mean, found.error);
        // Single scattering loses a tenth at grazing angles where roughness is 0.2, normals bent or not.
        let lost = if name == "metal" { 0.015 } else { 0.0 };
        assert!((found.mean - 1.0).abs() < 5.0 * found.error + lost, "{name}: {found:?}");
        assert!(darkest > 0.8, "{name}: {darkest}");
    }
}

#[test]
fn c01_every_integrator_keeps_the_light_of_bent_normals() {
    let scene = furnace(Material { specular: 0.0, ..grey(1.0) });
    // Light tracing alone is noisy under a sky: the test below has it as a part. Records choose among connections, no more.
    for method in METHODS.into_iter().filter(|method| !["light", "pcbpt", "risbpt"].contains(&method.name)) {
        let options = RenderOptions { method: (method.make)(&Default::default()), ..options([12, 12], 16) };
        let runs: Moments = renders(&scene, &options, 0..8).iter().map(|picture| mean(picture)).collect();
        runs.assert_mean(method.name, 1.0, 2e-2);
    }
}

/// Balls of twenty triangles on a floor whose normals lean: metal of a roughness, plastic, and glass that is frosted where
/// the metal is no mirror.
pub fn low_poly(roughness: f32) -> Scene {
    let ball = |x: f64| shapes::smooth_sphere(DVec3::new(x, 0.45, 0.0), 0.45, 0);
    let leaning = Mesh { normals: Some(vec![Vec3::new(0.6, 0.8, 0.0); 4]), ..horizontal(4.0, 0.0, true) };
    let plastic = Material { metallic: 0.0, roughness: 0.4, ..Material::default() };
    let frost = if roughness > 0.0 { 0.5 } else { 0.0 };
    let glass = Material { roughness: frost, transmission: 1.0, volume: true, ..plastic.clone() };
    let mut scene = scene([
        (metal(roughness), ball(-1.0)),
        (plastic, ball(0.0)),
        (glass, ball(1.0)),
        (grey(0.6), leaning),
        (lamp(6.0), horizontal(1.5, 2.0, false)),
    ]);
    scene.name = format!("low poly, roughness {roughness}");
    scene.cameras.push(shapes::looking_at(
        "front",
        DVec3::new(0.3, 1.2, 3.4),
        DVec3::new(0.0, 0.3, 0.0),
        40.0,
    ));
    scene
}

#[test]
fn c11_low_poly_balls_agree_with_path() {
    let scene = low_poly(0.3);
    assert_same_as_path(&scene, Method::Bdpt(Bdpt { light_tracing: true }), 8);
    // Mirrors and smooth glass, whose events have weights of their own.
    let method = LvcBpt { light_paths: Some(1200), connections: Connections::even(2), light_tracing: true };
    assert_same_as_path(&low_poly(0.0), Method::LvcBpt(method), 8);
}

/// Two triangles of a strip with their four normals.
fn strip(normals: [[f32; 3]; 4]) -> GltfFile {
    let mut file = GltfFile::empty();
    let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let positions = file.floats("VEC3", &corners);
    let normals = file.floats("VEC3", normals.as_flattened());
    let attributes = json!({"POSITION": positions, "NORMAL": normals});
    file.push("meshes", json!({"primitives": [{"mode": 5, "attributes": attributes}]}));
    file.push("nodes", json!({"mesh": 0}));
    file
}

#[test]
fn normals_are_turned_to_the_side_of_their_triangles() {
    let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.6, -0.8]);
    let right = strip([up; 4]).scene();
    assert!(right.warnings.is_empty(), "{:?}", right.warnings);

    let all = strip([down; 4]).scene();
    assert_eq!(all.meshes[0].normals.as_ref().unwrap(), &[Vec3::new(0.0, -0.6, 0.8); 4]);
    assert_eq!(all.warnings.len(), 1);
    let warning = all.warnings[0].to_string();
    assert!(warning.contains("meshes[0].primitives[0]") && warning.contains("2 of 2 triangles"), "{warning}");

    // A triangle with one good normal keeps all of its own; what the other one shares with it is copied.
    let one = strip([down, down, down, up]).scene();
    assert!(one.warnings[0].to_string().contains("1 of 2 triangles"), "{}", one.warnings[0]);
    let mesh = &one.meshes[0];
    let of = |triangle: usize| mesh.triangles[triangle].map(|v| mesh.normals.as_ref().unwrap()[v as usize].z);
    assert!(of(0).iter().all(|&z| z > 0.0), "{:?}", of(0));
    assert_eq!(of(1).iter().filter(|&&z| z > 0.0).count(), 1, "{:?}", of(1));
}
