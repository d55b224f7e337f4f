#import bind/batch
#import bind/buckets
#import bind/light_cache
#import bind/queue
#import lib/color

// How many vertices of each light subspace each run of the cache has.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let run = id.x;
    if run >= RUNS {
        return;
    }
    for (var label = 0u; label < batch.subspaces; label++) {
        bucket_ends[label * RUNS + run] = 0u;
    }
    let range = run_range(run, light_path_offsets[batch.light_path_count]);
    for (var i = range.x; i < range.y; i++) {
        let vertex = light_vertices[light_order[i]];
        if is_drawable(arriving(vertex)) {
            bucket_ends[label_of(vertex) * RUNS + run]++;
        } else if !is_finite3(vec3f(arriving(vertex))) {
            atomicAdd(&counts.non_finite_vertices, 1u);
        }
    }
}
