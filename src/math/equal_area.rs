//! The equal-area map between the sphere of directions and the unit square: equal areas of the square are equal
//! solid angles, so that a density in the square divided by 4 pi is a density per solid angle. Mirrors
//! `lib/equal_area.wgsl` in f64.
//!
//! Clarberg, Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD, JGT 13(3), 2008, in the arrangement of
//! pbrt-v4's `EqualAreaSquareToSphere` and `EqualAreaSphereToSquare` with +y as the axis: +y is the centre of the
//! square, -y its corners, the horizon the diamond through the middles of its edges. Both arguments of the square
//! run in [0, 1]; on its border it wraps around like the octahedral map.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_4, PI};

use glam::{DVec2, DVec3, Vec2Swizzles};

/// The direction's azimuth in [-pi, pi], from +x towards -z, and r: sqrt(1 - |y|), with the sign of y.
/// A caller that needs angles only is spared the sines.
pub fn square_to_azimuth(square: DVec2) -> (f64, f64) {
    let p = 2.0 * square - DVec2::ONE;
    let q = p.abs();
    let signed_distance = 1.0 - (q.x + q.y);
    let r = 1.0 - signed_distance.abs();
    let turn = if r == 0.0 { 0.0 } else { (q.y - q.x) / r };
    let quarter = (turn + 1.0) * FRAC_PI_4;
    let half = if p.x < 0.0 { PI - quarter } else { quarter };
    (half.copysign(p.y), r.copysign(signed_distance))
}

/// Unit direction of a point of the square.
pub fn square_to_sphere(square: DVec2) -> DVec3 {
    let (azimuth, r) = square_to_azimuth(square);
    let horizontal = r.abs() * (2.0 - r * r).sqrt();
    DVec3::new(azimuth.cos() * horizontal, (1.0 - r * r).copysign(r), -azimuth.sin() * horizontal)
}

/// Point of the square of a unit direction.
pub fn sphere_to_square(direction: DVec3) -> DVec2 {
    let (x, z) = (direction.x.abs(), direction.z.abs());
    // 1 - |y| without its cancellation near the poles.
    let r = ((x * x + z * z) / (1.0 + direction.y.abs())).sqrt();
    let steep = x < z;
    let (low, high) = if steep { (x, z) } else { (z, x) };
    let part = if high == 0.0 { 0.0 } else { FRAC_2_PI * (low / high).atan() };
    let along = r * if steep { 1.0 - part } else { part };
    let upper = DVec2::new(r - along, along);
    let p = if direction.y < 0.0 { DVec2::ONE - upper.yx() } else { upper };
    let signed = DVec2::new(p.x.copysign(direction.x), p.y.copysign(-direction.z));
    0.5 * (signed + DVec2::ONE)
}
