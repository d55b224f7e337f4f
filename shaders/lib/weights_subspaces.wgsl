#import bind/batch
#import bind/light_cache
#import bind/queue
#import bind/subpath
#import bind/subspace_mis
#import lib/color
#import lib/connections
#import lib/emission
#import lib/light
#import lib/mis
#import lib/subpath
#import lib/subspaces
#import lib/thinning

// Weights where connections are chosen by subspaces: an eye vertex z of eye subspace e is connected to a light vertex y
// of light subspace l with density Gamma[e][l] |w_y| / Q[l] over that of its light sub-path. In the terms of lib/mis
//
//   c(z, y) = S Gamma[e][l] |w_y| / Q[l]
//
// depends on the whole light sub-path through w, so that the eye's side has to remember a colour in place of a ratio:
//
//   A(z_k) = (A(z_{k-1}) f(z_{k-1}) G(z_{k-1}, z_{k-2}) + S Gamma / Q (z_{k-2}, z_{k-1})) / pE(z_{k-1})
//
// where S is the scale of the eye vertex's depth (lib/connections) times its thinning (lib/thinning), and the densities of all connections nearer to the eye than (z, y) are |w_y f(y) G(y, z) A|, continued to z.
// Su, Li, Wang 2022.

/// What weights need of an eye vertex: what its ray carries, and its own subspaces (`eye_labels`).
struct EyePartials {
    mis: EyeMis,
    labels: vec2u,
    depth: u32,
}

/// Of the vertex that a ray of the queue has just reached.
fn load_eye_partials(index: u32, depth: u32) -> EyePartials {
    return EyePartials(eye_mis_in[index], eye_labels[index], depth);
}

fn eye_depth(partials: EyePartials) -> u32 {
    return partials.depth;
}

/// What the last segment absorbs counts too.
fn absorb(partials: EyePartials, through: vec3f) -> EyePartials {
    return EyePartials(EyeMis(partials.mis.a * through, partials.mis.label), partials.labels, partials.depth);
}

/// c over |w| between an eye path's vertex, if it is no delta vertex, and the one before it, which has `flags`.
fn eye_edge(flags: u32, partials: EyePartials, light_label: u32) -> f32 {
    if (flags & (SUBPATH_DELTA | SUBPATH_CAMERA)) != 0u {
        return 0.0;
    }
    let scale = density_scale(partials.depth - 1u) * thinning_before(flags);
    return scale * gamma_over_q(partials.mis.label, light_label);
}

/// Light subspace of an eye path's vertex to which light comes from `world_to`. `known`: what it is where directions do
/// not matter.
fn eye_light_label(point: SurfacePoint, world_to: vec3f, known: u32) -> u32 {
#if subspace_directions
    return vertex_label(TREE_LIGHT, point, world_to);
#else
    return known;
#endif
}

/// Of the ray that leaves an eye vertex along `direction`, for which the BSDF is `f`.
fn eye_mis_of_bounce(
    point: SurfacePoint, vertex: PathVertex, partials: EyePartials, direction: vec3f, f: vec3f, pdf_back: f32,
    is_delta: bool,
) -> EyeMis {
    let label = eye_light_label(point, direction, partials.labels.y);
    let before = select(eye_edge(vertex.flags, partials, label), 0.0, is_delta);
    let cos_from = abs(dot(vertex.world_from, point.world_ng));
    let continued = partials.mis.a * f * (cos_from * vertex.to_previous) + before;
    return EyeMis(continued / vertex.pdf_area, partials.labels.x);
}

/// Of the ray in a slot of the queue.
fn store_eye_mis(slot: u32, mis: EyeMis) {
    eye_mis_out[slot] = mis;
}

fn load_light_mis(index: u32) -> LightMis {
    return light_mis_in[index];
}

/// Light subspace of a surface vertex of a light path.
fn light_subspace(point: SurfacePoint, world_from: vec3f) -> u32 {
    return vertex_label(TREE_LIGHT, point, world_from);
}

/// c, with the scale of DEEP, between a light path's vertex, if it is no delta vertex, and the one before it, which has
/// `w_over_q` and the light subspace `column`. `world_to`: to the vertex that is nearer to the camera.
fn light_edge(point: SurfacePoint, world_to: vec3f, w_over_q: f32, column: u32) -> f32 {
    if w_over_q == 0.0 {
        return 0.0;
    }
    let row = vertex_label(TREE_EYE, point, world_to);
    return density_scale(DEEP) * thinning_at(point.material) * gamma_pdf[row * batch.subspaces + column] * w_over_q;
}

/// The same for the vertex that a light path has just reached, as far as it is known before the direction on is.
fn edge_so_far(point: SurfacePoint, vertex: PathVertex, mis: LightMis, throughput: vec3f) -> f32 {
#if subspace_directions
    return 0.0;
#else
    return light_edge(point, vertex.world_from, mis.w_over_q, mis.label);
#endif
}

/// The same, whole, for a vertex that is connected towards `world_to`.
fn edge_towards(
    point: SurfacePoint, vertex: PathVertex, mis: LightMis, world_to: vec3f, throughput: vec3f,
) -> f32 {
    return light_edge(point, world_to, mis.w_over_q, mis.label);
}

