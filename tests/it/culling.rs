//! Backs that the camera looks through: all integrators agree on them, and light meets them (C-08).

use glam::DVec3;
use halfway::integrator::{Bdpt, Connections, LightTracing, LvcBpt, Method};
use halfway::scene::builtin::shapes;
use halfway::scene::{Material, Mesh, Scene, SceneFeatures};

use crate::bidirectional::assert_same_as_path;
use crate::judge::{grey, horizontal, lamp, scene};
use crate::shots::{options, render};

/// A wall of side 2 at z = 1, its back to the camera.
fn wall() -> Mesh {
    shapes::flipped(shapes::quad(DVec3::new(-1.0, -1.0, 1.0), DVec3::X * 2.0, DVec3::Y * 2.0))
}

/// A doll's house: floor, back wall with a lamp on it, and a front wall that the camera is behind.
pub fn house(front: Material) -> Scene {
    let back = shapes::quad(DVec3::new(-1.0, -1.0, -1.0), DVec3::X * 2.0, DVec3::Y * 2.0);
    let screen = shapes::quad(DVec3::new(-0.3, -0.3, -0.9), DVec3::X * 0.6, DVec3::Y * 0.6);
    let floor = Mesh { ..horizontal(2.0, -1.0, true) };
    let mut scene = scene([(front, wall()), (grey(0.7), back), (lamp(3.0), screen), (grey(0.5), floor)]);
    scene.name = "house".into();
    scene.cameras.push(shapes::looking_at("street", DVec3::new(0.4, 0.5, 5.0), DVec3::ZERO, 28.0));
    scene
}

fn culled(mut scene: Scene) -> Scene {
    scene.cull_backs();
    scene
}

#[test]
fn the_camera_looks_through_backs_that_light_meets() {
    let centre = |scene: &Scene| {
        let shot = render(scene, options([9, 9], 64));
        shot.picture.rgb[40][0]
    };
    assert!(centre(&house(grey(0.0))) < 0.01, "the wall is shown");
    assert!((centre(&culled(house(grey(0.0)))) - 3.0).abs() < 1e-3, "the lamp behind it");
    let double = Material { double_sided: true, ..grey(0.0) };
    assert!(centre(&culled(house(double))) < 0.01, "a wall with two sides is shown");
    // What light does is the same: without the wall less light comes back to the room than with a white one.
    let mut open = house(grey(0.9));
    open.meshes.remove(0);
    let floor = |scene: &Scene| render(scene, options([24, 24], 128)).part(0, [6, 17], [12, 4]).mean;
    let (lit, without) = (floor(&culled(house(grey(0.9)))), floor(&open));
    assert!(lit > 1.1 * without, "{lit} with the wall, {without} without");
}

#[test]
fn c08_all_integrators_look_through_the_same_backs() {
    let scene = culled(house(grey(0.8)));
    assert_same_as_path(&scene, Method::Light(LightTracing { light_paths: None }), 32);
    assert_same_as_path(&scene, Method::Bdpt(Bdpt { light_tracing: true }), 4);
    let method = LvcBpt { light_paths: Some(600), connections: Connections::even(2), light_tracing: false };
    assert_same_as_path(&scene, Method::LvcBpt(method), 4);
}

#[test]
fn glass_and_scenes_without_backs_are_not_culled() {
    let glass =
        Material { transmission: 1.0, volume: true, metallic: 0.0, roughness: 0.0, ..Material::default() };
    let mut scene = house(glass);
    scene.materials.iter_mut().skip(1).for_each(|material| material.double_sided = true);
    let shown = render(&scene, options([12, 12], 8)).picture.rgb;
    scene.cull_backs();
    assert!(!SceneFeatures::of(&scene).culling);
    assert_eq!(render(&scene, options([12, 12], 8)).picture.rgb, shown);
}

#[test]
fn what_the_camera_looks_through_is_not_pointed_at() {
    let scene = house(grey(0.5));
    let (eye, forward) = (DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z);
    assert_eq!(scene.distance_along(eye, forward), Some(4.0));
    assert_eq!(culled(scene).distance_along(eye, forward), Some(5.9));
}
