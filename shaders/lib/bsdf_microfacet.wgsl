#import lib/fresnel
#import lib/ggx
#import lib/ggx_albedo
#import lib/math
#import lib/sampling
#import lib/surface
#if transmission
#import lib/dielectric
#endif

// The BSDF of all surfaces, whose contract is in lib/bsdf:
//
//   f = m metal + (1 - m) ((1 - t) (interface + base) + t glass), m = metallic, t = transmission
//
// Metal, interface and glass share one GGX microsurface; base is the diffuse layer below the interface.
// Features: transmission; rough_transmission (where not all of it is delta). Kernels also import bind/ggx_albedo.

/// a / (a + b), 0 where both are.
fn fraction(a: f32, b: f32) -> f32 {
    if a > 0.0 {
        return a / (a + b);
    }
    return 0.0;
}

/// Share of the diffuse layer.
fn diffuse_share(s: Surface) -> f32 {
    return (1.0 - s.metallic) * (1.0 - s.transmission);
}

/// Lambert's base below the interface, albedo-scaled by the table's (a, b) for both directions: reciprocal, and with
/// the interface it reflects exactly E + rho (1 - E) <= 1. Kelemen and Szirmay-Kalos 2001, equation 9.
fn diffuse_layer(s: Surface, ab_from: vec2f, ab_to: vec2f) -> vec3f {
    let through = max(1.0 - interface_albedo(s, ab_from), 0.0) * max(1.0 - interface_albedo(s, ab_to), 0.0);
    return s.base_color * (diffuse_share(s) * INV_PI * s.inv_base_average * through);
}

/// Probability of the diffuse layer when arriving from where the table has `ab`: by albedos.
fn diffuse_select(s: Surface, ab: vec2f) -> f32 {
    let share = diffuse_share(s);
    let interface_part = interface_albedo(s, ab);
    let diffuse = share * max_component(s.base_color) * max(1.0 - interface_part, 0.0);
    let metal = s.metallic * (max_component(s.base_color) * ab.x + ab.y);
    let facets = metal + share * interface_part + (1.0 - s.metallic) * s.transmission;
    return fraction(diffuse, facets);
}

/// What a microfacet does with light at a cosine to its normal.
struct Facet {
    reflectance: vec3f,
    /// Tinted once.
    transmittance: vec3f,
    /// Probability of reflection, not transmission; 0 if it does neither.
    reflect_select: f32,
}

/// `cos_near`: on the side the light is on. `cos_glass`: the same, or that on the far side; z tells the side it is on.
fn facet(s: Surface, cos_near: f32, cos_glass: f32, z: f32) -> Facet {
    let f0 = s.metallic * s.base_color + diffuse_share(s) * s.f0;
    let f90 = s.metallic + diffuse_share(s) * s.f90;
    var result = Facet(fresnel_schlick(f0, f90, cos_near), vec3f(0.0), 0.0);
#if transmission
    let transmitting = (1.0 - s.metallic) * s.transmission;
    if transmitting > 0.0 {
        let reflectance = dielectric_reflectance(s, cos_glass, z);
        result.reflectance += transmitting * reflectance;
        result.transmittance = transmitting * (1.0 - reflectance) * s.base_color;
    }
#endif
    result.reflect_select = fraction(max_component(result.reflectance), max_component(result.transmittance));
    return result;
}

