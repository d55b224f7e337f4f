#import bind/accel
#import bind/queue
#import bind/training
#import lib/advance
#import lib/emission
#import lib/light
#import lib/medium
#import lib/path_key
#import lib/subpath
#import lib/subspaces
#import lib/training

// The path tracer as the source of training paths: what it finds is written down instead of shown. Two ways lead to
// a light, sampling it and hitting it; each path found by either has the density of both.

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
    let can_sample = (previous.flags & SUBPATH_DELTA) == 0u;
    if hit.triangle == NO_TRIANGLE {
#if environment
        if depth > 0u {
            let sampled = select(0.0, environment_pdf_solid(ray.direction), can_sample);
            let weight = 1.0 / (1.0 + sampled / ray.pdf_solid);
            let cosine = abs(dot(ray.direction, previous.normal));
            write_hit(
                ray, environment_radiance(ray.direction), vec3f(1.0), weight, 1.0, ray.pdf_solid, cosine,
                environment_map.light, sphere_to_square(ray.direction),
            );
        }
#endif
        return;
    }
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let vertex = eye_path_vertex(point, ray, previous);
    let medium = medium_between(ray.depth_medium >> 16u, point, vertex.world_from);
    let through = transmittance(medium, hit.t);
    ray.throughput *= through;
    let geometry = abs(dot(vertex.world_from, point.world_ng)) * vertex.to_previous;
#if area_lights
#if instances
    let light_index = triangles[stored_triangle(hit.triangle)].light;
#else
    let light_index = triangles[hit.triangle].light;
#endif
    if light_index != 0u && depth > 0u {
        let sampled = select(0.0, lights[light_index - 1u].pdf_select / point.area, can_sample);
        let emission = point_emission(point, vertex.world_from);
        let weight = 1.0 / (1.0 + sampled / vertex.pdf_area);
        write_hit(ray, emission, through, weight, 1.0, vertex.pdf_area, geometry, light_index - 1u, point.b.yz);
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
    let surface = point_surface(point);
    let frame = point_frame(point);
    let is_delta = (surface.flags & SURFACE_DELTA) != 0u;
    let key = path_key(ray.path);
    let u = path_uniform4(ray.path, bounce_dimension(depth, DIMENSION_BSDF));
    let bounce = sample_bounce(point, surface, frame, vertex, u, true, 0u);
    let f = bounce_f(point, bounce);
    write_vertex(point, vertex, ray.path, depth, is_delta, f * through, geometry);
    if !is_delta {
        let sample = sample_light(
            point,
            random4(key, bounce_dimension(depth, DIMENSION_LIGHT)),
            random4(key, bounce_dimension(depth, DIMENSION_LIGHT_POINT)),
        );
        if sample.pdf_solid > 0.0 {
            let value = shading_evaluate(surface, frame, vertex.world_from, sample.direction, true);
            let hitting = select(value.pdf_solid * survival(surface), 0.0, sample.is_delta);
            let weight = sample.pdf_solid / (sample.pdf_solid + hitting);
            let cosine = abs(dot(sample.direction, point.world_ng));
            let across = transmittance(medium_towards(point, sample.direction), sample.distance);
            let carried = ray.throughput * across * value.f * sample.radiance;
            let contribution = magnitude(carried) * (cosine * weight / sample.pdf_solid);
            if contribution > 0.0 {
                // Turns a density per solid angle into the light's measure.
                var to_light = 1.0;
                if sample.distance < MAX_FLOAT {
                    to_light = sample.cos_light / sample.distance / sample.distance;
                }
                var end: TrainingEnd;
                end.emitted = sample.radiance * (weight / (sample.pdf_solid * to_light));
                end.path = ray.path;
                end.f = value.f * through;
                end.depth_sampled = depth | (1u << 16u);
                end.f_light = across;
                end.vertex = NO_LIGHT_VERTEX;
                end.contribution = contribution;
                end.p0 = 1.0 - weight;
                end.share = 1.0;
                end.geometry = cosine * to_light;
                end.light = sample.light;
                end.at = sample.at;
                end.direction = sample.direction;
                var shadow = light_ray(point, sample, vec3f(1.0), depth);
                shadow.slot = write_end(end);
                if shadow.slot < arrayLength(&training_ends) {
                    shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = shadow;
                }
            }
        }
    }
    enqueue(ray.path, depth, point, bounce, ray.throughput);
}
