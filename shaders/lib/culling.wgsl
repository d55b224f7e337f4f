#import lib/hit

// Backs that the camera looks through. Rays of the camera alone cull them, from it and to it: light meets every surface
// from both sides, so that all ways to find a path agree on what is in its way.

/// 1 for a ray that the camera sends, -1 for one that ends at it, 0 for all others; set before `trace`.
var<private> camera_way: f32;

/// True where the ray passes.
fn is_culled(triangle: u32, direction: vec3f) -> bool {
#if instances
    if camera_way == 0.0 || (triangles[stored_triangle(triangle)].material_flags & TRIANGLE_CULLED) == 0u {
#else
    if camera_way == 0.0 || (triangles[triangle].material_flags & TRIANGLE_CULLED) == 0u {
#endif
        return false;
    }
    return dot(surface_point(triangle, 0.0, 0.0).world_ng, direction) * camera_way > 0.0;
}
