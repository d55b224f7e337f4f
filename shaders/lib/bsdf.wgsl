#import lib/math
#import lib/sampling
#import lib/surface
#if !lambert_only
#import lib/fresnel
#import lib/ggx
#import lib/ggx_albedo
#endif
#if transmission
#import lib/dielectric
#endif

// The BSDF of lib/surface. Contract, for both transport directions:
//
// * Directions are unit, in the local frame (z = shading normal), and point away from the surface.
// * `bsdf_eval(s, w_eye, w_light)` is f for radiance: light comes in along w_light and leaves along w_eye. No
//   cosine; refraction has its eta^2. Eye and light tracing call the same function with the same roles.
// * `bsdf_sample(s, w_from, u, from_eye)` draws the other direction; `bsdf_pdf_solid(s, w_from, w_to)` is the
//   density of that, the same for both transports, roulette not included.
// * Delta lobes stand alone (SURFACE_DELTA): f and density are then 0 everywhere, and samples are marked.
//
// f = m metal + (1 - m) ((1 - t) (interface + base) + t glass), m = metallic, t = transmission. Metal, interface
// and glass share one GGX microsurface; base is the diffuse layer below the interface.
// Features: lambert_only (no microsurface at all); transmission; rough_transmission (where not all of it is
// delta). Kernels without lambert_only also import bind/ggx_albedo.

const BSDF_DELTA: u32 = 1u;
const BSDF_TRANSMISSION: u32 = 2u;

struct BsdfSample {
    w: vec3f,
    /// 0: absorbed. A probability, not a density, for a delta event.
    pdf_solid: f32,
    /// f |cos| / pdf, the cosine being that of `w`, in the form that suits the direction of transport.
    weight: vec3f,
    /// BSDF_* bits.
    event: u32,
}

#if lambert_only
fn bsdf_eval(s: Surface, w_eye: vec3f, w_light: vec3f) -> vec3f {
    return select(vec3f(0.0), s.base_color * INV_PI, same_side(w_eye, w_light));
}

fn bsdf_pdf_solid(s: Surface, w_from: vec3f, w_to: vec3f) -> f32 {
    return select(0.0, cosine_hemisphere_pdf_solid(abs(w_to.z)), same_side(w_from, w_to));
}

fn bsdf_sample(s: Surface, w_from: vec3f, u: vec3f, from_eye: bool) -> BsdfSample {
    var sample: BsdfSample;
    let w = sample_cosine_hemisphere(u.xy);
    if !same_side(w, facing(w_from, w_from)) || !any(s.base_color > vec3f(0.0)) {
        return sample;
    }
    sample.w = facing(w, w_from);
    sample.pdf_solid = cosine_hemisphere_pdf_solid(w.z);
    sample.weight = s.base_color;
    return sample;
}
#endif

/// w in the frame whose z is on the side of `reference`: the BSDF is the same from both sides but for eta.
fn facing(w: vec3f, reference: vec3f) -> vec3f {
    return vec3f(w.xy, select(-w.z, w.z, reference.z > 0.0));
}

/// Both on one side of the surface, neither grazing.
fn same_side(a: vec3f, b: vec3f) -> bool {
    return (a.z >= MIN_COS && b.z >= MIN_COS) || (a.z <= -MIN_COS && b.z <= -MIN_COS);
}

#if !lambert_only
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

/// What the interface at angle `cos_theta` lets through to the base or back.
fn interface_transmittance(s: Surface, cos_theta: f32) -> f32 {
    return max(1.0 - interface_albedo(s, ggx_albedo(cos_theta, s.alpha)), 0.0);
}

/// Lambert's base below the interface, albedo-scaled: reciprocal, and with the interface it reflects exactly
/// E + rho (1 - E) <= 1. Kelemen and Szirmay-Kalos 2001, equation 9.
fn diffuse_layer(s: Surface, w_eye: vec3f, w_light: vec3f) -> vec3f {
    let through = interface_transmittance(s, w_eye.z) * interface_transmittance(s, w_light.z);
    return s.base_color * (diffuse_share(s) * INV_PI * s.inv_base_average * through);
}

