#import bind/accel
#import lib/intersect
#import lib/math
#if coincident
#if !any_hit
#import lib/coincident
#endif
#endif
#if alpha
#import lib/alpha
#endif
#if culling
#import lib/culling
#endif

// One traversal for both questions: the closest hit, and (`#if any_hit`) whether there is a hit at all.
// Ylitie et al. 2017; the node layout and the order of its bits are those of obvhs.

struct RayHit {
    t: f32,
    triangle: u32,
    b1: f32,
    b2: f32,
}

#if counted
#import bind/ray_counts

/// Of the ray so far.
var<private> looked_at: vec2u;
#endif
#if !ray_query
/// The stack holds at most one group of siblings for each level of the tree; the host checks the depth.
#if deep_tree
const STACK_SIZE: u32 = 64u;
#else
const STACK_SIZE: u32 = 16u;
#endif

/// The ray in the form that a node's test wants.
struct BoxRay {
    origin: vec3f,
    inv_direction: vec3f,
    negative: vec3<bool>,
    /// 7 minus the octant: children nearer along the ray get the higher bits.
    octant: u32,
#if instances
    /// Along the ray: what the boxes of a mesh's tree are larger by.
    room: vec3f,
#endif
}

fn box_ray(origin: vec3f, direction: vec3f) -> BoxRay {
    // A zero component becomes tiny: its slab is then entered before and left after everything else, without the
    // NaN of 0 * infinity. 2^-80 squared still does not underflow the products below.
    let tiny = vec3f(0x1p-80);
    let safe = select(direction, select(tiny, -tiny, direction < vec3f(0.0)), abs(direction) < tiny);
    let negative = safe < vec3f(0.0);
    let octant = select(0u, 1u, negative.x) * 4u + select(0u, 1u, negative.y) * 2u + select(0u, 1u, negative.z);
#if instances
    return BoxRay(origin, 1.0 / safe, negative, 7u - octant, vec3f(0.0));
#else
    return BoxRay(origin, 1.0 / safe, negative, 7u - octant);
#endif
}

fn bytes(word: u32) -> vec4f {
    return vec4f(unpack4xU8(word));
}

/// The bits of four children that the ray enters before `t_max`; `octant` in every byte. The byte of a child in `meta4`: its
/// number of triangles in unary, 3 bits, and where they begin, 5 bits of less than 24; or 001, 11 and the slot of an inner one.
fn children4(meta4: u32, octant: u32, near: vec4f, far: vec4f) -> u32 {
    let is_inner = meta4 & (meta4 << 1u) & 0x10101010u;
    let bit = unpack4xU8((meta4 ^ (octant & ((is_inner >> 4u) * 7u))) & 0x1f1f1f1fu);
    let info = unpack4xU8((meta4 >> 5u) & 0x07070707u);
    let bits = select(vec4u(0u), info << bit, near <= far);
    return (bits.x | bits.y) | (bits.z | bits.w);
}

