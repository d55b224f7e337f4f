#if ray_query
enable wgpu_ray_query;
#endif
#import bind/accel
#import bind/eye_links
#import bind/queue
#import lib/hit
#import lib/record_edge

// The geometry terms between what eye paths have just reached and the records of the vertex before, with what of them is
// hidden: what weights need of a connection that ends there (lib/weights_at_records).

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    let hit = hits[index];
    let end = eye_ends_in[index];
    var reach = vec3f(0.0);
    var ends_here = hit.triangle != NO_TRIANGLE;
    var vertex = vertex_at(hit.triangle, vec2f(hit.b1, hit.b2));
#if environment
    if !ends_here {
        vertex = vertex_towards(paths_in[index].direction);
        ends_here = true;
    }
#endif
    if end != NO_LINK && ends_here && eye_links[end].scale > 0.0 {
        reach = record_reach(eye_links[end].records, vertex);
    }
    eye_reach[index] = vec4f(reach, 0.0);
}
