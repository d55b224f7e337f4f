//! The light from infinitely far away.

/// A latitude-longitude picture of radiance. Column 0 is the direction -x turning towards +z as u grows
/// (u = 0.5 looks along +x; the convention is the one of `EnvironmentMap::direction`); row 0 is +y.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    pub name: String,
    pub width: u32,
    pub height: u32,
    /// Linear radiance, `width * height` texels, row 0 at the top.
    pub texels: Vec<[f32; 3]>,
    /// Factor on all texels (`--env-scale`).
    pub scale: f32,
    /// Rotation about +y in radians (`--env-rotate`).
    pub rotation: f32,
}
