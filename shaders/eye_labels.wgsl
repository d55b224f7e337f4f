#import bind/accel
#import bind/queue
#import bind/subspace_mis
#import lib/subpath
#import lib/subspaces

// Classifies the vertices that eye paths have just reached, as ends of eye and of light sub-paths.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in || hits[index].triangle == NO_TRIANGLE {
        return;
    }
    let ray = paths_in[index];
    let hit = hits[index];
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let world_from = eye_path_vertex(point, ray, sub_paths_in[index]).world_from;
    eye_labels[index].x = vertex_label(TREE_EYE, point, world_from);
#if !subspace_directions
    eye_labels[index].y = vertex_label(TREE_LIGHT, point, world_from);
#endif
}
