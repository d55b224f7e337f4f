#import bind/accel
#import bind/ray_query
#import lib/intersect
#import lib/math
#if instances
#import lib/instance
#endif

// The traversal by the driver's ray queries, in place of lib/traverse's own. The driver names a triangle; where on it the ray
// meets it, and whether that counts, lib/intersect says, so that a hit means what it means anywhere. Where the two do not
// agree on which side of an edge a ray passes, the driver's word stands: it may have no other triangle there.

/// The mask of a ray that may meet all there is.
const EVERYTHING: u32 = 0xffu;

/// The ray, and what the driver gets of it.
struct QueryRay {
    sheared: ShearedRay,
    direction: vec3f,
    t_max: f32,
    /// The driver's ray begins so far before the origin, and ends so far beyond `t_max`: where surfaces all but touch, its
    /// distances are not to be trusted with which of them the ray begins and ends between.
    room: f32,
}

fn query_ray(origin: vec3f, direction: vec3f, t_max: f32) -> QueryRay {
    let sheared = shear_ray(origin, direction);
#if thin_gaps
    // Far above the rounding of the driver's distances: unit space has coordinates below one.
    let away = abs(origin);
    let size = abs(direction);
    let room = 0x1p-18 * (1.0 + max(away.x, max(away.y, away.z))) / max(size.x, max(size.y, size.z));
    return QueryRay(sheared, direction, t_max, room);
#else
    return QueryRay(sheared, direction, t_max, 0.0);
#endif
}

/// The number of a triangle that the driver names.
fn named_number(named: RayIntersection) -> u32 {
#if instances
    let place = named.instance_custom_data;
    let base = structure_bases[place];
    let page = ((base >> GEOMETRY_BITS) + named.geometry_index) << GEOMETRY_BITS;
    let stored = select(page, base, named.geometry_index == 0u) + named.primitive_index;
    if place == 0u {
        return stored;
    }
    return stored + instances[place - 1u].shift;
#else
    return (named.geometry_index << GEOMETRY_BITS) + named.primitive_index;
#endif
}

/// The triangle of a number, in unit space.
fn named_triangle(number: u32) -> Triangle {
#if instances
    return triangle_at(number);
#else
    return triangles[number];
#endif
}

/// What the ray meets in a triangle that the driver names, before `t_max`; nothing where our test refuses the distance.
fn hit_of(ray: QueryRay, named: RayIntersection, t_max: f32) -> RayHit {
    let number = named_number(named);
    let triangle = named_triangle(number);
#if instances
    // The host leaves out what has no area in unit space.
    let area = cross((triangle.v1 - triangle.v0) * 0x1p40, (triangle.v2 - triangle.v0) * 0x1p40);
    if all(area == vec3f(0.0)) {
        return RayHit(ray.t_max, NO_TRIANGLE, 0.0, 0.0);
    }
#endif
    let own = intersect_triangle(ray.sheared, triangle.v0, triangle.v1, triangle.v2, t_max);
    if own.t > 0.0 {
        return RayHit(own.t, number, own.b1, own.b2);
    }
    let is_inside = own.b1 >= 0.0 && own.b2 >= 0.0 && own.b1 + own.b2 <= 1.0;
    let t = named.t - ray.room;
    if is_inside || t <= 0.0 || t >= t_max {
        return RayHit(ray.t_max, NO_TRIANGLE, 0.0, 0.0);
    }
    return RayHit(t, number, named.barycentrics.x, named.barycentrics.y);
}

/// The same, of a triangle at which the driver asks whether there is anything.
fn candidate_hit(ray: QueryRay, named: RayIntersection, t_max: f32) -> RayHit {
    var hit = hit_of(ray, named, t_max);
#if alpha
    if hit.triangle != NO_TRIANGLE && (named_triangle(hit.triangle).material_flags & TRIANGLE_ALPHA) != 0u {
        hit.triangle = select(NO_TRIANGLE, hit.triangle, is_present(hit.triangle, hit.b1, hit.b2));
    }
#endif
#if culling
    if hit.triangle != NO_TRIANGLE && is_culled(hit.triangle, ray.direction) {
        hit.triangle = NO_TRIANGLE;
    }
#endif
    return hit;
}

/// As the traversal by kernels: the hit closest to the origin among t in (0, t_max), or, with `any_hit`, the first one found.
fn trace(origin: vec3f, direction: vec3f, t_max: f32) -> RayHit {
    var hit = RayHit(t_max, NO_TRIANGLE, 0.0, 0.0);
    // Of other rays drivers may make anything.
    if !is_finite3(origin) || !is_finite3(direction) || all(direction == vec3f(0.0)) || !is_finite(t_max) || t_max <= 0.0 {
        return hit;
    }
    let ray = query_ray(origin, direction, t_max);
    let begin = origin - ray.room * direction;
    var low = 0.0;
    var high = min(t_max + 2.0 * ray.room, MAX_FLOAT);
#if any_hit
    var flags = RAY_FLAG_TERMINATE_ON_FIRST_HIT;
#else
    var flags = RAY_FLAG_NONE;
#endif
#if thin_gaps
    flags |= RAY_FLAG_FORCE_NO_OPAQUE;
#endif
    var is_searched = false;
    var query: ray_query;
    // At opaque triangles the driver decides by itself. Where our test refuses what it found, all are looked at.
    for (var attempt = 0u; attempt < 2u; attempt++) {
        rayQueryInitialize(&query, scene_structure, RayDesc(flags, EVERYTHING, low, high, begin, direction));
        while rayQueryProceed(&query) {
            let found = candidate_hit(ray, rayQueryGetCandidateIntersection(&query), hit.t);
            if found.triangle != NO_TRIANGLE {
                if is_searched {
                    hit = found;
                } else {
                    rayQueryConfirmIntersection(&query);
                }
            }
        }
        if is_searched {
            break;
        }
        let named = rayQueryGetCommittedIntersection(&query);
        if named.kind == RAY_QUERY_INTERSECTION_NONE {
            break;
        }
        hit = hit_of(ray, named, t_max);
#if thin_gaps
#if any_hit
        break;
#else
        // What is nearest there is up to our distances.
        is_searched = true;
        low = max(named.t - ray.room, 0.0);
        high = named.t + ray.room;
#endif
#else
        if hit.triangle != NO_TRIANGLE {
            break;
        }
        flags |= RAY_FLAG_FORCE_NO_OPAQUE;
#endif
    }
#if coincident
#if !any_hit
#if instances
    if hit.triangle != NO_TRIANGLE && !is_instanced(hit.triangle) {
#else
    if hit.triangle != NO_TRIANGLE {
#endif
        return in_front(ray.sheared, direction, hit);
    }
#endif
#endif
    return hit;
}
