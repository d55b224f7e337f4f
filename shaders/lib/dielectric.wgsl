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
/// The microfacet that takes `w_from` to `w_to` on the other side.
struct Transmission {
    /// Micronormal, z > 0 on the side of `w_from`, in whose mirrored frame (z up) it is given; 0 if none does.
    h: vec3f,
    /// |d h / d w_to|, solid angles.
    jacobian: f32,
    cos_from: f32,
    cos_to: f32,
}

/// `w_from` with z > 0 and `w_to` with z < 0, both in the frame whose z is on the side of `w_from`.
/// Refraction: Walter et al. 2007, equations 16 and 17. Thin pane: reflection, mirrored through the pane.
fn transmission_facet(s: Surface, w_from: vec3f, w_to: vec3f, eta: f32) -> Transmission {
    var t: Transmission;
    if (s.flags & SURFACE_VOLUME) == 0u {
        let mirrored = vec3f(w_to.xy, -w_to.z);
        t.h = normalize(w_from + mirrored);
        t.cos_from = dot(w_from, t.h);
        t.cos_to = t.cos_from;
        t.jacobian = 1.0 / (4.0 * t.cos_from);
        return t;
    }
    let sum = w_from + eta * w_to;
    let length_sq = dot(sum, sum);
    let h = sum * inverseSqrt(length_sq);
    t.h = select(h, -h, h.z < 0.0);
    t.cos_from = dot(w_from, t.h);
    t.cos_to = -dot(w_to, t.h);
    t.jacobian = eta * eta * t.cos_to / length_sq;
    if t.cos_from <= 0.0 || t.cos_to <= 0.0 {
        t.h = vec3f(0.0);
    }
    return t;
}

/// The rough lobe without its transmittance, from the facet between eye (z > 0) and light (z < 0), in the
/// radiance form: Walter et al. 2007, equation 21, over the squared index on the eye's side.
fn rough_transmission(s: Surface, facet: Transmission, w_eye: vec3f, w_light: vec3f, eta: f32) -> f32 {
    let light_up = vec3f(w_light.xy, -w_light.z);
    return 4.0 * facet.cos_from * facet.jacobian / (eta * eta)
        * ggx_normals(facet.h, s.alpha) * ggx_visibility(w_eye, light_up, s.alpha);
}
#endif
