//! Scenes with a closed form: furnaces and facing plates.

use glam::{DVec3, Vec3};

use super::{Stage, shapes};
use crate::scene::{Material, Scene};

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

fn furnace_wall(stage: &mut Stage, rho: f32, le: f32) -> u32 {
    stage.material(Material { emission: Vec3::splat(le), ..Material::lambert("wall", Vec3::splat(rho)) })
}
