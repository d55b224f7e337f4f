#import bind/batch
#import bind/buckets
#import bind/light_cache
#import lib/color

// Sorts the cache by subspace. Within one, the order is that of `light_order`, whatever order the runs work in.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let run = id.x;
    if run >= RUNS {
        return;
    }
    let range = run_range(run, light_path_offsets[batch.light_path_count]);
    for (var i = range.x; i < range.y; i++) {
        let index = light_order[i];
        let vertex = light_vertices[index];
        if is_drawable(arriving(vertex)) {
            let cell = label_of(vertex) * RUNS + run;
            bucket_items[bucket_ends[cell]] = vec2u(index, bitcast<u32>(arriving(vertex)));
            bucket_ends[cell]++;
        }
    }
}
