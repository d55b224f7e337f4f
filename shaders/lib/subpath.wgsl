#import bind/batch
#import bind/queue
#import bind/subpath
#import lib/connections
#import lib/guide
#import lib/hit
#import lib/mis
#import lib/roulette
#import lib/shading
#import lib/thinning
#if light_guide
#import lib/subspaces
#endif

// One vertex of a sub-path, the same from the eye and from the light: what is known of it before the next direction is,
// and the step to the next ray. Densities per area use the stored positions of both ends: the offset of a ray's origin turns its
// direction a little, and weights would miss one.

/// A vertex as seen from its own sub-path.
struct PathVertex {
    /// Unit direction to the vertex before.
    world_from: vec3f,
    /// Density of this vertex per area, roulette included.
    pdf_area: f32,
    /// Turns a density per solid angle towards the vertex before into its density per area there.
    to_previous: f32,
    ratio: f32,
    /// c of lib/mis between this vertex, if it is no delta vertex, and the one before.
    edge: f32,
    flags: u32,
}

/// The vertex that a ray has just reached, which came from `previous` with `direction` and `pdf_solid`. `scale`: of the
/// density of connecting the two.
fn path_vertex(
    point: SurfacePoint, direction: vec3f, pdf_solid: f32, previous: SubPath, scale: f32,
) -> PathVertex {
    let edge = edge_density(previous.flags, scale);
    if (previous.flags & SUBPATH_INFINITE) != 0u {
        let pdf_area = pdf_solid * abs(dot(direction, point.world_ng));
        return PathVertex(-direction, pdf_area, 1.0, previous.ratio, edge, previous.flags);
    }
    let span = previous.position - point.position;
    let inv_distance_sq = 1.0 / dot(span, span);
    let world_from = span * sqrt(inv_distance_sq);
    let has_normal = any(previous.normal != vec3f(0.0));
    let cos_previous = select(1.0, abs(dot(world_from, previous.normal)), has_normal);
    return PathVertex(
        world_from,
        pdf_solid * abs(dot(world_from, point.world_ng)) * inv_distance_sq,
        cos_previous * inv_distance_sq,
        previous.ratio,
        edge,
        previous.flags,
    );
}

/// What the density of connections to an eye path's vertex of that depth is times: they come from the one before it.
fn eye_scale(depth: u32, previous: SubPath) -> f32 {
    return density_scale(depth - 1u) * thinning_before(previous.flags);
}

/// The same of a light path's vertex: connections go from it to the one before it.
fn light_scale(point: SurfacePoint) -> f32 {
    return density_scale(DEEP) * thinning_at(point.material);
}

/// The same of an eye path's ray: connections to this vertex come from the one before it.
fn eye_path_vertex(point: SurfacePoint, ray: PathRay, previous: SubPath) -> PathVertex {
    let depth = ray.depth_medium & 0xffffu;
    return path_vertex(point, ray.direction, ray.pdf_solid, previous, eye_scale(depth, previous));
}

/// The same of a light path's ray.
fn light_path_vertex(point: SurfacePoint, ray: PathRay, previous: SubPath) -> PathVertex {
    return path_vertex(point, ray.direction, ray.pdf_solid, previous, light_scale(point));
}

/// c of lib/mis between the vertex that `flags` describes and the one after it, if that is no delta vertex. (Of
/// connections by subspaces and of resampling their weights know more.)
fn edge_density(flags: u32, scale: f32) -> f32 {
    if (flags & SUBPATH_DELTA) != 0u {
        return 0.0;
    }
    var known = scale;
#if subspaces
    known = 0.0;
#endif
#if resampling
    known = 0.0;
#endif
    return select(known, batch.camera_paths, (flags & SUBPATH_CAMERA) != 0u);
}

/// `mis_step` at a vertex for a density towards the vertex before, per solid angle, roulette included.
fn vertex_step(vertex: PathVertex, pdf_back_solid: f32, is_delta: bool) -> f32 {
    let edge = select(vertex.edge, 0.0, is_delta);
    return mis_step(vertex.ratio, pdf_back_solid * vertex.to_previous, edge, vertex.pdf_area);
}

/// An eye vertex as weights by subspaces of its connection to a light vertex know it: all that `ratio` and `edge` hold is the
/// strategy that connects to the camera, which is weighed by the densities of unguided light paths.
fn seen_unguided(vertex: PathVertex, nominal: f32) -> PathVertex {
    var seen = vertex;
    seen.ratio *= nominal;
    seen.edge *= nominal;
    return seen;
}

const_assert (CAUGHT_RUN <= SUBPATH_RUN_MOST);

