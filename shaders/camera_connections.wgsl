#import bind/accel
#import bind/queue
#import lib/camera
#import lib/hit
#import lib/medium
#import lib/subpath

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
    let arrival = arrive(point, ray.direction, ray.pdf_solid, sub_paths_in[index]);
    let surface = point_surface(point);
    let value = shading_evaluate(surface, point_frame(point), arrival.world_from, view.direction, false);
    if !any(value.f > vec3f(0.0)) {
        return;
    }
    let pdf_eye = abs(dot(view.direction, point.world_ng)) * view.pdf_area;
    var weight = 1.0;
    if batch.weighted != 0u {
        let step = arrival_step(arrival, value.pdf_back_solid * survival(surface), false);
        weight = connection_weight(batch.camera_paths, 0.0, 0.0, step, pdf_eye);
    }
    let medium = medium_between(ray.depth_medium >> 16u, point, arrival.world_from);
    let medium_to_camera = medium_towards(point, view.direction);
    let through = transmittance(medium, hit.t) * transmittance(medium_to_camera, view.distance);
    let light = ray.throughput * through * value.f;
    let contribution = light * (pdf_eye * weight / f32(batch.light_path_count));
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
