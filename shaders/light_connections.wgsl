#import bind/accel
#import bind/light_cache
#import bind/queue
#import lib/deliver
#import lib/hit
#import lib/medium
#import lib/path_key
#if subspaces
#import lib/select_subspaces
#else
#if own_light_path
#import lib/select_own_path
#else
#if at_records
#import lib/select_one_record
#else
#if records
#import lib/select_records
#else
#import lib/select_uniform
#endif
#endif
#endif
#endif
#import lib/strategies
#import lib/weights

// Connects the vertices that eye paths have just reached to vertices of the light cache.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var index = invocation(id);
#if software
    // One invocation for all connections of a vertex, so that the vertex is made once.
    if index < counts.paths_in {
        connect_vertex(index, 0u, CONNECTIONS_IN_FLIGHT);
    }
#else
    // One for each connection. All paths' first connections, then all their second: neighbours do alike.
    var slot = 0u;
    while index >= counts.paths_in && slot < CONNECTIONS_IN_FLIGHT {
        index -= counts.paths_in;
        slot++;
    }
    if slot < CONNECTIONS_IN_FLIGHT {
        connect_vertex(index, slot, slot + 1u);
    }
#endif
}

/// The connections in a path's slots from `first` up to `end`.
fn connect_vertex(index: u32, first: u32, end: u32) {
    let ray = paths_in[index];
    let hit = hits[index];
    let depth = ray.depth_medium & 0xffffu;
    if hit.triangle == NO_TRIANGLE || depth + 2u > batch.max_depth {
        return;
    }
    // How many there are, as far as this is known by now.
#if own_light_path
    let count = light_path_offsets[ray.path + 1u] - light_path_offsets[ray.path];
#else
    let count = connections_at(depth);
#endif
    let number = counts.connection_round * CONNECTIONS_IN_FLIGHT;
    let last = min(end, count - min(number, count));
    if first >= last {
        return;
    }
    let eye_point = surface_point(hit.triangle, hit.b1, hit.b2);
    if (materials[eye_point.material].flags & (MATERIAL_DELTA | MATERIAL_UNLIT)) != 0u {
        return;
    }
    let eye = eye_end(eye_point, eye_path_vertex(eye_point, ray, sub_paths_in[index]));
    let medium = medium_between(ray.depth_medium >> 16u, eye_point, eye.vertex.world_from);
    let through = transmittance(medium, hit.t);
    let arrived = absorb(load_eye_partials(index, depth), through);
    for (var slot = first; slot < last; slot++) {
        connect_slot(index, slot, number + slot, ray, depth, eye, arrived, through);
    }
}

fn connect_slot(
    index: u32, slot: u32, number: u32, ray: PathRay, depth: u32, eye: EyeEnd, arrived: EyePartials, through: vec3f,
) {
    let selection = select_light_vertex(index, ray.path, depth, number, eye.point.material);
    if selection.vertex == NO_VERTEX {
        return;
    }
    let light_vertex = light_vertices[selection.vertex];
    let light_depth = depth_of(light_vertex);
    let kind = kind_of(light_vertex);
    let wanted = batch.only_s == EVERY_STRATEGY
        || (batch.only_s == light_depth + 1u && batch.only_t == depth + 2u);
    if depth + light_depth + 2u > batch.max_depth || !wanted || !any(light_vertex.weight != vec3f(0.0)) {
        return;
    }
    var seen = eye;
#if nominal
    seen.vertex = seen_unguided(eye.vertex, light_nominals[selection.vertex]);
#endif
#if at_records
    let partials = with_choice(arrived, selection.light, selection.choice);
    let alone = weight_alone(partials);
#else
    let partials = arrived;
    let alone = 1.0;
#endif
    let connection = connect(seen, partials, light_vertex);
    let weight = select(alone, connection.weight, batch.weighted != 0u);
    let contribution = ray.throughput * through * connection.light * (weight * selection.inv_density);
    if !any(contribution != vec3f(0.0)) {
        return;
    }
    var shadow = link_ray(eye.point, connection.link, kind);
    shadow.depth = depth;
    deliver_connection(shadow, slot, ray, through, light_vertex, connection, contribution);
}
