//! Rooms: the Cornell box and the door ajar.

use glam::DVec3;

use super::{Stage, shapes};
use crate::scene::Scene;

/// The classic box: 2 x 2 x 2 units, open towards the camera, red wall left, green wall right, a lamp at the
/// ceiling, two turned blocks. The numbers are our own.
pub fn cornell() -> Scene {
    let mut stage = Stage::new("cornell", [128, 128]);
    let white = stage.lambert("white", [0.74, 0.72, 0.68]);
    let red = stage.lambert("red", [0.62, 0.06, 0.05]);
    let green = stage.lambert("green", [0.11, 0.42, 0.08]);
    let lamp = stage.lamp("lamp", [16.0, 11.5, 6.0]);

    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    let (left_back, right_back) = (DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0));
    stage.add("floor", white, shapes::quad(left_back, z, x));
    stage.add("ceiling", white, shapes::quad(left_back + y, x, z));
    stage.add("back wall", white, shapes::quad(left_back, x, y));
    stage.add("left wall", red, shapes::quad(left_back, y, z));
    stage.add("right wall", green, shapes::quad(right_back, z, y));
    let lamp_corner = DVec3::new(-0.26, 1.99, -0.22);
    stage.add("lamp", lamp, shapes::quad(lamp_corner, DVec3::X * 0.52, DVec3::Z * 0.44));

    let block = |center: DVec3, half: DVec3, degrees: f64| {
        shapes::turned(shapes::cuboid(center - half, center + half), center, degrees)
    };
    stage.add("tall block", white, block(DVec3::new(-0.34, 0.61, -0.34), DVec3::new(0.3, 0.61, 0.3), 18.0));
    stage.add("short block", white, block(DVec3::new(0.36, 0.3, 0.36), DVec3::splat(0.3), -17.0));

    stage.camera(shapes::looking_at("front", DVec3::new(0.0, 1.0, 4.4), DVec3::new(0.0, 1.0, 0.0), 33.0));
    stage.scene
}
