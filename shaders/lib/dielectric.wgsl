#import lib/fresnel
#import lib/ggx
#import lib/surface

// Specular transmission: how much passes, where to, and the rough lobe. Directions are local and unit.
// `relative_eta` = n on the far side / n on the side of a direction.

/// n_far / n_near for a direction with this z; 1 for a thin pane, whose two refractions cancel.
fn relative_eta(s: Surface, z: f32) -> f32 {
    if (s.flags & SURFACE_VOLUME) == 0u {
        return 1.0;
    }
    return select(1.0 / s.eta, s.eta, z > 0.0);
}

/// Reflectance of the transmitting interface at `cos_theta` to the (micro)normal, on the side of z.
fn dielectric_reflectance(s: Surface, cos_theta: f32, z: f32) -> f32 {
    if (s.flags & SURFACE_VOLUME) == 0u {
        return fresnel_thin(cos_theta, s.eta);
    }
    return fresnel_dielectric(cos_theta, relative_eta(s, z));
}

/// `w` refracted at the (micro)normal `h` on its side, or vec3f(0) under total internal reflection. Exactly -w
/// at eta = 1.
fn refracted(w: vec3f, h: vec3f, eta: f32) -> vec3f {
    let cos_theta = dot(w, h);
    let g = refracted_cos(cos_theta, eta);
    if g < 0.0 {
        return vec3f(0.0);
    }
    return ((cos_theta - g) * h - w) / eta;
}

#if rough_transmission
/// Indices of refraction (near, far) of a direction with this z.
fn refractive_indices(s: Surface, z: f32) -> vec2f {
    if (s.flags & SURFACE_VOLUME) == 0u {
        return vec2f(1.0);
    }
    return select(vec2f(s.eta, 1.0), vec2f(1.0, s.eta), z > 0.0);
}

/// The microfacet that takes a direction to another one on the other side.
struct Transmission {
    /// Micronormal; z = 0 if no facet does.
    h: vec3f,
    /// Squared length of n_near w_near + n_far w_far, whose direction h is.
    length_sq: f32,
    /// Cosines of the two directions to h.
    cos_near: f32,
    cos_far: f32,
}

/// `near` has z > 0, `far` z < 0, n their indices (near, far). Refraction: Walter et al. 2007, equation 16. A thin
/// pane reflects and mirrors through itself.
fn transmission_facet(s: Surface, near: vec3f, far: vec3f, n: vec2f) -> Transmission {
    var facet: Transmission;
    let towards = select(vec3f(far.xy, -far.z), far, (s.flags & SURFACE_VOLUME) != 0u);
    let sum = n.x * near + n.y * towards;
    facet.length_sq = dot(sum, sum);
    facet.h = sum * inverseSqrt(facet.length_sq);
    facet.h = select(facet.h, -facet.h, facet.h.z < 0.0);
    facet.cos_near = dot(near, facet.h);
    facet.cos_far = abs(dot(towards, facet.h));
    if facet.cos_near <= 0.0 || (dot(towards, facet.h) > 0.0) != (towards.z > 0.0) {
        facet.h.z = 0.0;
    }
    return facet;
}

/// |d h / d w_far|, solid angles: Walter et al. 2007, equation 17; of reflection for a pane.
fn transmission_jacobian(facet: Transmission, n: vec2f) -> f32 {
    return n.y * n.y * facet.cos_far / facet.length_sq;
}

/// The rough lobe is transmittance D G2 / (4 cos cos) times this, in the radiance form: Walter et al. 2007, equation
/// 21. `n_eye` is the index on the eye's side.
fn transmission_factor(facet: Transmission, n_eye: f32) -> f32 {
    return 4.0 * n_eye * n_eye * facet.cos_near * facet.cos_far / facet.length_sq;
}
#endif
