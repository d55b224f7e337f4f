#import lib/equal_area
#import lib/math

// Warps of uniform numbers u in [0, 1) to directions and points, each beside its density.
// Directions are local: z is the axis. All are finite and have a positive density for every u of `uniform4`.

/// [0, 1) to (-1, 1), the middle of each cell of width 2^-23: exact in f32, and neither -1, 0 nor 1 occurs.
fn centered(u: vec2f) -> vec2f {
    return 2.0 * u - (1.0 - 0x1p-24);
}

/// A direction in the plane by its share of the full turn; the angle stays inside [-pi, pi], where WGSL
/// promises a sine.
fn unit_circle(u: f32) -> vec2f {
    let angle = PI * centered(vec2f(u)).x;
    return vec2f(cos(angle), sin(angle));
}

/// Uniform point of the unit disk as (cos, sin, radius), 0 < radius < 1.
/// Shirley and Chiu, A Low Distortion Map Between Disk and Square, JGT 2(3), 1997.
fn concentric_polar(u: vec2f) -> vec3f {
    let square = centered(u);
    let steep = abs(square.y) > abs(square.x);
    let radius = select(square.x, square.y, steep);
    let turn = 0.25 * PI * select(square.y, square.x, steep) / radius;
    let angle = select(turn, 0.5 * PI - turn, steep);
    return vec3f(cos(angle) * sign(radius), sin(angle) * sign(radius), abs(radius));
}

/// Uniform point of the unit disk.
fn sample_disk(u: vec2f) -> vec2f {
    let polar = concentric_polar(u);
    return polar.xy * polar.z;
}

/// The point of the square, in [0, 1], that `sample_disk` makes this point of.
fn disk_to_square(p: vec2f) -> vec2f {
    let a = abs(p);
    let steep = a.y > a.x;
    let high = max(a.x, a.y);
    let turn = select(2.0 * quarter_turns(min(a.x, a.y) / max(high, 0x1p-100)), 0.0, high == 0.0);
    let square = select(vec2f(1.0, turn), vec2f(turn, 1.0), steep) * length(p);
    return clamp(0.5 + 0.5 * select(square, -square, p < vec2f(0.0)), vec2f(0.0), vec2f(1.0));
}

/// Cosine-weighted direction about +z (Malley). z comes from the radius, so it is never 0.
fn sample_cosine_hemisphere(u: vec2f) -> vec3f {
    let polar = concentric_polar(u);
    return vec3f(polar.xy * polar.z, sqrt((1.0 - polar.z) * (1.0 + polar.z)));
}

fn cosine_hemisphere_pdf_solid(cos_theta: f32) -> f32 {
    return max(cos_theta, 0.0) * INV_PI;
}

/// Uniform direction about +z.
fn sample_uniform_hemisphere(u: vec2f) -> vec3f {
    return vec3f(unit_circle(u.y) * sqrt(u.x * (2.0 - u.x)), 1.0 - u.x);
}

fn uniform_hemisphere_pdf_solid() -> f32 {
    return INV_TWO_PI;
}

/// Uniform direction.
fn sample_uniform_sphere(u: vec2f) -> vec3f {
    return vec3f(unit_circle(u.y) * (2.0 * sqrt(u.x * (1.0 - u.x))), 1.0 - 2.0 * u.x);
}

fn uniform_sphere_pdf_solid() -> f32 {
    return INV_FOUR_PI;
}

/// Uniform direction of the cone about +z. `one_minus_cos` = 1 - cos(half angle) in (0, 2]: a narrow cone's
/// cosine alone would have lost its digits.
fn sample_uniform_cone(u: vec2f, one_minus_cos: f32) -> vec3f {
    let height = u.x * one_minus_cos;
    return vec3f(unit_circle(u.y) * sqrt(height * (2.0 - height)), 1.0 - height);
}

fn uniform_cone_pdf_solid(one_minus_cos: f32) -> f32 {
    return INV_TWO_PI / one_minus_cos;
}

/// Barycentric coordinates of a uniform point of a triangle; they sum to one and none is negative.
/// Heitz, A Low-Distortion Map Between Triangle and Square, 2019.
fn sample_triangle(u: vec2f) -> vec3f {
    let half_u = 0.5 * u;
    let b = select(vec2f(u.x - half_u.y, half_u.y), vec2f(half_u.x, u.y - half_u.x), u.y > u.x);
    return vec3f(b, 1.0 - max(u.x, u.y));
}

/// Density per area from density per solid angle. `cos_light`: cosine at the far point between its normal and
/// the connecting direction, of either sign.
fn pdf_area_from_solid(pdf_solid: f32, cos_light: f32, distance_sq: f32) -> f32 {
    return pdf_solid * abs(cos_light) / distance_sq;
}

/// Density per solid angle from density per area; the caller rejects grazing points (cosine 0) first.
fn pdf_solid_from_area(pdf_area: f32, cos_light: f32, distance_sq: f32) -> f32 {
    return pdf_area * distance_sq / abs(cos_light);
}
