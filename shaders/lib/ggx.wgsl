#import lib/math
#import lib/sampling

// The isotropic GGX microsurface (Walter et al. 2007) in the local frame, z = surface normal, for
// alpha >= MIN_ALPHA. All directions here have z > 0.

/// Projected length of the microsurface: z sqrt(1 + alpha^2 tan^2), so Smith's lambda is (length / z - 1) / 2.
fn ggx_projected_length(w: vec3f, alpha: f32) -> f32 {
    return sqrt(alpha * alpha * (w.x * w.x + w.y * w.y) + w.z * w.z);
}

/// Density of microfacet normals, per solid angle and projected area. The squared sine comes from x and y and
/// not from 1 - z^2, which has no digits left for narrow lobes.
fn ggx_normals(h: vec3f, alpha: f32) -> f32 {
    let alpha_sq = alpha * alpha;
    let width = h.z * h.z * alpha_sq + (h.x * h.x + h.y * h.y);
    return alpha_sq * INV_PI / (width * width);
}

/// G2 / (4 cos_a cos_b), G2 = 1 / (1 + lambda_a + lambda_b) being Smith's height-correlated masking and
/// shadowing (Heitz 2014, equation 99). Finite for every pair of cosines above zero.
fn ggx_visibility(a: vec3f, b: vec3f, alpha: f32) -> f32 {
    return 0.5 / (ggx_projected_length(a, alpha) * b.z + ggx_projected_length(b, alpha) * a.z);
}

/// A normal visible from `w`, with density `ggx_visible_normals_pdf_solid`.
/// Dupuy and Benyoub, Sampling Visible GGX Normals with Spherical Caps, 2023, listing 3; heights are kept as
/// differences from the poles, which holds their digits at both ends of the cap.
fn ggx_sample_visible_normal(w: vec3f, alpha: f32, u: vec2f) -> vec3f {
    let w_std = normalize(vec3f(alpha * w.xy, w.z));
    let below_top = u.x * (1.0 + w_std.z);
    let radius = sqrt(below_top * (2.0 - below_top));
    let above_w = (1.0 - u.x) * (1.0 + w_std.z);
    return normalize(vec3f(alpha * (radius * unit_circle(u.y) + w_std.xy), above_w));
}

/// Density of the normals visible from `w`: G1(w) max(w.h, 0) D(h) / w.z, in solid angle of h.
fn ggx_visible_normals_pdf_solid(w: vec3f, h: vec3f, alpha: f32) -> f32 {
    return 2.0 * max(dot(w, h), 0.0) * ggx_normals(h, alpha) / (w.z + ggx_projected_length(w, alpha));
}
