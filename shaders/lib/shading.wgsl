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

/// f |w_light.ns| / |w_light.ng|: multiply by the geometric cosine at the light's end.
fn shading_eval(s: Surface, frame: ShadingFrame, world_eye: vec3f, world_light: vec3f) -> vec3f {
    let eye = to_local(frame.shading, world_eye);
    let light = to_local(frame.shading, world_light);
    let light_ng = dot(world_light, frame.geometric_normal);
    if !sides_agree(eye.z, dot(world_eye, frame.geometric_normal)) || !sides_agree(light.z, light_ng) {
        return vec3f(0.0);
    }
    return bsdf_eval(s, eye, light) * abs(light.z / light_ng);
}

/// Density of `shading_sample`, in solid angle of `world_to`.
fn shading_pdf_solid(s: Surface, frame: ShadingFrame, world_from: vec3f, world_to: vec3f) -> f32 {
    let w_from = to_local(frame.shading, world_from);
    let w_to = to_local(frame.shading, world_to);
    if !sides_agree(w_from.z, dot(world_from, frame.geometric_normal))
        || !sides_agree(w_to.z, dot(world_to, frame.geometric_normal)) {
        return 0.0;
    }
    return bsdf_pdf_solid(s, w_from, w_to);
}

/// Draws a direction: `w` is in world space, `weight` = shading_eval |w.ng| / pdf. See `bsdf_sample`.
fn shading_sample(s: Surface, frame: ShadingFrame, world_from: vec3f, u: vec3f, from_eye: bool) -> BsdfSample {
    let w_from = to_local(frame.shading, world_from);
    let from_ng = dot(world_from, frame.geometric_normal);
    var absorbed: BsdfSample;
    if !sides_agree(w_from.z, from_ng) {
        return absorbed;
    }
    var sample = bsdf_sample(s, w_from, u, from_eye);
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
