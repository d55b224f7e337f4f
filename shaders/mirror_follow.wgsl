#import bind/queue
#import lib/hit
#import lib/medium
#import lib/path_key
#import lib/shading

// Follows camera paths through a mirror or smooth glass by one surface, so that what is seen in it stands in the layers
// albedo and normal: a denoiser would take it for noise otherwise. Paths stay where they are in the queue, so that
// `first_hit` finds them in order; those that have come to their end are met again.
//
// A path that goes on carries in its throughput what the surfaces behind it leave of the light, and in place of a density the
// distance of the first of them. It goes where the picture's own path goes, by the same numbers.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let path = invocation(id);
    if path >= batch.pixel_count * batch.sample_count {
        return;
    }
    let hit = hits[path];
    if hit.triangle == NO_TRIANGLE {
        return;
    }
    let ray = paths_in[path];
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
#if unlit
    if (materials[point.material].flags & MATERIAL_UNLIT) != 0u {
        return;
    }
#endif
    let surface = point_surface(point);
    if (surface.flags & SURFACE_DELTA) == 0u {
        return;
    }
    let world_out = -ray.direction;
    let depth = ray.depth_medium & 0xffffu;
    let through = transmittance(medium_between(ray.depth_medium >> 16u, point, world_out), hit.t);
    let u = path_uniform4(ray.path, bounce_dimension(depth, DIMENSION_BSDF));
    let bounce = shading_sample_direction(surface, point_frame(point), world_out, u.xyz, true);
    if bounce.pdf_solid == 0.0 {
        return;
    }
    paths_in[path] = PathRay(
        ray_origin(point, bounce.w),
        ray.path,
        bounce.w,
        select(hit.t, ray.pdf_solid, depth > 0u),
        ray.throughput * through * bounce.weight,
        (depth + 1u) | (medium_towards(point, bounce.w) << 16u),
    );
    atomicAdd(&counts.paths_out, 1u);
}
