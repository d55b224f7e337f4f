//! Lights without a surface (`KHR_lights_punctual`).

use glam::{DVec3, Vec3};

/// A punctual light. `intensity` is taken 1:1 per channel: irradiance = intensity / distance^2 for point and spot
/// lights (W/sr or cd), irradiance = intensity for directional ones (W/m^2 or lx).
#[derive(Clone, Debug, PartialEq)]
pub struct PunctualLight {
    pub name: String,
    pub kind: LightKind,
    /// Colour times intensity.
    pub intensity: Vec3,
    /// World position, scene units; unused by directional lights.
    pub position: DVec3,
    /// Unit vector along which the light shines (glTF: local -z); unused by point lights.
    pub direction: Vec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    Point,
    /// Half angles in radians, `inner <= outer`; falls off between them as glTF recommends (square of a linear ramp in
    /// the cosine), however close they are: the sample code of `KHR_lights_punctual` makes no ramp shorter than 0.001.
    Spot {
        inner: f32,
        outer: f32,
    },
    Directional,
}
