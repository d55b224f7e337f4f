#if ray_query
enable wgpu_ray_query;
#endif
#import bind/queue
#import lib/math
#import lib/traverse
#if alpha
#import lib/path_key
#endif

// Finds where every waiting path meets its next surface.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
#if alpha
    let depth = paths_in[index].depth_medium & 0xffffu;
    alpha_word = random4(path_key(paths_in[index].path), bounce_dimension(depth, DIMENSION_ALPHA)).x;
#endif
#if culling
    camera_way = select(0.0, 1.0, (paths_in[index].depth_medium & 0xffffu) == 0u);
#endif
    let hit = trace(paths_in[index].origin, paths_in[index].direction, MAX_FLOAT);
#if counted
    ray_counts[index] = looked_at;
#endif
    hits[index] = Hit(hit.t, hit.triangle, hit.b1, hit.b2);
}
