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
#if subspaces
#import lib/subspaces
#endif

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
    var arrival = arrive(point, ray.direction, ray.pdf_solid, sub_paths_in[index]);
    let medium = medium_between(ray.depth_medium >> 16u, point, arrival.world_from);
    let throughput = ray.throughput * transmittance(medium, hit.t);
    let surface = point_surface(point);
    let is_delta = (surface.flags & SURFACE_DELTA) != 0u;
#if subspaces
    let share = shares_in[index];
    let column = bitcast<u32>(share.w);
    let label = vertex_label(TREE_LIGHT, point, arrival.world_from);
#if subspace_directions
    // Waits for the direction on.
    arrival.edge = 0.0;
#else
    arrival.edge = light_edge(point, arrival.world_from, share.x, column);
#endif
#else
    let label = 0u;
#endif
#if light_cache
#if learns
    // Who learns needs the whole sub-path; what has no weight is never drawn.
    let stored = depth + 2u <= batch.max_depth;
    let weight = select(throughput, vec3f(0.0), is_delta);
#else
    let stored = depth + 2u <= batch.max_depth && !is_delta;
    let weight = throughput;
#endif
    if stored {
        let light_path = batch.first_light_path + ray.path;
        let number = light_path_lengths[light_path];
        light_path_lengths[light_path] = number + 1u;
        atomicMax(&counts.longest_light_path, number + 1u);
        let slot = atomicAdd(&counts.light_vertices, 1u);
        if slot < arrayLength(&light_vertices) {
            let place = vec2u(light_path, number | (label << 16u));
            light_vertices[slot] = surface_vertex(point, surface, arrival, weight, depth, place);
#if learns
            light_backs[slot] = share.y;
#endif
#if subspace_directions
            light_vertices[slot].edge = share.x;
            light_vertices[slot].depth_kind |= column << 20u;
#endif
        }
    }
#endif
    // The vertex to come needs room for an eye vertex, or for the camera alone.
    let room = select(2u, 1u, batch.camera_paths > 0.0);
    if depth + 1u + room > batch.max_depth {
        return;
    }
    let u = path_uniform4(ray.path, bounce_dimension(depth, DIMENSION_BSDF));
    var departure = sample_departure(point, surface, point_frame(point), arrival, u, false);
#if subspace_directions
    if !is_delta {
        departure.next.ratio += light_edge(point, departure.direction, share.x, column) / arrival.pdf_area;
    }
#endif
    let slot_out = send_on(ray.path, depth, point, departure, throughput);
    if slot_out == PATH_ENDS {
        return;
    }
#if subspaces
    shares_out[slot_out] = light_share(select(throughput, vec3f(0.0), is_delta), label);
#if learns
    shares_out[slot_out].y = departure.pdf_back_solid * arrival.to_previous;
#endif
#endif
}
