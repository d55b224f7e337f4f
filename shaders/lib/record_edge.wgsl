#import bind/light_cache
#import lib/equal_area
#import lib/light_vertex
#import lib/nearest_records
#import lib/record_shares
#import lib/record_sight

// What records get of vertices, and what connecting to these is worth: lib/record_shares.

/// r of a light vertex at a record; 0 where there is none, or none that Q is known of.
fn light_at_record(place: u32, light_vertex: LightVertex) -> f32 {
    if inv_q_of(place) == 0.0 {
        return 0.0;
    }
    return counted(seen_light(records[place], light_vertex));
}

/// r at each of some records.
fn light_at_records(near: vec3u, light_vertex: LightVertex) -> vec3f {
    var light: vec3f;
    for (var k = 0u; k < records_among(near); k++) {
        light[k] = light_at_record(near[k], light_vertex);
    }
    return light;
}

/// Density of connecting a point with these records, as an eye vertex at DEEP, to a light vertex that brings `light` to them.
fn record_edge(point: SurfacePoint, near: vec3u, light: vec3f) -> f32 {
    return light_scale(point) * sum_of(choice_densities(light, near));
}

/// The geometry term between a vertex and each of some records, with what of it is hidden.
fn record_reach(near: vec3u, vertex: LightVertex) -> vec3f {
    let kind = kind_of(vertex);
    var reach: vec3f;
    for (var k = 0u; k < records_among(near); k++) {
        if inv_q_of(near[k]) > 0.0 {
            let record = records[near[k]];
            let point = surface_point(record.triangle, record.b1, record.b2);
            let link = link_to(point, vertex, kind);
            reach[k] = record_geometry(record, point, link);
            if reach[k] > 0.0 {
                reach[k] *= seen_share(point, link, kind);
            }
        }
    }
    return reach;
}

/// A point on a surface as `record_reach` wants it.
fn vertex_at(triangle: u32, b: vec2f) -> LightVertex {
    return source_vertex(LIGHT_TRIANGLE, triangle, b, vec3f(0.0), vec3f(0.0), 1.0, 0.0, vec2u(0u));
}

/// The same of what is infinitely far.
fn vertex_towards(direction: vec3f) -> LightVertex {
    let at = sphere_to_square(direction);
    return source_vertex(LIGHT_ENVIRONMENT, 0u, at, direction, vec3f(0.0), 1.0, 0.0, vec2u(0u));
}
