#if lambert_only
#import lib/bsdf_lambert
#else
#import lib/bsdf_microfacet
#endif
#import lib/math
#import lib/surface

// The BSDF of lib/surface. Contract, for both transport directions:
//
// * Directions are unit, in the local frame (z = shading normal), and point away from the surface.
// * f is meant for radiance: light comes in along w_light and leaves along w_eye. No cosine; refraction has its
//   eta^2. Eye and light tracing evaluate the same function; `from_eye` says which of (w_from, w_to) is w_eye.
// * `bsdf_sample_direction` draws w_to; `bsdf_evaluate` gives f and the density of drawing w_to, which is the same
//   for both transports, roulette not included.
// * Delta lobes stand alone (SURFACE_DELTA): f and density are then 0 everywhere, and samples are complete.
//
// lib/bsdf_lambert and lib/bsdf_microfacet are exchangeable: each has `bsdf_evaluate` and `bsdf_sample_direction`.
//
// Drivers inline every call, and what is inlined often compiles slowly: hence one function for value and density,
// with a single evaluation of each term.

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

/// f, and the density of drawing w_to when arriving from w_from.
struct BsdfValue {
    f: vec3f,
    pdf_solid: f32,
#if bidirectional
    /// Of drawing w_from when arriving from w_to.
    pdf_back_solid: f32,
#endif
}

/// w in the frame whose z is on the side of `reference`: the BSDF is the same from both sides but for eta.
fn facing(w: vec3f, reference: vec3f) -> vec3f {
    return vec3f(w.xy, select(-w.z, w.z, reference.z > 0.0));
}

/// Both on one side of the surface, neither grazing.
fn same_side(a: vec3f, b: vec3f) -> bool {
    return (a.z >= MIN_COS && b.z >= MIN_COS) || (a.z <= -MIN_COS && b.z <= -MIN_COS);
}

/// f alone, with its directions by their roles.
fn bsdf_eval(s: Surface, w_eye: vec3f, w_light: vec3f) -> vec3f {
    return bsdf_evaluate(s, w_eye, w_light, true).f;
}

fn bsdf_pdf_solid(s: Surface, w_from: vec3f, w_to: vec3f) -> f32 {
    return bsdf_evaluate(s, w_from, w_to, true).pdf_solid;
}

/// A direction with its weight. u.xy choose the direction, u.z the lobe.
fn bsdf_sample(s: Surface, w_from: vec3f, u: vec3f, from_eye: bool) -> BsdfSample {
    var sample = bsdf_sample_direction(s, w_from, u, from_eye);
    if sample.pdf_solid == 0.0 || (sample.event & BSDF_DELTA) != 0u {
        return sample;
    }
    let value = bsdf_evaluate(s, w_from, sample.w, from_eye);
    sample.pdf_solid = value.pdf_solid;
    sample.weight = select(vec3f(0.0), value.f * (abs(sample.w.z) / value.pdf_solid), value.pdf_solid > 0.0);
    return sample;
}
