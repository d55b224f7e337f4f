//! Scenes with a closed form: furnaces and facing plates.

use glam::{DVec3, Vec3};

use super::shapes;
use super::stage::Stage;
use crate::scene::{Camera, Material, Projection, Scene};

/// The inside of the cube [-1, 1]^3, every face with albedo `rho` and emitted radiance `le`, camera inside.
/// In any closed enclosure of that kind every pixel is `le / (1 - rho)`; after K bounces at most,
/// `le * (1 - rho^(K+1)) / (1 - rho)`.
pub fn furnace_box(rho: f32, le: f32) -> Scene {
    let mut stage = Stage::new("furnace-box", [32, 32]);
    let wall = furnace_wall(&mut stage, rho, le);
    stage.add("box", wall, shapes::flipped(shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE)));
    // Off the centre and askew, so that no pixel looks along an edge of the mesh.
    let eye = DVec3::new(0.3, -0.2, 0.4);
    stage.camera(shapes::looking_at("inside", eye, DVec3::new(-0.7, 0.5, -0.9), 70.0));
    stage.scene
}

/// [`furnace_box`] with the inside of a unit icosphere of 20 * 4^`subdivisions` flat triangles.
pub fn furnace_sphere(rho: f32, le: f32, subdivisions: u32) -> Scene {
    let mut stage = Stage::new("furnace-sphere", [32, 32]);
    let wall = furnace_wall(&mut stage, rho, le);
    stage.add("sphere", wall, shapes::flipped(shapes::icosphere(DVec3::ZERO, 1.0, subdivisions)));
    let eye = DVec3::new(0.25, -0.15, 0.35);
    stage.camera(shapes::looking_at("inside", eye, DVec3::new(-0.7, 0.5, -0.9), 70.0));
    stage.scene
}

/// Two unit squares facing each other at distance 1, each with radiance 1 and albedo 0.5 on the facing side,
/// black nothing around them. The cameras stand between the plates and look at one of them:
///
/// * `centre` sees a spot of 0.5 mm at its centre. Light of exactly 0, 1, 2, ... 6 bounces there: 1, 0.119728235,
///   0.012200323, 0.001235763, 0.000125144, 0.000012673, 0.000001283; in all 1.133303565.
/// * `average` sees the whole plate, so that the picture's mean is the plate's: 1, 0.099912448, 0.010113269,
///   0.001024130, 0.000103711.
///
/// The numbers come from f64 quadrature of the rendering equation on 24 x 24 and 32 x 32 nodes.
pub fn plates() -> Scene {
    let mut stage = Stage::new("plates", [16, 16]);
    let material = Material { emission: Vec3::ONE, ..Material::lambert("plate", Vec3::splat(0.5)) };
    let plate = stage.material(material);
    let (x, y) = (DVec3::X, DVec3::Y);
    stage.add("far plate", plate, shapes::quad(DVec3::new(-0.5, -0.5, -0.5), x, y));
    stage.add("near plate", plate, shapes::quad(DVec3::new(-0.5, -0.5, 0.5), y, x));
    // 1e-3 rad at distance 0.5: the light varies by 1e-7 over the spot.
    stage.camera(shapes::looking_at("centre", DVec3::ZERO, DVec3::NEG_Z, 1e-3_f32.to_degrees()));
    let (right, up, forward) = shapes::frame_towards(DVec3::NEG_Z);
    stage.camera(Camera {
        name: "average".into(),
        position: DVec3::ZERO,
        right,
        up,
        forward,
        projection: Projection::Orthographic { xmag: 0.5, ymag: 0.5 },
    });
    stage.scene
}

fn furnace_wall(stage: &mut Stage, rho: f32, le: f32) -> u32 {
    stage.material(Material { emission: Vec3::splat(le), ..Material::lambert("wall", Vec3::splat(rho)) })
}
