#import lib/record_light
#import lib/traverse

// What a record sees.

/// What is hidden from a record may be seen from where it is asked: so much of its light counts. Su, Li, Wang's code has it.
const HIDDEN_SHARE: f32 = 0.02;

/// Share of the light along a link from a record's point that counts.
fn seen_share(point: SurfacePoint, link: Link, kind: u32) -> f32 {
    let shadow = link_ray(point, link, kind);
#if alpha
    // What is half there or more hides.
    alpha_word = 0x80000000u;
#endif
    let hit = trace(shadow.origin, shadow.direction, shadow.t_max);
    return select(HIDDEN_SHARE, 1.0, hit.triangle == NO_TRIANGLE);
}

/// |.| of the light that a light vertex brings to a record, as far as it counts.
fn seen_light(record: Record, light_vertex: LightVertex) -> f32 {
    let kind = kind_of(light_vertex);
    let point = surface_point(record.triangle, record.b1, record.b2);
    let link = link_to(point, light_vertex, kind);
    let light = record_light(record, point, light_vertex, kind, link);
    if !is_drawable(light) {
        return 0.0;
    }
    return light * seen_share(point, link, kind);
}
