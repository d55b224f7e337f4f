//! Warps of uniform numbers u in [0, 1) to directions and points, each beside its density; mirrors
//! `lib/sampling.wgsl`, where the sources are named. Directions are local: z is the axis.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

/// [0, 1) to (-1, 1), the middle of each cell of width 2^-23: exact, and neither -1, 0 nor 1 occurs.
fn centered(u: f32) -> f32 {
    const ONE_MINUS: f32 = 1.0 - f32::EPSILON / 2.0;
    2.0 * u - ONE_MINUS
}

/// A direction in the plane by its share of the full turn.
fn unit_circle(u: f32) -> Vec2 {
    Vec2::from_angle(PI * centered(u))
}

/// Uniform point of the unit disk as (cos, sin, radius), 0 < radius < 1.
fn concentric_polar(u: Vec2) -> Vec3 {
    let (x, y) = (centered(u.x), centered(u.y));
    let (radius, angle) =
        if y.abs() > x.abs() { (y, FRAC_PI_2 - FRAC_PI_4 * x / y) } else { (x, FRAC_PI_4 * y / x) };
    Vec3::new(angle.cos() * radius.signum(), angle.sin() * radius.signum(), radius.abs())
}

/// Uniform point of the unit disk; its density is 1 / pi per area.
pub fn sample_disk(u: Vec2) -> Vec2 {
    let polar = concentric_polar(u);
    polar.truncate() * polar.z
}

/// The point of the square, in [0, 1], that [`sample_disk`] makes this point of, and [`sample_cosine_hemisphere`] this
/// projection of.
pub fn disk_to_square(p: Vec2) -> Vec2 {
    let (radius, a) = (p.length(), p.abs());
    let turn = |minor: f32, major: f32| if major > 0.0 { (minor / major).atan() / FRAC_PI_4 } else { 0.0 };
    let square = match a.y > a.x {
        true => Vec2::new(turn(a.x, a.y), 1.0),
        false => Vec2::new(1.0, turn(a.y, a.x)),
    };
    (0.5 + 0.5 * radius * square.copysign(p)).clamp(Vec2::ZERO, Vec2::ONE)
}

/// Cosine-weighted direction about +z, its z never 0.
pub fn sample_cosine_hemisphere(u: Vec2) -> Vec3 {
    let polar = concentric_polar(u);
    (polar.truncate() * polar.z).extend(((1.0 - polar.z) * (1.0 + polar.z)).sqrt())
}

/// Density per solid angle of [`sample_cosine_hemisphere`].
pub fn cosine_hemisphere_pdf_solid(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Uniform direction about +z.
pub fn sample_uniform_hemisphere(u: Vec2) -> Vec3 {
    (unit_circle(u.y) * (u.x * (2.0 - u.x)).sqrt()).extend(1.0 - u.x)
}

/// Density per solid angle of [`sample_uniform_hemisphere`].
pub fn uniform_hemisphere_pdf_solid() -> f32 {
    0.5 * FRAC_1_PI
}

/// Uniform direction.
pub fn sample_uniform_sphere(u: Vec2) -> Vec3 {
    (unit_circle(u.y) * (2.0 * (u.x * (1.0 - u.x)).sqrt())).extend(1.0 - 2.0 * u.x)
}

/// Density per solid angle of [`sample_uniform_sphere`].
pub fn uniform_sphere_pdf_solid() -> f32 {
    0.25 * FRAC_1_PI
}

/// Uniform direction of the cone about +z. `one_minus_cos` = 1 - cos(half angle) in (0, 2]: a narrow cone's
/// cosine alone would have lost its digits.
pub fn sample_uniform_cone(u: Vec2, one_minus_cos: f32) -> Vec3 {
    let height = u.x * one_minus_cos;
    (unit_circle(u.y) * (height * (2.0 - height)).sqrt()).extend(1.0 - height)
}

/// Density per solid angle of [`sample_uniform_cone`].
pub fn uniform_cone_pdf_solid(one_minus_cos: f32) -> f32 {
    0.5 * FRAC_1_PI / one_minus_cos
}

/// Barycentric coordinates of a uniform point of a triangle; they sum to one and none is negative.
pub fn sample_triangle(u: Vec2) -> Vec3 {
    let (x, y) = if u.y > u.x { (0.5 * u.x, u.y - 0.5 * u.x) } else { (u.x - 0.5 * u.y, 0.5 * u.y) };
    Vec3::new(x, y, 1.0 - u.x.max(u.y))
}

/// Density per area from density per solid angle. `cos_light`: cosine at the far point between its normal and
/// the connecting direction, of either sign.
pub fn pdf_area_from_solid(pdf_solid: f32, cos_light: f32, distance_sq: f32) -> f32 {
    pdf_solid * cos_light.abs() / distance_sq
}

/// Density per solid angle from density per area; the caller rejects grazing points (cosine 0) first.
pub fn pdf_solid_from_area(pdf_area: f32, cos_light: f32, distance_sq: f32) -> f32 {
    pdf_area * distance_sq / cos_light.abs()
}
