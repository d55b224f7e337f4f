//! Cameras.

use glam::{DVec3, Vec3};

/// A pinhole or parallel camera. `right`, `up` and `forward` are orthonormal; the picture's x runs along `right`,
/// its y runs down.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    pub name: String,
    /// World position, scene units.
    pub position: DVec3,
    pub right: Vec3,
    pub up: Vec3,
    pub forward: Vec3,
    pub projection: Projection,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// `yfov`: full vertical field of view in radians; the horizontal one follows from the picture's own aspect.
    Perspective { yfov: f32 },
    /// Half extents in scene units.
    Orthographic { xmag: f32, ymag: f32 },
}
