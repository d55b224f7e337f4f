#import bind/accel
#import bind/queue
#import lib/advance
#import lib/deliver
#import lib/hit
#import lib/medium
#import lib/path_key
#import lib/strategies
#import lib/subpath
#import lib/weights

// An eye path's next surface: light that it found by chance, with its weight, and the path goes on.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    var ray = paths_in[index];
    let hit = hits[index];
    let previous = sub_paths_in[index];
    let depth = ray.depth_medium & 0xffffu;
    var partials = load_eye_partials(index, depth);
    if hit.triangle == NO_TRIANGLE {
#if environment
#if transparent
        if depth == 0u {
            return;
        }
#endif
        let weight = environment_weight(previous, partials, ray.direction, ray.pdf_solid);
        deliver_sky(ray, previous, depth, environment_radiance(ray.direction), weight);
#endif
        return;
    }
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let vertex = eye_path_vertex(point, ray, previous);
    let medium = medium_between(ray.depth_medium >> 16u, point, vertex.world_from);
    let through = transmittance(medium, hit.t);
    ray.throughput *= through;
    partials = absorb(partials, through);
#if area_lights
#if instances
    let light_index = triangles[stored_triangle(hit.triangle)].light;
#else
    let light_index = triangles[hit.triangle].light;
#endif
    if light_index != 0u {
        let weight = emitter_weight(point, vertex, partials, light_index - 1u);
        let emission = point_emission(point, vertex.world_from);
        deliver_emitter(ray, point, vertex, depth, emission, through, weight, light_index - 1u);
    }
#endif
    if depth + 1u >= batch.max_depth {
        return;
    }
#if unlit
    if (materials[point.material].flags & MATERIAL_UNLIT) != 0u {
        return;
    }
#endif
    let u = path_uniform4(ray.path, bounce_dimension(depth, DIMENSION_BSDF));
    let bounce = sample_bounce(point, point_surface(point), point_frame(point), vertex, u, true, 0u);
    let f = bounce_f(point, bounce);
    let is_delta = (materials[point.material].flags & MATERIAL_DELTA) != 0u;
    deliver_vertex(ray, point, vertex, depth, f, through, is_delta);
    let slot = enqueue(ray.path, depth, point, bounce, ray.throughput);
    if slot == PATH_ENDS {
        return;
    }
    let pdf_back = bounce.pdf_back_solid * vertex.to_previous;
    store_eye_mis(slot, eye_mis_of_bounce(point, vertex, partials, bounce.direction, f, pdf_back, is_delta));
}
