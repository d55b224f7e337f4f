#if ray_query
enable wgpu_ray_query;
#endif
#import bind/accel
#import bind/light_ends
#import bind/queue
#import bind/subpath
#import lib/hit
#import lib/record_edge

// What it would be worth to connect the vertices that light paths have just reached, as eye vertices, to the vertices before
// (lib/weights_at_records): three rays each.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    let hit = hits[index];
    let slot = light_ends_in[index];
    var edge = 0.0;
    // A cache that is full is filled once more, with more room.
    let is_kept = (sub_paths_in[index].flags & SUBPATH_DELTA) == 0u && slot < arrayLength(&light_vertices);
    if hit.triangle != NO_TRIANGLE && is_kept {
        let point = surface_point(hit.triangle, hit.b1, hit.b2);
        if (materials[point.material].flags & (MATERIAL_DELTA | MATERIAL_UNLIT)) == 0u {
            let near = nearest_records(point.position);
            edge = record_edge(point, near, light_at_records(near, light_vertices[slot]));
        }
    }
    light_edges[index] = edge;
}
