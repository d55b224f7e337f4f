#import bind/accel
#import bind/queue
#import lib/advance
#import lib/hit
#import lib/medium
#import lib/path_key
#import lib/subpath
#if light_cache
#import lib/light_vertex
#endif
#import lib/weights

// A light path's next surface: its vertex goes to the cache, and the path goes on.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    let ray = paths_in[index];
    let hit = hits[index];
    if hit.triangle == NO_TRIANGLE {
        return;
    }
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let depth = ray.depth_medium & 0xffffu;
#if unlit
    if (materials[point.material].flags & MATERIAL_UNLIT) != 0u {
        return;
    }
#endif
    var vertex = light_path_vertex(point, ray, sub_paths_in[index]);
    let medium = medium_between(ray.depth_medium >> 16u, point, vertex.world_from);
    let throughput = ray.throughput * transmittance(medium, hit.t);
    let surface = point_surface(point);
    let is_delta = (surface.flags & SURFACE_DELTA) != 0u;
    let mis = load_light_mis(index);
    let label = light_subspace(point, vertex.world_from);
    vertex.edge = edge_so_far(point, vertex, mis, throughput);
#if light_cache
    if depth + 2u <= batch.max_depth && is_kept(is_delta) {
        let weight = select(throughput, vec3f(0.0), is_delta);
        cache_surface_vertex(ray.path, point, surface, vertex, weight, depth, label, mis);
    }
#endif
    // The vertex to come needs room for an eye vertex, or for the camera alone.
    let room = select(2u, 1u, batch.camera_paths > 0.0);
    if depth + 1u + room > batch.max_depth {
        return;
    }
    let u = path_uniform4(ray.path, bounce_dimension(depth, DIMENSION_BSDF));
    var bounce = sample_bounce(point, surface, point_frame(point), vertex, u, false, label);
    var behind = add_edge_of_bounce(&bounce, point, vertex, mis, is_delta);
    let slot = enqueue(ray.path, depth, point, bounce, throughput);
    if slot == PATH_ENDS {
        return;
    }
#if learns
    behind = bounce.pdf_back_solid * vertex.to_previous;
#endif
    let nominal = nominal_of(mis) * bounce.nominal;
    store_light_mis(slot, light_mis_of_bounce(throughput, behind, is_delta, label, nominal));
}
