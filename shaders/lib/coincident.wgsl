#import bind/accel
#import lib/hit
#import lib/intersect

// Surfaces that lie in one another. One is in front, on either side, for rays and for samples of lights alike; which,
// the host has decided (src/accel/coincident.rs), so that rounding decides nothing.

/// Limits of the indices in `covers` of the triangles that may be in front of a triangle at a point, seen from its front
/// or its back; the one in front of all others first.
fn covers_at(triangle: u32, b: vec2f, front: bool) -> vec2u {
    let cover = triangles[triangle].cover;
    if cover == 0u {
        return vec2u(0u);
    }
    let block = covers[cover + select(1u, 0u, front)];
    let cells = covers[block];
    let cell = min(vec2u(max(b, vec2f(0.0)) * f32(cells)), vec2u(cells - 1u));
    let limits = block + 1u + cell.y * cells + cell.x;
    return vec2u(covers[limits], covers[limits + 1u]);
}

#if area_lights
/// Share of a point on a light that can be seen from `direction`: none where another surface is in front of it there.
fn uncovered(point: SurfacePoint, direction: vec3f) -> f32 {
    let front = dot(direction, point.world_ng) > 0.0;
    let limits = covers_at(point.triangle, point.b.yz, front);
    var share = 1.0;
    // Seen along the normal, from as far as the triangle is large.
    let away = sqrt(point.area) * point.world_ng;
    for (var entry = limits.x; entry < limits.y && share > 0.0; entry++) {
        let other = triangles[covers[entry]];
        let hit = intersect_triangle(
            shear_ray(point.position + away, -away), other.v0, other.v1, other.v2, MAX_FLOAT);
        if hit.t > 0.0 {
            share *= 1.0 - presence_at(covers[entry], hit.b1, hit.b2);
        }
    }
    return share;
}
#endif
