#import lib/math

// Ray against triangle and against the boxes of a wide node.

/// What a ray needs at every triangle: its direction sheared onto the axis it runs along most.
struct ShearedRay {
    origin: vec3f,
    shear: vec3f,
    /// 0, 1, 2: the axis of the largest component of the direction.
    axis: u32,
}

struct TriangleHit {
    /// Distance; negative where the ray misses.
    t: f32,
    b1: f32,
    b2: f32,
}

/// Turns the axis into z; a rotation of the components, so the handedness stays.
fn rotate_axis(v: vec3f, axis: u32) -> vec3f {
    return select(select(v, v.zxy, axis == 1u), v.yzx, axis == 0u);
}

fn shear_ray(origin: vec3f, direction: vec3f) -> ShearedRay {
    let size = abs(direction);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
    let rotated = rotate_axis(direction, axis);
    let inv_z = 1.0 / rotated.z;
    return ShearedRay(origin, vec3f(rotated.xy * inv_z, inv_z), axis);
}

/// Woop, Benthin and Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013, with one change: the vertices
/// come sorted (src/accel/mod.rs), so the two triangles at an edge compute its edge function from the same numbers
/// in the same order, and get the same value even where a driver contracts to fused operations. That is what
/// their double precision is for; here it is not needed.
///
/// A distance within its own rounding of zero is no hit: on slivers that rounding exceeds the step by which rays
/// leave their surface (N-07). pbrt-v4 has the same test with bounds of the worst case (section 6.8, Avoiding
/// Intersections Behind Ray Origins). Depths count from the nearest vertex, so far triangles lose nothing.
///
/// Edge functions know a distance to 2^-23 of the triangle's size. Where surfaces are nearer to each other than that
/// (`thin_gaps`), the distance is that of the triangle's plane, whose rounding is nothing where the plane is along two axes.
fn intersect_triangle(ray: ShearedRay, v0: vec3f, v1: vec3f, v2: vec3f, t_max: f32) -> TriangleHit {
    let r0 = rotate_axis(v0 - ray.origin, ray.axis);
    let r1 = rotate_axis(v1 - ray.origin, ray.axis);
    let r2 = rotate_axis(v2 - ray.origin, ray.axis);
    let p0 = r0.xy - ray.shear.xy * r0.z;
    let p1 = r1.xy - ray.shear.xy * r1.z;
    let p2 = r2.xy - ray.shear.xy * r2.z;
    // Each edge runs from the lower to the higher vertex: 0 to 1, 1 to 2, 0 to 2.
    let w2 = p0.x * p1.y - p0.y * p1.x;
    let w0 = p1.x * p2.y - p1.y * p2.x;
    let w1 = -(p0.x * p2.y - p0.y * p2.x);
    let determinant = w0 + w1 + w2;
    let inside = all(vec3f(w0, w1, w2) >= vec3f(0.0)) || all(vec3f(w0, w1, w2) <= vec3f(0.0));
    let inv_determinant = 1.0 / determinant;
#if thin_gaps
    let e1 = rotate_axis(v1 - v0, ray.axis);
    let e2 = rotate_axis(v2 - v0, ray.axis);
    let normal = edge_product(e1, e2, rotate_axis(v2 - v1, ray.axis));
    // Each component's products without their signs: bounds it and, times a rounding, its error.
    let bound = abs(e1.yzx) * abs(e2.zxy) + abs(e1.zxy) * abs(e2.yzx);
    let bounds = vec3f(dot(bound, abs(r0)), dot(bound, abs(r1)), dot(bound, abs(r2)));
    let nearest = select(
        select(r2, r1, bounds.y <= bounds.z), r0, bounds.x <= min(bounds.y, bounds.z));
    let rounding = 0x1p-21 * min(bounds.x, min(bounds.y, bounds.z));
    let scaled_t = dot(normal, nearest);
    let t = scaled_t * ray.shear.z / dot(normal, vec3f(ray.shear.xy, 1.0));
#else
    let scaled_t = w0 * r0.z + w1 * r1.z + w2 * r2.z;
    let t = scaled_t * ray.shear.z * inv_determinant;
    let extent = larger4(abs(vec4f(p0, p1)), abs(vec4f(p2, p2)));
    let width = larger(larger(extent.x, extent.z), larger(extent.y, extent.w));
    let depth = larger(r0.z, larger(r1.z, r2.z)) - smaller(r0.z, smaller(r1.z, r2.z));
    let rounding = 0x1p-22 * width * (width + depth) * depth;
#endif
    let hit = inside && determinant != 0.0 && abs(scaled_t) > rounding && t > 0.0 && t < t_max;
    return TriangleHit(select(-1.0, t, hit), w1 * inv_determinant, w2 * inv_determinant);
}
