#import bind/accel
#import bind/queue
#import lib/hit
#import lib/medium
#import lib/strategies

// Connects the vertices that light paths have just reached to the camera (t = 1).

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    let ray = paths_in[index];
    let hit = hits[index];
    let depth = ray.depth_medium & 0xffffu;
    let wanted = batch.only_s == EVERY_STRATEGY || (batch.only_s == depth + 1u && batch.only_t == 1u);
    if hit.triangle == NO_TRIANGLE || depth + 1u > batch.max_depth || !wanted {
        return;
    }
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let view = camera_view(point.position);
    if view.pixel == NO_PIXEL || (materials[point.material].flags & (MATERIAL_DELTA | MATERIAL_UNLIT)) != 0u {
        return;
    }
#if culling
    let from_behind = dot(view.direction, point.world_ng) < 0.0;
#if instances
    if from_behind && (triangles[stored_triangle(hit.triangle)].material_flags & TRIANGLE_CULLED) != 0u {
#else
    if from_behind && (triangles[hit.triangle].material_flags & TRIANGLE_CULLED) != 0u {
#endif
        return;
    }
#endif
    var vertex = light_path_vertex(point, ray, sub_paths_in[index]);
    let medium = medium_between(ray.depth_medium >> 16u, point, vertex.world_from);
    let throughput = ray.throughput * transmittance(medium, hit.t);
    let mis = load_light_mis(index);
    vertex.edge = edge_towards(point, vertex, mis, view.direction, throughput);
    let connection = connect_camera(point, seen_by_camera(vertex, mis), view, nominal_of(mis));
    let weight = select(1.0, connection.weight, batch.weighted != 0u);
    let medium_to_camera = medium_towards(point, view.direction);
    let through = transmittance(medium_to_camera, view.distance);
    let contribution = throughput * through * connection.light * weight;
    if !any(contribution != vec3f(0.0)) {
        return;
    }
    shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = ShadowRay(
        ray_origin(point, view.direction),
        view.pixel,
        view.direction * view.distance,
        1.0 - 0x1p-20,
        contribution,
        depth,
    );
}
