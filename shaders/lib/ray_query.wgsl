#import bind/accel
#import lib/intersect
#import lib/math

// The traversal by the driver's ray queries, in place of lib/traverse's own. The driver says which triangle; where on it, and
// whether that counts as a hit, lib/intersect says, so that a hit means what it means anywhere. Where the two do not agree on
// whose side of an edge a ray passes, the driver's word stands: it has no other triangle there.

/// What the driver made of `triangles`: see src/device/structure.rs.
@group(0) @binding(16) var scene_structure: acceleration_structure;
/// Of a triangle's index, the bits that are within a geometry.
override GEOMETRY_BITS: u32 = 0u;

const EVERY_INSTANCE: u32 = 0xffu;

/// What the ray meets in a triangle that the driver names: nothing where our test refuses the distance.
fn confirmed(ray: ShearedRay, named: RayIntersection, t_max: f32) -> RayHit {
    let index = (named.geometry_index << GEOMETRY_BITS) + named.primitive_index;
    let triangle = triangles[index];
    let own = intersect_triangle(ray, triangle.v0, triangle.v1, triangle.v2, t_max);
    if own.t > 0.0 {
        return RayHit(own.t, index, own.b1, own.b2);
    }
    if own.b1 >= 0.0 && own.b2 >= 0.0 && own.b1 + own.b2 <= 1.0 {
        // It is met, but by the origin itself or beyond the end.
        return RayHit(t_max, NO_TRIANGLE, 0.0, 0.0);
    }
    return RayHit(named.t, index, named.barycentrics.x, named.barycentrics.y);
}

/// The ray may end at the triangle that the driver asks about.
fn is_met(ray: ShearedRay, direction: vec3f, named: RayIntersection, t_max: f32) -> bool {
    let hit = confirmed(ray, named, t_max);
    if hit.triangle == NO_TRIANGLE {
        return false;
    }
#if alpha
    if (triangles[hit.triangle].material_flags & TRIANGLE_ALPHA) != 0u && !is_present(hit.triangle, hit.b1, hit.b2) {
        return false;
    }
#endif
#if culling
    if is_culled(hit.triangle, direction) {
        return false;
    }
#endif
    return true;
}

/// As the traversal by kernels: the hit closest to the origin among t in (0, t_max), or, with `any_hit`, the first one found.
fn trace(origin: vec3f, direction: vec3f, t_max: f32) -> RayHit {
    var hit = RayHit(t_max, NO_TRIANGLE, 0.0, 0.0);
    // Of other rays drivers may make anything.
    if !is_finite3(origin) || !is_finite3(direction) || all(direction == vec3f(0.0)) || !is_finite(t_max) || t_max <= 0.0 {
        return hit;
    }
    let sheared = shear_ray(origin, direction);
#if any_hit
    var flags = RAY_FLAG_TERMINATE_ON_FIRST_HIT;
#else
    var flags = RAY_FLAG_NONE;
#endif
    var query: ray_query;
    // The driver decides by itself at opaque triangles. Where that was wrong, it asks at every triangle the second time.
    for (var attempt = 0u; attempt < 2u; attempt++) {
        rayQueryInitialize(&query, scene_structure, RayDesc(flags, EVERY_INSTANCE, 0.0, t_max, origin, direction));
        while rayQueryProceed(&query) {
            if is_met(sheared, direction, rayQueryGetCandidateIntersection(&query), t_max) {
                rayQueryConfirmIntersection(&query);
            }
        }
        let named = rayQueryGetCommittedIntersection(&query);
        if named.kind == RAY_QUERY_INTERSECTION_NONE {
            return hit;
        }
        hit = confirmed(sheared, named, t_max);
        if hit.triangle != NO_TRIANGLE {
            break;
        }
        flags |= RAY_FLAG_FORCE_NO_OPAQUE;
    }
#if coincident
#if !any_hit
    if hit.triangle != NO_TRIANGLE {
        return in_front(sheared, direction, hit);
    }
#endif
#endif
    return hit;
}
