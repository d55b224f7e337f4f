#import lib/bsdf
#import lib/frame

// The BSDF in world space, and the one place that knows shading normals from geometric ones.
//
// Veach 1997, section 5.3: the BSDF that a bent normal makes is f |w_light.ns| / |w_light.ng|, which is not
// symmetric. Everything here is that function, so callers use *geometric* cosines throughout, whichever way
// they trace; its samples carry the right weight for both. A direction that is on different sides of the shading
// and the geometric plane gets 0: no light leaks through.

struct ShadingFrame {
    shading: Frame,
    geometric_normal: vec3f,
}

/// Both normals unit, and on the same side of the surface (the outer one, where it bounds a volume).
fn shading_frame(shading_normal: vec3f, geometric_normal: vec3f) -> ShadingFrame {
    return ShadingFrame(frame_from_normal(shading_normal), geometric_normal);
}

/// Both planes have the direction on the same side, and it grazes neither.
fn sides_agree(cos_shading: f32, cos_geometric: f32) -> bool {
    return min(abs(cos_shading), abs(cos_geometric)) >= MIN_COS && (cos_shading > 0.0) == (cos_geometric > 0.0);
}

/// f |w_light.ns| / |w_light.ng|, to be multiplied by geometric cosines, and the density of `shading_sample`. With
/// `from_eye`, world_from leads to the eye and world_to to the light.
fn shading_evaluate(
    s: Surface, frame: ShadingFrame, world_from: vec3f, world_to: vec3f, from_eye: bool,
) -> BsdfValue {
    let w_from = to_local(frame.shading, world_from);
    let w_to = to_local(frame.shading, world_to);
    let from_ng = dot(world_from, frame.geometric_normal);
    let to_ng = dot(world_to, frame.geometric_normal);
    var value: BsdfValue;
    if sides_agree(w_from.z, from_ng) && sides_agree(w_to.z, to_ng) {
        value = bsdf_evaluate(s, w_from, w_to, from_eye);
        value.f *= abs(select(w_from.z / from_ng, w_to.z / to_ng, from_eye));
    }
    return value;
}

/// Draws a world-space direction. Delta events are complete. Of others only `w` is: their weight is
/// f |w.ng| / pdf of `shading_evaluate`, which the caller evaluates for other directions too.
fn shading_sample_direction(
    s: Surface, frame: ShadingFrame, world_from: vec3f, u: vec3f, from_eye: bool,
) -> BsdfSample {
    let w_from = to_local(frame.shading, world_from);
    let from_ng = dot(world_from, frame.geometric_normal);
    var absorbed: BsdfSample;
    if !sides_agree(w_from.z, from_ng) {
        return absorbed;
    }
    var sample = bsdf_sample_direction(s, w_from, u, from_eye);
    if sample.pdf_solid == 0.0 {
        return absorbed;
    }
    let to_ns = sample.w.z;
    sample.w = to_world(frame.shading, sample.w);
    let to_ng = dot(sample.w, frame.geometric_normal);
    if !sides_agree(to_ns, to_ng) {
        return absorbed;
    }
    if !from_eye {
        sample.weight *= abs(w_from.z / from_ng) * abs(to_ng / to_ns);
    }
    return sample;
}

/// n^2 |cos| of a direction, n the index of refraction on its side: the measure in which a delta event's densities
/// in both directions are the same (lib/mis).
fn delta_measure(s: Surface, frame: ShadingFrame, world: vec3f) -> f32 {
    let z = dot(world, frame.shading.normal);
#if transmission
    if (s.flags & SURFACE_VOLUME) != 0u && z < 0.0 {
        return s.eta * s.eta * -z;
    }
#endif
    return abs(z);
}