/// Probability that a sub-path goes on from its vertex.
fn path_survival(surface: Surface, vertex: PathVertex) -> f32 {
#if lambert_only
    return survival(surface);
#else
    let is_delta = (surface.flags & SURFACE_DELTA) != 0u;
    return survival(surface) * select(1.0, run_survival(run_before(vertex.flags)), is_delta);
#endif
}

/// Whether and how a sub-path goes on.
struct Bounce {
    goes_on: bool,
    direction: vec3f,
    /// Roulette included.
    pdf_solid: f32,
    /// f |cos| / density.
    weight: vec3f,
    /// Density towards the vertex before, as the other side would sample it, per solid angle, roulette included.
    pdf_back_solid: f32,
    /// Density of the direction, were it not guided, over its density.
    nominal: f32,
    next: SubPath,
}

/// The step over a vertex along `direction`, once it is chosen, with its densities in both directions.
fn next_sub_path(
    point: SurfacePoint, vertex: PathVertex, is_delta: bool, pdf_back_solid: f32,
) -> SubPath {
    return SubPath(
        point.position,
        vertex_step(vertex, pdf_back_solid, is_delta),
        point.world_ng,
        select(0u, delta_flags(vertex.flags), is_delta) | thinning_flags(point.material),
    );
}

#if light_guide
/// Share of the directions from a surface that the guide draws: it knows one side of a surface, and nothing of narrow lobes.
fn guide_share(surface: Surface) -> f32 {
#if lambert_only
    return 1.0;
#else
    if (surface.flags & SURFACE_DELTA) != 0u {
        return 0.0;
    }
    return 0.5 * mix((1.0 - surface.transmission), surface.alpha, surface.metallic);
#endif
}
#endif

/// Samples the next ray. `u.w` decides the roulette. `label`: light subspace of a light path's vertex.
fn sample_bounce(
    point: SurfacePoint, surface: Surface, frame: ShadingFrame, vertex: PathVertex, u: vec4f, from_eye: bool,
    label: u32,
) -> Bounce {
    var bounce: Bounce;
    let is_delta = (surface.flags & SURFACE_DELTA) != 0u;
    let survives = path_survival(surface, vertex);
    if u.w >= survives {
        return bounce;
    }
#if light_guide
    let guided = guide_share(surface);
    let guide_frame = frame_from_normal(label_normal(point, vertex.world_from));
    var sample: BsdfSample;
    if u.z < guided {
        sample.w = guide_direction(label, guide_frame, u.xy);
        sample.pdf_solid = 1.0;
    } else {
        let lobe = min((u.z - guided) / (1.0 - guided), 0x1.fffffep-1);
        sample = shading_sample_direction(surface, frame, vertex.world_from, vec3f(u.xy, lobe), from_eye);
    }
#else
    let sample = shading_sample_direction(surface, frame, vertex.world_from, u.xyz, from_eye);
#endif
    if sample.pdf_solid == 0.0 {
        return bounce;
    }
    var weight = sample.weight;
    var pdf_solid = sample.pdf_solid;
    var pdf_back_solid = 0.0;
    bounce.nominal = 1.0;
    if is_delta {
        pdf_back_solid = sample.pdf_solid * delta_measure(surface, frame, vertex.world_from);
        pdf_solid *= delta_measure(surface, frame, sample.w);
    } else {
        let value = shading_evaluate(surface, frame, vertex.world_from, sample.w, from_eye);
        pdf_solid = value.pdf_solid;
#if light_guide
        pdf_solid = mix(pdf_solid, guide_pdf_solid(label, guide_frame, sample.w), guided);
#endif
        if pdf_solid == 0.0 {
            return bounce;
        }
#if light_guide
        bounce.nominal = value.pdf_solid / pdf_solid;
#endif
        weight = value.f * (abs(dot(sample.w, point.world_ng)) / pdf_solid);
        pdf_back_solid = value.pdf_back_solid;
    }
    bounce.goes_on = any(weight > vec3f(0.0));
    bounce.direction = sample.w;
    bounce.pdf_solid = pdf_solid * survives;
    bounce.weight = weight / survives;
    bounce.pdf_back_solid = pdf_back_solid * survives;
    bounce.next = next_sub_path(point, vertex, is_delta, bounce.pdf_back_solid);
    return bounce;
}

/// The BSDF on the way on; 0 where the path ends. What was sampled is f |cos| / density; roulette is in both.
fn bounce_f(point: SurfacePoint, bounce: Bounce) -> vec3f {
    if !bounce.goes_on {
        return vec3f(0.0);
    }
    return bounce.weight * (bounce.pdf_solid / abs(dot(bounce.direction, point.world_ng)));
}
