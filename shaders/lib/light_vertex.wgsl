#import bind/light_cache
#if at_records
#import bind/light_ends
#endif
#import lib/subpath
#import lib/weights
#if lambert_vertices
#import lib/lambert
#endif

// The vertices of light paths as the cache has them. `place`: light path, and the vertex's number in it with its light
// subspace.

#if lambert_vertices
/// A point on a surface where light of `weight` arrives.
fn surface_vertex(
    point: SurfacePoint, surface: Surface, vertex: PathVertex, weight: vec3f, depth: u32, place: vec2u,
) -> LightVertex {
    let w_from = shading_direction(point_frame(point), vertex.world_from);
    let pdf_scale = lambert_pdf_scale(surface);
    return LightVertex(
        select(vec3f(0.0), weight * lambert_f(surface, w_from), is_open(w_from)),
        point.triangle | select(0u, LIT_FROM_FRONT, w_from.cos_geometric > 0.0),
        point.b.y,
        point.b.z,
        magnitude(weight),
        vertex_step(vertex, pdf_scale * abs(w_from.cos_shading), false),
        vertex.edge / vertex.pdf_area,
        pdf_scale,
        place.x,
        place.y,
    );
}
#else
/// A point on a surface where light of `weight` arrives.
fn surface_vertex(
    point: SurfacePoint, surface: Surface, vertex: PathVertex, weight: vec3f, depth: u32, place: vec2u,
) -> LightVertex {
    return LightVertex(
        weight,
        point.triangle,
        vertex.world_from,
        depth,
        point.b.y,
        point.b.z,
        vertex.pdf_area,
        vertex.ratio,
        vertex.to_previous,
        vertex.edge,
        place.x,
        place.y,
    );
}
#endif

/// A point on a light of `kind`, `at` as lib/emission has it. `ratio`: H of lib/mis for a light that eye paths can hit, or 0.
fn source_vertex(
    kind: u32, index: u32, at: vec2f, world_to_light: vec3f, weight: vec3f, pdf_light: f32, ratio: f32, place: vec2u,
) -> LightVertex {
#if lambert_vertices
    let index_kind = index | ((kind + 1u) << INDEX_BITS);
    let step = ratio / pdf_light;
    return LightVertex(
        weight, index_kind, at.x, at.y, magnitude(weight), step, 0.0, 0.0, place.x, place.y,
    );
#else
    let depth_kind = (kind + 1u) << 16u;
    return LightVertex(
        weight, index, world_to_light, depth_kind, at.x, at.y, pdf_light, ratio, 1.0, 0.0, place.x, place.y,
    );
#endif
}

#if learns
// Training needs the whole sub-path: delta vertices are kept too, without weight, so that none is ever drawn.

fn is_kept(is_delta: bool) -> bool {
    return true;
}

fn keep_pdf_back(slot: u32, mis: LightMis) {
    light_backs[slot] = mis.behind;
}
#else
/// Whether a vertex goes to the cache: no connection can end at a delta vertex.
fn is_kept(is_delta: bool) -> bool {
    return !is_delta;
}

/// Only training looks at it.
fn keep_pdf_back(slot: u32, mis: LightMis) {}
#endif

/// Only connections to the camera look at it.
fn keep_nominal(slot: u32, nominal: f32) {
#if nominal
    light_nominals[slot] = nominal;
#endif
}

/// Puts a point on a surface into the cache, where light of `weight` arrives on a ray with `mis`.
fn cache_surface_vertex(
    path: u32, point: SurfacePoint, surface: Surface, vertex: PathVertex, weight: vec3f, depth: u32, label: u32,
    mis: LightMis,
) {
    let light_path = batch.first_light_path + path;
    let number = light_path_lengths[light_path];
    light_path_lengths[light_path] = number + 1u;
    atomicMax(&counts.longest_light_path, number + 1u);
    let slot = atomicAdd(&counts.light_vertices, 1u);
#if at_records
    cached_slot = slot;
#endif
    if slot < arrayLength(&light_vertices) {
        let place = vec2u(light_path, number | (label << 16u));
        light_vertices[slot] =
            cached_with_edge(surface_vertex(point, surface, vertex, weight, depth, place), mis);
        keep_pdf_back(slot, mis);
        keep_nominal(slot, nominal_of(mis));
    }
}
