#import bind/batch
#import bind/queue
#import bind/records
#import lib/hit

// The vertices that the eye paths of records have just reached become records, where connections can end.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    let ray = paths_in[index];
    let hit = hits[index];
    let depth = ray.depth_medium & 0xffffu;
    if hit.triangle == NO_TRIANGLE || depth + 2u > batch.max_depth {
        return;
    }
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    if (materials[point.material].flags & (MATERIAL_DELTA | MATERIAL_UNLIT)) != 0u {
        return;
    }
    // The eye sees light on its own side only, but where some passes through.
    var sides = select(RECORD_BACK, RECORD_FRONT, dot(ray.direction, point.world_ng) < 0.0);
#if transmission
    if materials[point.material].transmission > 0.0 {
        sides = RECORD_FRONT | RECORD_BACK;
    }
#endif
    let slot = atomicAdd(&found_count, 1u);
    if slot < arrayLength(&found_records) {
        let path = batch.first_pixel + ray.path;
        found_records[slot] =
            Record(point.position, hit.triangle, hit.b1, hit.b2, path, depth | sides, 0.0, 0.0, 0u, 0u);
    }
}
