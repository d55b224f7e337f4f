#import bind/batch
#import bind/buckets
#import bind/light_cache
#import bind/subspaces

// How many vertices of each light subspace each run of the cache has.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let run = id.x;
    if run >= RUNS {
        return;
    }
    for (var label = 0u; label < SUBSPACES; label++) {
        bucket_ends[label * RUNS + run] = 0u;
    }
    let vertices = light_path_offsets[batch.light_path_count];
    let length = (vertices + RUNS - 1u) / RUNS;
    for (var i = min(run * length, vertices); i < min((run + 1u) * length, vertices); i++) {
        let label = light_vertices[light_order[i]].number_label >> 16u;
        bucket_ends[label * RUNS + run]++;
    }
}
