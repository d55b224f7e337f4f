#import bind/light_cache
#import lib/subpath
#if lambert_vertices
#import lib/lambert
#endif

// The vertices of light paths as the cache has them. `place`: light path, and the vertex's number in it with its light
// subspace (`number_label`).

#if lambert_vertices
/// A point on a surface where light of `weight` arrives.
fn surface_vertex(
    point: SurfacePoint, surface: Surface, arrival: Arrival, weight: vec3f, depth: u32, place: vec2u,
) -> LightVertex {
    let cos_from = cosines(point, point_normal(point), arrival.world_from);
    let pdf_scale = lambert_pdf_scale(surface);
    return LightVertex(
        select(vec3f(0.0), weight * lambert_f(surface, cos_from), is_open(cos_from)),
        point.triangle,
        point.b.y,
        point.b.z,
        magnitude(weight),
        arrival_step(arrival, pdf_scale * abs(cos_from.shading), false),
        pdf_scale,
        depth | select(0u, LIT_FROM_FRONT, cos_from.geometric > 0.0),
        place.x,
        place.y,
    );
}
#else
/// A point on a surface where light of `weight` arrives.
fn surface_vertex(
    point: SurfacePoint, surface: Surface, arrival: Arrival, weight: vec3f, depth: u32, place: vec2u,
) -> LightVertex {
    return LightVertex(
        weight,
        point.triangle,
        arrival.world_from,
        depth,
        point.b.y,
        point.b.z,
        arrival.pdf_area,
        arrival.ratio,
        arrival.to_previous,
        arrival.edge,
        place.x,
        place.y,
    );
}
#endif

/// A point on a light of `kind`, `at` as lib/emission has it. `ratio`: 1 for a light that eye paths can hit, or 0.
fn source_vertex(
    kind: u32, index: u32, at: vec2f, world_to_light: vec3f, weight: vec3f, pdf_light: f32, ratio: f32, place: vec2u,
) -> LightVertex {
    let depth_kind = (kind + 1u) << 16u;
#if lambert_vertices
    let step = ratio / pdf_light;
    return LightVertex(
        weight, index, at.x, at.y, magnitude(weight), step, 0.0, depth_kind, place.x, place.y,
    );
#else
    return LightVertex(
        weight, index, world_to_light, depth_kind, at.x, at.y, pdf_light, ratio, 1.0, 0.0, place.x, place.y,
    );
#endif
}