/// All that a microfacet reflects when seen from the side of z at `cos_theta` to its normal.
fn facet_reflectance(s: Surface, cos_theta: f32, z: f32) -> vec3f {
    let f0 = s.metallic * s.base_color + diffuse_share(s) * s.f0;
    let f90 = s.metallic + diffuse_share(s) * s.f90;
    var reflectance = fresnel_schlick(f0, f90, cos_theta);
#if transmission
    let transmitting = (1.0 - s.metallic) * s.transmission;
    if transmitting > 0.0 {
        reflectance += transmitting * dielectric_reflectance(s, cos_theta, z);
    }
#endif
    return reflectance;
}

#if transmission
/// All that a microfacet transmits, tinted once.
fn facet_transmittance(s: Surface, cos_theta: f32, z: f32) -> vec3f {
    let transmitting = (1.0 - s.metallic) * s.transmission;
    return transmitting * (1.0 - dielectric_reflectance(s, cos_theta, z)) * s.base_color;
}
#endif

/// Probability that a facet chosen for `w_from` reflects, not transmits. 0 if it does neither.
fn reflect_select(s: Surface, cos_theta: f32, z: f32) -> f32 {
    let reflectance = max_component(facet_reflectance(s, cos_theta, z));
#if transmission
    let transmittance = max_component(facet_transmittance(s, cos_theta, z));
    return fraction(reflectance, transmittance);
#else
    return fraction(reflectance, 0.0);
#endif
}

/// Probability of the diffuse layer when arriving along w (z > 0): by albedos.
fn diffuse_select(s: Surface, w: vec3f) -> f32 {
    let ab = ggx_albedo(w.z, s.alpha);
    let share = diffuse_share(s);
    let interface_part = interface_albedo(s, ab);
    let diffuse = share * max_component(s.base_color) * max(1.0 - interface_part, 0.0);
    let metal = s.metallic * (max_component(s.base_color) * ab.x + ab.y);
    let facets = metal + share * interface_part + (1.0 - s.metallic) * s.transmission;
    return fraction(diffuse, facets);
}

fn bsdf_eval(s: Surface, w_eye: vec3f, w_light: vec3f) -> vec3f {
    if (s.flags & SURFACE_DELTA) != 0u {
        return vec3f(0.0);
    }
    let eye = facing(w_eye, w_eye);
    let light = facing(w_light, w_eye);
    if same_side(eye, light) {
        // Half the sum's length is the cosine of either to h, and the same whichever comes first.
        let sum = eye + light;
        let h = normalize(sum);
        return diffuse_layer(s, eye, light)
            + facet_reflectance(s, 0.5 * dot(sum, h), w_eye.z)
            * (ggx_normals(h, s.alpha) * ggx_visibility(eye, light, s.alpha));
    }
#if rough_transmission
    if transmits(s, eye, light) {
        let n = refractive_indices(s, w_eye.z);
        let facet = transmission_facet(s, eye, light, n);
        if facet.h.z > 0.0 {
            // From outside, where Fresnel's equations are well conditioned.
            let outside = select(facet.cos_far, facet.cos_near, w_eye.z > 0.0);
            return facet_transmittance(s, outside, 1.0) * rough_transmission(s, facet, eye, light, n);
        }
    }
#endif
    return vec3f(0.0);
}

fn bsdf_pdf_solid(s: Surface, w_from: vec3f, w_to: vec3f) -> f32 {
    if (s.flags & SURFACE_DELTA) != 0u {
        return 0.0;
    }
    let w_in = facing(w_from, w_from);
    let w_out = facing(w_to, w_from);
    if same_side(w_in, w_out) {
        let sum = w_in + w_out;
        let h = normalize(sum);
        let cos_theta = 0.5 * dot(sum, h);
        let diffuse = diffuse_select(s, w_in);
        return diffuse * cosine_hemisphere_pdf_solid(w_out.z)
            + (1.0 - diffuse) * reflect_select(s, cos_theta, w_from.z)
            * ggx_visible_normals_pdf_solid(w_in, h, s.alpha) / (4.0 * cos_theta);
    }
#if rough_transmission
    if transmits(s, w_in, w_out) {
        let n = refractive_indices(s, w_from.z);
        let facet = transmission_facet(s, w_in, w_out, n);
        if facet.h.z > 0.0 {
            return (1.0 - diffuse_select(s, w_in)) * (1.0 - reflect_select(s, facet.cos_near, w_from.z))
                * ggx_visible_normals_pdf_solid(w_in, facet.h, s.alpha) * transmission_jacobian(facet, n);
        }
    }
#endif
    return 0.0;
}