/// Adds what `edge_so_far` left out. What connecting the vertex to the one before is of the ratio then.
fn add_edge_of_bounce(
    bounce: ptr<function, Bounce>, point: SurfacePoint, vertex: PathVertex, mis: LightMis, is_delta: bool,
) -> f32 {
    if is_delta {
        return 0.0;
    }
#if subspace_directions
    let part = light_edge(point, (*bounce).direction, mis.w_over_q, mis.label) / vertex.pdf_area;
    (*bounce).next.ratio += part;
    return part;
#else
    return vertex.edge / vertex.pdf_area;
#endif
}

/// A vertex as the cache has it: with what its edge waits for.
fn cached_with_edge(vertex: LightVertex, mis: LightMis) -> LightVertex {
#if subspace_directions
    var cached = vertex;
    cached.edge = mis.w_over_q;
    cached.depth_kind |= mis.label << 20u;
    return cached;
#else
    return vertex;
#endif
}

#if !lambert_vertices
/// c of lib/mis between a vertex of the cache and the one before it, seen from `world_to`, with the scale of DEEP.
fn cached_edge(vertex: LightVertex, point: SurfacePoint, world_to: vec3f) -> f32 {
#if subspace_directions
    return light_edge(point, world_to, vertex.edge, vertex.depth_kind >> 20u);
#else
    return vertex.edge;
#endif
}
#endif

/// Of the ray that leaves a light vertex of a light subspace, on which light of `throughput` arrived.
fn light_mis_of_bounce(throughput: vec3f, behind: f32, is_delta: bool, label: u32, nominal: f32) -> LightMis {
    let weight = select(throughput, vec3f(0.0), is_delta);
    return LightMis(magnitude(weight) * inv_q[label], behind, nominal, label);
}

/// What the last connection but one that the ratio knows of is of it: from the vertex that the ray left to the one before.
fn edge_before(mis: LightMis) -> f32 {
    return mis.behind;
}

/// Density of an unguided light sub-path over that of the one whose ray this is.
fn nominal_of(mis: LightMis) -> f32 {
    return mis.nominal;
}

/// Of the ray in a slot of the queue.
fn store_light_mis(slot: u32, mis: LightMis) {
    light_mis_out[slot] = mis;
}

/// The weight of a connection, and the density of all strategies that make the path, over those of its two sub-paths.
/// `arriving_light`: of the light vertex, at the eye vertex. Each side: its `mis_step`, and the density of its vertex
/// as sampled from the other end.
fn weigh_connection(
    eye_point: SurfacePoint, eye_vertex: PathVertex, partials: EyePartials, light_vertex: LightVertex, direction: vec3f,
    f_eye: vec3f, arriving_light: vec3f, eye_step: f32, pdf_back: f32, pdf_eye: f32, light_step: f32, pdf_light: f32,
) -> ConnectionWeight {
    let scale = density_scale(partials.depth) * thinning_at(eye_point.material);
    let edge = scale * gamma_over_q(partials.labels.x, label_of(light_vertex)) * arriving(light_vertex);
    let beyond = eye_mis_of_bounce(eye_point, eye_vertex, partials, direction, f_eye, pdf_back, false);
    let nearer = magnitude(arriving_light * beyond.a);
    let density = edge + nearer + eye_step * pdf_eye + light_step * pdf_light;
    return ConnectionWeight(edge / density, density);
}

#if area_lights
/// Weight of an eye path that met an emitting triangle; `light`: its index in `lights`.
fn emitter_weight(point: SurfacePoint, vertex: PathVertex, partials: EyePartials, light: u32) -> f32 {
    if (vertex.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_previous = emission_pdf_solid(point, vertex.world_from) * vertex.to_previous;
    let pdf_light = lights[light].pdf_select / point.area;
    let emission = point_emission(point, vertex.world_from) * point_presence(point);
    let geometry = abs(dot(vertex.world_from, point.world_ng)) * vertex.to_previous;
    let edge = eye_edge(vertex.flags, partials, source_label(light, point.b.yz));
    let others = edge * magnitude(emission) + magnitude(partials.mis.a * emission) * geometry
        + vertex.ratio * pdf_previous * pdf_light;
    return batch.hit_scale / (batch.hit_scale + others / vertex.pdf_area);
}
#endif

#if environment
/// Weight of an eye path that left the scene along `direction`, which has the density `pdf_solid`.
fn environment_weight(previous: SubPath, partials: EyePartials, direction: vec3f, pdf_solid: f32) -> f32 {
    if (previous.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_previous = abs(dot(direction, previous.normal)) * disk_pdf_area();
    let pdf_light = environment_pdf_solid(direction);
    let radiance = environment_radiance(direction);
    let cosine = abs(dot(direction, previous.normal));
    let edge = eye_edge(previous.flags, partials, source_label(environment_map.light, sphere_to_square(direction)));
    let others = edge * magnitude(radiance) + magnitude(partials.mis.a * radiance) * cosine
        + previous.ratio * pdf_previous * pdf_light;
    return batch.hit_scale / (batch.hit_scale + others / pdf_solid);
}
#endif