fn bsdf_evaluate(s: Surface, w_from: vec3f, w_to: vec3f, from_eye: bool) -> BsdfValue {
    var value: BsdfValue;
    let near = facing(w_from, w_from);
    let far = facing(w_to, w_from);
    let reflects = same_side(near, far);
#if rough_transmission
    let crosses = (1.0 - s.metallic) * s.transmission > 0.0 && near.z >= MIN_COS && far.z <= -MIN_COS;
#else
    let crosses = false;
#endif
    if (s.flags & SURFACE_DELTA) != 0u || !(reflects || crosses) {
        return value;
    }
    // The microfacet that takes one direction to the other: its normal, and the cosine of `near` to it.
    let sum = near + far;
    var h = normalize(sum);
    var cos_near = 0.5 * dot(sum, h);
    var cos_glass = cos_near;
    var side = w_from.z;
#if rough_transmission
    let n = refractive_indices(s, w_from.z);
    var crossing: Transmission;
    if crosses {
        crossing = transmission_facet(s, near, far, n);
        h = crossing.h;
        cos_near = crossing.cos_near;
        // Of what is known to pass, Fresnel's equations are well conditioned from outside; from inside they end at
        // the critical angle.
        cos_glass = select(crossing.cos_far, cos_near, w_from.z > 0.0);
        side = 1.0;
        if h.z <= 0.0 {
            return value;
        }
    }
#endif
    let ab = lobe_albedo(s, near.z);
    let diffuse = diffuse_select(s, ab);
    let split = facet(s, cos_near, cos_glass, side);
    let normals = ggx_normals(h, s.alpha);
    let far_up = vec3f(far.xy, abs(far.z));
    let ab_far = lobe_albedo(s, far_up.z);
    let lobe = normals * ggx_visibility(near, far_up, s.alpha);
    let facet_pdf = (1.0 - diffuse) * ggx_visible_normals_pdf_solid(near, h, s.alpha);
#if bidirectional
    let diffuse_back = diffuse_select(s, ab_far);
    // Mirrored onto the side of the micronormal; what a pane lets through is mirrored back.
    let far_facet = select(far_up, -far, crosses && (s.flags & SURFACE_VOLUME) != 0u);
    let facet_back_pdf = (1.0 - diffuse_back) * ggx_visible_normals_pdf_solid(far_facet, h, s.alpha);
#endif
    if reflects {
        value.f = diffuse_layer(s, ab, ab_far) + split.reflectance * lobe;
        value.pdf_solid = diffuse * cosine_hemisphere_pdf_solid(far.z)
            + facet_pdf * split.reflect_select / (4.0 * cos_near);
#if bidirectional
        value.pdf_back_solid = diffuse_back * cosine_hemisphere_pdf_solid(near.z)
            + facet_back_pdf * split.reflect_select / (4.0 * cos_near);
#endif
    }
#if rough_transmission
    if crosses {
        let n_eye = select(n.y, n.x, from_eye);
        value.f = split.transmittance * (lobe * transmission_factor(crossing, n_eye));
        value.pdf_solid = facet_pdf * (1.0 - split.reflect_select) * transmission_jacobian(crossing, n);
#if bidirectional
        let split_back = facet(s, crossing.cos_far, cos_glass, side);
        let jacobian_back = n.x * n.x * crossing.cos_near / crossing.length_sq;
        value.pdf_back_solid = facet_back_pdf * (1.0 - split_back.reflect_select) * jacobian_back;
#endif
    }
#endif
    return value;
}

/// As `bsdf_sample`; but where the event is not delta, the weight and any density but 0 are left to `bsdf_evaluate`.
fn bsdf_sample_direction(s: Surface, w_from: vec3f, u: vec3f, from_eye: bool) -> BsdfSample {
    var sample: BsdfSample;
    let near = facing(w_from, w_from);
    if near.z < MIN_COS {
        return sample;
    }
    let delta = (s.flags & SURFACE_DELTA) != 0u;
    var diffuse = 0.0;
    var h = vec3f(0.0, 0.0, 1.0);
    if !delta {
        diffuse = diffuse_select(s, lobe_albedo(s, near.z));
        if u.z < diffuse {
            sample.w = facing(sample_cosine_hemisphere(u.xy), w_from);
            sample.pdf_solid = 1.0;
            return sample;
        }
        h = ggx_sample_visible_normal(near, s.alpha, u.xy);
    }
    let cos_near = dot(near, h);
    let split = facet(s, cos_near, cos_near, w_from.z);
    let reflects = u.z - diffuse < (1.0 - diffuse) * split.reflect_select;
    var w = 2.0 * cos_near * h - near;
    var chance = split.reflect_select;
    var weight = split.reflectance;
#if transmission
    if !reflects {
        let eta = relative_eta(s, w_from.z);
        sample.event = BSDF_TRANSMISSION;
        chance = 1.0 - split.reflect_select;
        // Radiance is squeezed by refraction, power is not (Veach 1997, section 5.2).
        weight = split.transmittance * select(1.0, 1.0 / (eta * eta), from_eye);
        if delta || (s.flags & SURFACE_VOLUME) != 0u {
            w = refracted(near, h, eta);
        } else {
            w = vec3f(w.xy, -w.z);
        }
    }
#endif
    // Some facets send light to the wrong side; it is lost, as the single-scattering model has it.
    if w.z == 0.0 || (w.z > 0.0) != reflects || !any(weight > vec3f(0.0)) {
        return sample;
    }
    sample.w = facing(normalize(w), w_from);
    sample.pdf_solid = chance;
    sample.weight = weight / chance;
    sample.event |= select(0u, BSDF_DELTA, delta);
    return sample;
}
