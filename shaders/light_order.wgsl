#import bind/light_cache
#import bind/queue

// The cache's order by light path and number, which does not change from run to run as that of its slots does.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let slot = invocation(id);
    if slot >= min(atomicLoad(&counts.light_vertices), arrayLength(&light_vertices)) {
        return;
    }
    light_order[light_path_offsets[light_vertices[slot].path] + number_of(light_vertices[slot])] = slot;
}