#if rough_transmission
/// Some light passes from a (z > 0) to b on the other side, neither grazing.
fn transmits(s: Surface, a: vec3f, b: vec3f) -> bool {
    return (1.0 - s.metallic) * s.transmission > 0.0 && a.z >= MIN_COS && b.z <= -MIN_COS;
}
#endif

/// u.xy choose the direction, u.z the lobe.
fn bsdf_sample(s: Surface, w_from: vec3f, u: vec3f, from_eye: bool) -> BsdfSample {
    var sample: BsdfSample;
    let w_in = facing(w_from, w_from);
    if w_in.z < MIN_COS {
        return sample;
    }
    if (s.flags & SURFACE_DELTA) != 0u {
        return sample_delta(s, w_from, u.z, from_eye);
    }
    let diffuse = diffuse_select(s, w_in);
    var w: vec3f;
    if u.z < diffuse {
        w = sample_cosine_hemisphere(u.xy);
    } else {
        let h = ggx_sample_visible_normal(w_in, s.alpha, u.xy);
        let cos_theta = dot(w_in, h);
        let reflects = u.z - diffuse < (1.0 - diffuse) * reflect_select(s, cos_theta, w_from.z);
        if reflects {
            w = 2.0 * cos_theta * h - w_in;
        }
#if rough_transmission
        if !reflects {
            w = transmitted(s, w_in, h, relative_eta(s, w_from.z));
            sample.event = BSDF_TRANSMISSION;
        }
#endif
        // Some facets send light below the horizon; it is lost, as the single-scattering model has it.
        if w.z == 0.0 || (w.z > 0.0) != reflects {
            return sample;
        }
    }
    w = facing(normalize(w), w_from);
    let pdf_solid = bsdf_pdf_solid(s, w_from, w);
    if pdf_solid > 0.0 {
        let w_eye = select(w, w_from, from_eye);
        let w_light = select(w_from, w, from_eye);
        sample.w = w;
        sample.pdf_solid = pdf_solid;
        sample.weight = bsdf_eval(s, w_eye, w_light) * (abs(w.z) / pdf_solid);
    }
    return sample;
}

#if rough_transmission
/// Where the facet `h` sends what it transmits of `w_in`, z > 0; vec3f(0) if nowhere.
fn transmitted(s: Surface, w_in: vec3f, h: vec3f, eta: f32) -> vec3f {
    if (s.flags & SURFACE_VOLUME) != 0u {
        return refracted(w_in, h, eta);
    }
    let mirrored = 2.0 * dot(w_in, h) * h - w_in;
    return vec3f(mirrored.xy, -mirrored.z);
}
#endif

/// Mirror and smooth glass: one direction or two, with probabilities by reflectance.
fn sample_delta(s: Surface, w_from: vec3f, u_select: f32, from_eye: bool) -> BsdfSample {
    var sample: BsdfSample;
    let w_in = facing(w_from, w_from);
    let reflect = reflect_select(s, w_in.z, w_from.z);
    if u_select < reflect {
        sample.w = vec3f(-w_from.xy, w_from.z);
        sample.pdf_solid = reflect;
        sample.weight = facet_reflectance(s, w_in.z, w_from.z) / reflect;
        sample.event = BSDF_DELTA;
        return sample;
    }
#if transmission
    let eta = relative_eta(s, w_from.z);
    let w = refracted(w_in, vec3f(0.0, 0.0, 1.0), eta);
    let transmittance = facet_transmittance(s, w_in.z, w_from.z);
    if w.z < 0.0 && any(transmittance > vec3f(0.0)) {
        // Radiance is squeezed by refraction, power is not (Veach 1997, section 5.2).
        let squeeze = select(1.0, 1.0 / (eta * eta), from_eye);
        sample.w = facing(normalize(w), w_from);
        sample.pdf_solid = 1.0 - reflect;
        sample.weight = transmittance * (squeeze / (1.0 - reflect));
        sample.event = BSDF_DELTA | BSDF_TRANSMISSION;
    }
#endif
    return sample;
}
#endif
