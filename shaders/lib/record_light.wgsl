#import bind/light_cache
#import bind/records
#import lib/color
#import lib/strategies

// The light that a vertex of the light cache brings to a record, but for what is in between: what the record's own surface
// would do with it is left out, since it depends on where the eye's path goes on.

#if at_records
/// Light that arrives at a record at a smaller cosine does not count.
const LEAST_RECORD_COSINE: f32 = 0x1p-12;
#endif

/// What leaves a light vertex along a link.
fn leaving_light(light_vertex: LightVertex, kind: u32, link: Link) -> vec3f {
#if lambert_vertices
    return light_vertex.weight * leaving(light_vertex, kind, link.light_point, -link.direction).x;
#else
    if kind != 0u {
        return light_vertex.weight * emitted(light_vertex, kind, link.light_point, -link.direction).x;
    }
    let point = link.light_point;
    let surface = point_surface(point);
    let to_record = -link.direction;
    return light_vertex.weight
        * shading_evaluate(surface, point_frame(point), light_vertex.world_from, to_record, false).f;
#endif
}

/// The geometry term of a link from a record, as far as it counts.
fn record_geometry(record: Record, point: SurfacePoint, link: Link) -> f32 {
    let cosine = dot(link.direction, point.world_ng);
#if at_records
    // What lies in the record's plane brings nothing, whichever way its position is rounded.
    if abs(cosine) < LEAST_RECORD_COSINE {
        return 0.0;
    }
#endif
    let is_seen = (record.depth_sides & select(RECORD_BACK, RECORD_FRONT, cosine > 0.0)) != 0u;
    if link.to_light == 0.0 || !is_seen {
        return 0.0;
    }
    var geometry = abs(cosine) * link.to_light;
    if link.distance < MAX_FLOAT && geometry > record.most_geometry {
        geometry = record.most_geometry;
    }
    return geometry;
}

/// |.| of the light that arrives at a record along a link from it.
fn record_light(record: Record, point: SurfacePoint, light_vertex: LightVertex, kind: u32, link: Link) -> f32 {
    let geometry = record_geometry(record, point, link);
    if geometry == 0.0 {
        return 0.0;
    }
    return magnitude(leaving_light(light_vertex, kind, link)) * geometry;
}
