//! Light of the scene in the units of the kernels.

use glam::{DVec3, Vec3};

use crate::accel::UnitSpace;
use crate::math::scale::scale_by_power_of_two;
use crate::scene::{LightKind, PunctualLight};

/// Intensity such that intensity / distance^2 is right for distances of unit space.
pub fn punctual_intensity(light: &PunctualLight, unit: &UnitSpace) -> DVec3 {
    let exponent = match light.kind {
        LightKind::Directional => 0,
        _ => 2 * unit.exponent,
    };
    light.intensity.as_dvec3().to_array().map(|channel| scale_by_power_of_two(channel, exponent)).into()
}

/// A radiance of the scene as kernels see it.
pub fn scaled(radiance: Vec3, exponent: i32) -> Vec3 {
    radiance.to_array().map(|channel| scale_by_power_of_two(f64::from(channel), -exponent) as f32).into()
}
