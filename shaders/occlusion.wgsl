#if ray_query
enable wgpu_ray_query;
#endif
#import bind/queue
#import lib/traverse
#if alpha
#import lib/path_key
#endif
#if splats_atomic
#import bind/batch
#import lib/splat
#endif

// Tests the connections of a bounce; those that nothing blocks reach their path's radiance.
// A connection slot has one connection at most in the queue, so no two invocations write it.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.shadow_in {
        return;
    }
    let ray = shadow_rays[index];
#if alpha
#if splats_atomic
    // The contribution is as random as the path that it comes from.
    alpha_word = pcg4d(vec4u(bitcast<vec3u>(ray.contribution), ray.slot)).y;
#else
    alpha_word = random4(path_key(ray.slot / CONNECTIONS_IN_FLIGHT), bounce_dimension(ray.depth, DIMENSION_ALPHA)).y
        + counts.connection_round * CONNECTIONS_IN_FLIGHT + ray.slot % CONNECTIONS_IN_FLIGHT;
#endif
#endif
#if culling
#if splats_atomic
    camera_way = -1.0;
#endif
#endif
    let hit = trace(ray.origin, ray.direction, ray.t_max);
#if counted
    ray_counts[index] = looked_at;
#endif
#if film_pages
    // splat_page takes it from here.
    if hit.triangle != NO_TRIANGLE {
        shadow_rays[index].slot = NO_PIXEL;
    }
#else
    if hit.triangle == NO_TRIANGLE {
#if splats_atomic
        add_splat(ray.slot, ray.contribution * batch.splat_scale);
#else
        radiance[ray.slot] += vec4f(ray.contribution, 0.0);
#endif
    }
#endif
}
