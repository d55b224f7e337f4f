#import bind/queue
#import lib/traverse
#if alpha
#import lib/path_key
#endif

// Tests the connections of a bounce; those that nothing blocks reach their path's radiance.
// A path has one connection at most in the queue, so no two invocations write one cell.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.shadow_in {
        return;
    }
    let ray = shadow_rays[index];
#if alpha
    alpha_word = random4(path_key(ray.path), bounce_dimension(ray.depth, DIMENSION_ALPHA)).y;
#endif
    let hit = trace(ray.origin, ray.direction, ray.t_max);
    if hit.triangle == NO_TRIANGLE {
        radiance[ray.path] += vec4f(ray.contribution, 0.0);
    }
}
