#import bind/eye_records
#import bind/queue
#import lib/hit
#import lib/nearest_records

// Finds the records nearest to the vertices that eye paths have just reached.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in || hits[index].triangle == NO_TRIANGLE {
        return;
    }
    let hit = hits[index];
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    if (materials[point.material].flags & (MATERIAL_DELTA | MATERIAL_UNLIT)) == 0u {
        eye_records[index] = vec4u(nearest_records(point.position), 0u);
    }
}
