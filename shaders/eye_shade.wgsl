#import bind/accel
#import bind/queue
#import lib/advance
#import lib/hit
#import lib/medium
#import lib/path_key
#import lib/subpath
#if lights
#import lib/strategies
#endif
#if learns
#import lib/training
#endif

// An eye path's next surface: light that it found by chance, with its weight, and the path goes on.

fn add_radiance(path: u32, depth: u32, light: vec3f, weight: f32) {
    if (batch.only_s != EVERY_STRATEGY) && (batch.only_s != 0u || batch.only_t != depth + 2u) {
        return;
    }
    radiance[path * CELLS] += vec4f(light * select(1.0, weight, batch.weighted != 0u), 0.0);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    let ray = paths_in[index];
    let hit = hits[index];
    let previous = sub_paths_in[index];
    let depth = ray.depth_medium & 0xffffu;
#if lights
    var shares: EyeShares;
#if subspaces
    shares = EyeShares(shares_in[index], eye_labels[index]);
#endif
#endif
    if hit.triangle == NO_TRIANGLE {
#if environment
        let weight = environment_weight(previous, shares, ray.direction, ray.pdf_solid);
        let sky = environment_radiance(ray.direction);
#if learns
        if depth > 0u {
            let cosine = abs(dot(ray.direction, previous.normal));
            let at = sphere_to_square(ray.direction);
            write_hit(ray, sky, vec3f(1.0), weight, ray.pdf_solid, cosine, ENVIRONMENT_LIGHT, at);
        }
#else
        add_radiance(ray.path, depth, ray.throughput * sky, weight);
#endif
#endif
        return;
    }
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let arrival = arrive(point, ray.direction, ray.pdf_solid, previous);
    let medium = medium_between(ray.depth_medium >> 16u, point, arrival.world_from);
    let through = transmittance(medium, hit.t);
    let throughput = ray.throughput * through;
#if learns
    let arriving = PathRay(ray.origin, ray.path, ray.direction, ray.pdf_solid, throughput, ray.depth_medium);
    let geometry = abs(dot(arrival.world_from, point.world_ng)) * arrival.to_previous;
#endif
#if lights
#if subspaces
    shares.share = vec4f(shares.share.rgb * through, shares.share.w);
#endif
#endif
#if area_lights
    let light_index = triangles[hit.triangle].light;
    if light_index != 0u {
        let weight = emitter_weight(point, arrival, shares, light_index - 1u);
        let emission = point_emission(point, arrival.world_from);
#if learns
        if depth > 0u {
            let light = light_index - 1u;
            write_hit(arriving, emission, through, weight, arrival.pdf_area, geometry, light, point.b.yz);
        }
#else
        add_radiance(ray.path, depth, throughput * emission, weight);
#endif
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
    let departure = sample_departure(point, point_surface(point), point_frame(point), arrival, u, true);
    let f = departure_f(point, departure);
    let is_delta = (materials[point.material].flags & MATERIAL_DELTA) != 0u;
#if learns
    write_vertex(point, arrival, ray.path, depth, is_delta, f * through, geometry);
#endif
    let slot = send_on(ray.path, depth, point, departure, throughput);
    if slot == PATH_ENDS {
        return;
    }
#if lights
#if subspaces
    shares_out[slot] = departing_share(point, arrival, shares, departure.direction, f, is_delta);
#endif
#endif
}
