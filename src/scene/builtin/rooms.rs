//! Rooms: the Cornell box and the door ajar.

use glam::DVec3;

use super::shapes;
use super::stage::Stage;
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

/// Two rooms of 2.4 x 2.4 x 3.2 units, joined only by a door ajar. The lamp hangs in the other room, the camera sees
/// what comes through the gap: hard for paths that start at the eye only.
pub fn door() -> Scene {
    let mut stage = Stage::new("door", [160, 120]);
    let wall = stage.lambert("wall", [0.72, 0.7, 0.66]);
    let floor = stage.lambert("floor", [0.42, 0.27, 0.16]);
    let leaf = stage.lambert("door", [0.55, 0.5, 0.44]);
    let blue = stage.lambert("blue", [0.12, 0.22, 0.5]);
    let lamp = stage.lamp("lamp", [400.0, 340.0, 260.0]);

    let shell = shapes::flipped(shapes::cuboid(DVec3::new(-2.4, 0.0, -1.6), DVec3::new(2.4, 2.4, 1.6)));
    stage.add("shell", wall, shell);
    // A board just above the shell's own floor, so that the floor has a colour.
    let boards = shapes::quad(DVec3::new(-2.4, 0.001, -1.6), DVec3::Z * 3.2, DVec3::X * 4.8);
    stage.add("floor", floor, boards);

    // The partition reaches through the shell: nothing shines past its edges.
    for (name, min, max) in [
        ("partition", [-0.05, -0.05, -1.65], [0.05, 2.45, 0.2]),
        ("partition behind the door", [-0.05, -0.05, 1.1], [0.05, 2.45, 1.65]),
        ("lintel", [-0.05, 2.0, 0.2], [0.05, 2.45, 1.1]),
    ] {
        stage.add(name, wall, shapes::cuboid(min.into(), max.into()));
    }
    let closed = shapes::cuboid(DVec3::new(-0.02, 0.01, 0.21), DVec3::new(0.02, 1.99, 1.09));
    stage.add("door", leaf, shapes::turned(closed, DVec3::new(0.0, 0.0, 0.2), 24.0));

    stage.add("table", leaf, shapes::cuboid(DVec3::new(-1.3, 0.02, -1.2), DVec3::new(-0.4, 0.7, -0.5)));
    stage.add("ball", blue, shapes::smooth_sphere(DVec3::new(-0.85, 0.9, -0.85), 0.2, 4));
    let lamp_corner = DVec3::new(1.3, 2.39, -0.9);
    stage.add("lamp", lamp, shapes::quad(lamp_corner, DVec3::X * 0.5, DVec3::Z * 0.5));

    let eye = DVec3::new(-2.3, 1.5, -0.2);
    stage.camera(shapes::looking_at("at the door", eye, DVec3::new(0.0, 0.95, 0.15), 60.0));
    stage.scene
}