/// A node's children as bits: inner ones in the high byte by order of visit, triangles in the low 24.
fn intersect_node(node: u32, ray: BoxRay, t_max: f32) -> vec4u {
#if counted
    looked_at.x++;
#endif
    let words = nodes[node];
    let n0 = words.n0;
    let n1 = words.n1;
    let exponents = vec3f(
        bitcast<f32>((n0.w & 0xffu) << 23u),
        bitcast<f32>(((n0.w >> 8u) & 0xffu) << 23u),
        bitcast<f32>(((n0.w >> 16u) & 0xffu) << 23u),
    );
    let scale = exponents * ray.inv_direction;
    let start = (bitcast<vec3f>(n0.xyz) - ray.origin) * ray.inv_direction;
    // Rounding may not close a box: each slab grows by more than the error of the sums below.
#if instances
    let slack = (abs(start) + 255.0 * abs(scale)) * 0x1p-22 + ray.room;
#else
    let slack = (abs(start) + 255.0 * abs(scale)) * 0x1p-22;
#endif
    let start_near = start - slack;
    let start_far = start + slack;
    let x = select(words.n2, words.n2.zwxy, ray.negative.x);
    let y = select(words.n3, words.n3.zwxy, ray.negative.y);
    let z = select(words.n4, words.n4.zwxy, ray.negative.z);
    let octant = ray.octant * 0x01010101u;
    var hits = 0u;
    {
        let near_x = bytes(x.x) * scale.x + start_near.x;
        let near_y = bytes(y.x) * scale.y + start_near.y;
        let near_z = bytes(z.x) * scale.z + start_near.z;
        let far_x = bytes(x.z) * scale.x + start_far.x;
        let far_y = bytes(y.z) * scale.y + start_far.y;
        let far_z = bytes(z.z) * scale.z + start_far.z;
        let near = larger4(larger4(near_x, near_y), larger4(near_z, vec4f(0.0)));
        let far = smaller4(smaller4(far_x, far_y), smaller4(far_z, vec4f(t_max)));
        hits |= children4(n1.z, octant, near, far);
    }
    {
        let near_x = bytes(x.y) * scale.x + start_near.x;
        let near_y = bytes(y.y) * scale.y + start_near.y;
        let near_z = bytes(z.y) * scale.z + start_near.z;
        let far_x = bytes(x.w) * scale.x + start_far.x;
        let far_y = bytes(y.w) * scale.y + start_far.y;
        let far_z = bytes(z.w) * scale.z + start_far.z;
        let near = larger4(larger4(near_x, near_y), larger4(near_z, vec4f(0.0)));
        let far = smaller4(smaller4(far_x, far_y), smaller4(far_z, vec4f(t_max)));
        hits |= children4(n1.w, octant, near, far);
    }
    // child base, triangle base, inner children with the mask of all inner ones, triangles
    return vec4u(n1.x, n1.y, (hits & 0xff000000u) | (n0.w >> 24u), hits & 0x00ffffffu);
}

#endif
#if coincident
#if !any_hit
/// What the ray meets where it meets `hit`: of the surfaces in that plane the one in front.
fn in_front(ray: ShearedRay, direction: vec3f, hit: RayHit) -> RayHit {
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let limits = covers_at(hit.triangle, vec2f(hit.b1, hit.b2), dot(direction, point.world_ng) < 0.0);
    for (var entry = limits.x; entry < limits.y; entry++) {
        let index = covers[entry];
        let other = triangles[index];
        let found = intersect_triangle(ray, other.v0, other.v1, other.v2, MAX_FLOAT);
        var found_hit = found.t > 0.0;
#if alpha
        if found_hit && (other.material_flags & TRIANGLE_ALPHA) != 0u {
            found_hit = is_present(index, found.b1, found.b2);
        }
#endif
        if found_hit {
            return RayHit(found.t, index, found.b1, found.b2);
        }
    }
    return hit;
}
#endif
#endif

#if ray_query
#import lib/ray_query
#else
#if instances
#import lib/two_levels
#else
/// The hit closest to the origin among t in (0, t_max), or, with `any_hit`, the first one found.
fn trace(origin: vec3f, direction: vec3f, t_max: f32) -> RayHit {
    let sheared = shear_ray(origin, direction);
    let ray = box_ray(origin, direction);
    var hit = RayHit(t_max, NO_TRIANGLE, 0.0, 0.0);
    // A group: index of the first child, and bits: unvisited children above, the node's inner mask below.
    var stack: array<vec2u, STACK_SIZE>;
    var depth = 0u;
    var group = vec2u(0u, 0x80000000u);
    loop {
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
        var pending = found.w;
        // Tested at its end: software devices run the body of a `while` once more, for no ray at all.
        if pending != 0u {
            loop {
                let bit = firstLeadingBit(pending);
                pending &= ~(1u << bit);
                let index = found.y + bit;
                let triangle = triangles[index];
#if counted
                looked_at.y++;
#endif
                let candidate = intersect_triangle(sheared, triangle.v0, triangle.v1, triangle.v2, hit.t);
                var found_hit = candidate.t > 0.0;
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
                continuing {
                    break if pending == 0u;
                }
            }
        }
        if group.y <= 0x00ffffffu {
            if depth == 0u {
                break;
            }
            depth--;
            group = stack[depth];
        }
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
#endif
#endif
