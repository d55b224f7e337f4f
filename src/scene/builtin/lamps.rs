//! Scenes about lights: very many, and one of every kind.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::shapes;
use super::stage::Stage;
use crate::scene::{LightKind, PunctualLight, Scene};

/// `count` square lamps of 1 cm over a floor of 4 x 4 units. Their powers run from 10^`exponents[0]` up to
/// 10^`exponents[1]`, evenly in the exponent, in an order that has nothing to do with their places.
pub fn many_lights(count: u32, exponents: [f64; 2]) -> Scene {
    let mut stage = Stage::new("many-lights", [64, 64]);
    let floor = stage.lambert("floor", [0.6, 0.6, 0.6]);
    let corner = DVec3::new(-2.0, 0.0, -2.0);
    stage.add("floor", floor, shapes::quad(corner, DVec3::Z * 4.0, DVec3::X * 4.0));

    let columns = f64::from(count).sqrt().ceil() as u32;
    let spacing = 4.0 / f64::from(columns);
    let side = 0.01;
    // Multiples of the golden ratio modulo 1 are even and never in step with the rows.
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    for i in 0..count {
        let place = |k: u32| (f64::from(k) + 0.5) * spacing - side / 2.0;
        let exponent = exponents[0] + (exponents[1] - exponents[0]) * (f64::from(i) * golden).fract();
        // A flat Lambert emitter: power = pi * area * radiance.
        let radiance = 10.0_f64.powf(exponent) as f32 / (PI * (side * side) as f32);
        let lamp = stage.lamp(&format!("lamp {i}"), [radiance; 3]);
        let at = corner + DVec3::new(place(i % columns), 0.2, place(i / columns));
        stage.add(&format!("lamp {i}"), lamp, shapes::quad(at, DVec3::X * side, DVec3::Z * side));
    }
    stage.camera(shapes::looking_at("above", DVec3::new(0.0, 3.6, 3.0), DVec3::ZERO, 50.0));
    stage.scene
}

/// A ball and a block lit by all that can light: a lamp with a surface, a point, a spot and a directional light, and
/// the sky; each a colour of its own, of comparable strength.
pub fn three_lights() -> Scene {
    let mut stage = Stage::new("three-lights", [96, 64]);
    let white = stage.lambert("white", [0.7, 0.7, 0.7]);
    let lamp = stage.lamp("lamp", [9.0, 6.5, 3.0]);
    let corner = DVec3::new(-3.0, 0.0, -3.0);
    stage.add("floor", white, shapes::quad(corner, DVec3::Z * 6.0, DVec3::X * 6.0));
    stage.add("ball", white, shapes::smooth_sphere(DVec3::new(-0.7, 0.5, 0.0), 0.5, 4));
    let block = shapes::cuboid(DVec3::new(0.3, 0.001, -0.4), DVec3::new(1.0, 0.9, 0.3));
    stage.add("block", white, shapes::turned(block, DVec3::new(0.65, 0.0, 0.0), 30.0));
    let lamp_corner = DVec3::new(-0.3, 2.4, -0.3);
    stage.add("lamp", lamp, shapes::quad(lamp_corner, DVec3::X * 0.6, DVec3::Z * 0.6));

    for (name, kind, intensity, position, direction) in [
        ("point", LightKind::Point, [0.3, 1.2, 0.4], [1.8, 1.2, 1.2], [0.0, 0.0, -1.0]),
        (
            "spot",
            LightKind::Spot { inner: 0.2, outer: 0.5 },
            [5.0, 0.8, 0.8],
            [-2.0, 2.0, 1.5],
            [1.3, -1.5, -1.5],
        ),
        ("sun", LightKind::Directional, [0.2, 0.3, 0.9], [0.0, 0.0, 0.0], [-1.0, -1.5, -0.6]),
    ] {
        stage.scene.lights.push(PunctualLight {
            name: name.into(),
            kind,
            intensity: intensity.into(),
            position: position.into(),
            direction: Vec3::from(direction).normalize(),
        });
    }
    stage.sky([0.12, 0.16, 0.24], [0.02, 0.02, 0.02]);
    stage.camera(shapes::looking_at("front", DVec3::new(0.0, 1.6, 4.2), DVec3::new(0.0, 0.5, 0.0), 40.0));
    stage.scene
}
