#import lib/instance

// The traversal where meshes are shown in many places: below the tree of the scene are those of the meshes.
//
// For the boxes of a mesh's tree the ray goes to the mesh's space, with room for what rounding does on the way. Triangles come to
// unit space and are tested there, so that a hit is what a copy of the mesh would have given; neighbours in a mesh have the
// same numbers at their edge, in the same order.

/// In the place of a stack's depth, and of an instance.
const OUTSIDE: u32 = 0xffffffffu;

/// The ray in an instance's mesh: distances along it are the same.
fn instance_ray(instance: Instance, origin: vec3f, direction: vec3f) -> BoxRay {
    let way = (origin - instance.origin) - instance.origin_rest;
    let x = instance.inverse_x;
    let y = instance.inverse_y;
    let z = instance.inverse_z;
    let local_origin = x * way.x + y * way.y + z * way.z;
    let local_direction = x * direction.x + y * direction.y + z * direction.z;
    var ray = box_ray(local_origin, local_direction);
    // Vertices are known to a few roundings of the largest coordinate, the ray to as many of its way to the instance.
    let away = abs(way);
    let rounding = 0x1p-19 * (max(away.x, max(away.y, away.z)) + instance.reach);
    ray.room = (abs(x) + abs(y) + abs(z)) * rounding * abs(ray.inv_direction);
    return ray;
}

/// The hit closest to the origin among t in (0, t_max), or, with `any_hit`, the first one found.
fn trace(origin: vec3f, direction: vec3f, t_max: f32) -> RayHit {
    let sheared = shear_ray(origin, direction);
    var ray = box_ray(origin, direction);
    var hit = RayHit(t_max, NO_TRIANGLE, 0.0, 0.0);
    // A group as in a tree of one level, or what is left of a node's triangles, whose bits are the low 24.
    var stack: array<vec2u, STACK_SIZE>;
    var depth = 0u;
    var group = vec2u(0u, 0x80000000u);
    // Where the ray is, and how deep the stack was when it came there.
    var instance: Instance;
    var way_out = OUTSIDE;
    loop {
        var first = group.x;
        var pending = group.y;
        if group.y > 0x00ffffffu {
            let child_bit = firstLeadingBit(group.y);
            let mask = group.y;
            group.y &= ~(1u << child_bit);
            if group.y > 0x00ffffffu {
                stack[depth] = group;
                depth++;
            }
            let slot = (child_bit - 24u) ^ ray.octant;
            let child = group.x + countOneBits(mask & ~(0xffffffffu << slot));
            let found = intersect_node(child, ray, hit.t);
            group = found.xz;
            first = found.y;
            pending = found.w;
        } else {
            group = vec2u(0u);
        }
        var entered = OUTSIDE;
        while pending != 0u {
            let bit = firstLeadingBit(pending);
            pending &= ~(1u << bit);
            let stored = first + bit;
            let triangle = triangles[stored];
            if (triangle.material_flags & TRIANGLE_INSTANCE) != 0u {
                entered = triangle.light;
                break;
            }
            var index = stored;
#if counted
            looked_at.y++;
#endif
            var v0 = triangle.v0;
            var v1 = triangle.v1;
            var v2 = triangle.v2;
            if way_out != OUTSIDE {
                index += instance.shift;
                v0 = instance_point(instance, v0);
                v1 = instance_point(instance, v1);
                v2 = instance_point(instance, v2);
            }
            let candidate = intersect_triangle(sheared, v0, v1, v2, hit.t);
            var found_hit = candidate.t > 0.0;
            if found_hit && way_out != OUTSIDE {
                // The host leaves out what has no area in unit space.
                found_hit = any(cross((v1 - v0) * 0x1p40, (v2 - v0) * 0x1p40) != vec3f(0.0));
            }
#if alpha
            if found_hit && (triangle.material_flags & TRIANGLE_ALPHA) != 0u {
                found_hit = is_present(index, candidate.b1, candidate.b2);
            }
#endif
#if culling
            found_hit = found_hit && !is_culled(index, direction);
#endif
            if found_hit {
                hit = RayHit(candidate.t, index, candidate.b1, candidate.b2);
#if any_hit
                return hit;
#endif
            }
        }
        if entered != OUTSIDE {
            if group.y > 0x00ffffffu {
                stack[depth] = group;
                depth++;
            }
            if pending != 0u {
                stack[depth] = vec2u(first, pending);
                depth++;
            }
            instance = instances[entered];
            way_out = depth;
            ray = instance_ray(instance, origin, direction);
            group = vec2u(instance.root, 0x80000000u);
            continue;
        }
        if group.y <= 0x00ffffffu {
            if depth == way_out {
                way_out = OUTSIDE;
                ray = box_ray(origin, direction);
            }
            if depth == 0u {
                break;
            }
            depth--;
            group = stack[depth];
        }
    }
#if coincident
#if !any_hit
    if hit.triangle != NO_TRIANGLE && !is_instanced(hit.triangle) {
        return in_front(sheared, direction, hit);
    }
#endif
#endif
    return hit;
}
