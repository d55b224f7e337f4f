#import lib/bsdf
#import lib/frame
#if bent_normals
#import lib/bend
#endif

// The BSDF in world space, and the one place that knows shading normals from geometric ones.
//
// Veach 1997, section 5.3: the BSDF that a bent normal makes is f |w_light.ns| / |w_light.ng|, which is not
// symmetric. Everything here is that function, so callers use *geometric* cosines throughout, whichever way
// they trace; its samples carry the right weight for both. Directions are moved between the hemispheres of both
// normals (lib/bend), which they leave on their side of the surface: no light leaks through, and none is lost.

struct ShadingFrame {
    shading: Frame,
    geometric_normal: vec3f,
#if bent_normals
    bend: Bend,
#endif
}

/// Both normals unit, and on the same side of the surface (the outer one, where it bounds a volume).
fn shading_frame(shading_normal: vec3f, geometric_normal: vec3f) -> ShadingFrame {
#if bent_normals
    let bend = bend_between(shading_normal, geometric_normal);
    return ShadingFrame(frame_from_normal(shading_normal), geometric_normal, bend);
#else
    return ShadingFrame(frame_from_normal(shading_normal), geometric_normal);
#endif
}

/// A direction of the world as the BSDF knows it.
struct ShadingDirection {
    local: vec3f,
    /// Cosine to the shading normal, in the measure of the world's solid angles: times their Jacobian.
    cos_shading: f32,
    cos_geometric: f32,
#if bent_normals
    /// Solid angle of `local` for solid angle of the world.
    jacobian: f32,
#endif
}

fn shading_direction(frame: ShadingFrame, world: vec3f) -> ShadingDirection {
    let cos_geometric = dot(world, frame.geometric_normal);
#if bent_normals
    let side = select(-1.0, 1.0, cos_geometric > 0.0);
    let there = moved(frame.bend, frame.shading.normal, frame.geometric_normal, world, side, true);
    let local = to_local(frame.shading, there.world);
    return ShadingDirection(local, local.z * there.jacobian, cos_geometric, there.jacobian);
#else
    let local = to_local(frame.shading, world);
    return ShadingDirection(local, local.z, cos_geometric);
#endif
}

/// Both planes have the direction on the same side, and it grazes neither.
fn sides_agree(cos_shading: f32, cos_geometric: f32) -> bool {
    return min(abs(cos_shading), abs(cos_geometric)) >= MIN_COS && (cos_shading > 0.0) == (cos_geometric > 0.0);
}

/// Light passes, as far as this direction says.
fn is_open(direction: ShadingDirection) -> bool {
    return sides_agree(direction.local.z, direction.cos_geometric);
}

/// f |w_light.ns| / |w_light.ng|, to be multiplied by geometric cosines, and the density of `shading_sample`. With
/// `from_eye`, world_from leads to the eye and world_to to the light.
fn shading_evaluate(
    s: Surface, frame: ShadingFrame, world_from: vec3f, world_to: vec3f, from_eye: bool,
) -> BsdfValue {
    let w_from = shading_direction(frame, world_from);
    let w_to = shading_direction(frame, world_to);
    var value: BsdfValue;
    if is_open(w_from) && is_open(w_to) {
        value = bsdf_evaluate(s, w_from.local, w_to.local, from_eye);
        value.f *= abs(select(
            w_from.cos_shading / w_from.cos_geometric, w_to.cos_shading / w_to.cos_geometric, from_eye));
#if bent_normals
        value.pdf_solid *= w_to.jacobian;
#if bidirectional
        value.pdf_back_solid *= w_from.jacobian;
#endif
#endif
    }
    return value;
}

/// Draws a world-space direction. Delta events are complete. Of others only `w` is: their weight is
/// f |w.ng| / pdf of `shading_evaluate`, which the caller evaluates for other directions too.
fn shading_sample_direction(
    s: Surface, frame: ShadingFrame, world_from: vec3f, u: vec3f, from_eye: bool,
) -> BsdfSample {
    let w_from = shading_direction(frame, world_from);
    var absorbed: BsdfSample;
    if !is_open(w_from) {
        return absorbed;
    }
    var sample = bsdf_sample_direction(s, w_from.local, u, from_eye);
    if sample.pdf_solid == 0.0 {
        return absorbed;
    }
    var to_ns = sample.w.z;
    sample.w = to_world(frame.shading, sample.w);
#if bent_normals
    let side = select(-1.0, 1.0, to_ns > 0.0);
    let there = moved(frame.bend, frame.shading.normal, frame.geometric_normal, sample.w, side, false);
    sample.w = there.world;
    to_ns /= there.jacobian;
#endif
    let to_ng = dot(sample.w, frame.geometric_normal);
    if !sides_agree(to_ns, to_ng) {
        return absorbed;
    }
    if !from_eye {
        sample.weight *= abs(w_from.cos_shading / w_from.cos_geometric) * abs(to_ng / to_ns);
    }
    return sample;
}

/// n^2 |cos| of a direction, n the index of refraction on its side: the measure in which a delta event's densities
/// in both directions are the same (lib/mis).
fn delta_measure(s: Surface, frame: ShadingFrame, world: vec3f) -> f32 {
    let z = shading_direction(frame, world).cos_shading;
#if transmission
    if (s.flags & SURFACE_VOLUME) != 0u && z < 0.0 {
        return s.eta * s.eta * -z;
    }
#endif
    return abs(z);
}
