#import bind/accel
#import bind/queue
#import lib/hit
#import lib/medium
#import lib/path_key
#import lib/roulette
#import lib/shading
#if lights
#import lib/light
#endif

// The path tracer, one surface at a time: emission with its weight, one connection to a light, one bounce.
// Veach 1997, chapter 9 (multiple importance sampling, balance heuristic). Both densities of a direction carry
// the roulette of the surface they leave.

/// Weight of a sample by balance heuristic: its own density against the other technique's.
fn balance(pdf: f32, other: f32) -> f32 {
    // Divided first: the sum of two huge densities overflows.
    return 1.0 / (1.0 + other / pdf);
}

fn add_radiance(path: u32, light: vec3f) {
    radiance[path] += vec4f(light, 0.0);
}

#if lights
/// Queues a connection to a light. `reflected`: throughput times f times cosine; `bsdf_pdf`: density of the direction
/// by the BSDF, roulette included.
fn connect(
    path: u32, depth: u32, point: SurfacePoint, reflected: vec3f, bsdf_pdf: f32, sample: LightSample,
) {
    let weight = select(balance(sample.pdf_solid, bsdf_pdf), 1.0, sample.is_delta);
    let through = transmittance(medium_towards(point, sample.direction), sample.distance);
    let contribution = reflected * through * sample.radiance * (weight / sample.pdf_solid);
    if !any(contribution != vec3f(0.0)) {
        return;
    }
    var shadow = light_ray(point, sample, contribution, depth);
    shadow.slot = path;
    shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = shadow;
}
#endif

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.paths_in {
        return;
    }
    let ray = paths_in[index];
    let hit = hits[index];
    if hit.triangle == NO_TRIANGLE {
#if environment
#if transparent
        if (ray.depth_medium & 0xffffu) == 0u {
            return;
        }
#endif
        var weight = 1.0;
        if ray.pdf_solid > 0.0 {
            weight = balance(ray.pdf_solid, environment_pdf_solid(ray.direction));
        }
        add_radiance(ray.path, ray.throughput * environment_radiance(ray.direction) * weight);
#endif
        return;
    }
    let point = surface_point(hit.triangle, hit.b1, hit.b2);
    let world_out = -ray.direction;
    let depth = ray.depth_medium & 0xffffu;
    let throughput = ray.throughput * transmittance(medium_between(ray.depth_medium >> 16u, point, world_out), hit.t);

#if area_lights
#if instances
    let light_index = triangles[stored_triangle(hit.triangle)].light;
#else
    let light_index = triangles[hit.triangle].light;
#endif
    if light_index != 0u {
        var weight = 1.0;
        if ray.pdf_solid > 0.0 {
            weight = balance(ray.pdf_solid, area_light_pdf_solid(point, light_index - 1u, ray.direction, hit.t));
        }
        add_radiance(ray.path, throughput * point_emission(point, world_out) * weight);
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
    let key = path_key(ray.path);
    let is_delta = (surface.flags & SURFACE_DELTA) != 0u;
    var survives = survival(surface);
    if is_delta {
        // Nothing weighs these paths against light paths: no product has to be the same from both ends, and surfaces that are
        // no mirrors count as well.
        survives = min(survives, run_survival(depth));
    }

    let u = path_uniform4(ray.path, bounce_dimension(depth, DIMENSION_BSDF));
    var bounce = shading_sample_direction(surface, frame, world_out, u.xyz, true);
    if u.w >= survives {
        bounce.pdf_solid = 0.0;
    }
#if lights
    var sample: LightSample;
    if !is_delta {
        sample = sample_light(
            point,
            path_words(ray.path, bounce_dimension(depth, DIMENSION_LIGHT)),
            random4(key, bounce_dimension(depth, DIMENSION_LIGHT_POINT)),
        );
    }
    // First the light's direction, then the bounce's: one call site for the whole BSDF.
    for (var turn = select(0u, 1u, sample.pdf_solid == 0.0); turn < 2u; turn++) {
        let to_light = turn == 0u;
#else
    {
        let to_light = false;
#endif
#if lights
        let direction = select(bounce.w, sample.direction, to_light);
#else
        let direction = bounce.w;
#endif
        var value: BsdfValue;
        if !is_delta && (to_light || bounce.pdf_solid > 0.0) {
            value = shading_evaluate(surface, frame, world_out, direction, true);
        }
        let reflected = value.f * abs(dot(direction, point.world_ng));
#if lights
        if to_light {
            if any(value.f > vec3f(0.0)) {
                connect(ray.path, depth, point, throughput * reflected, value.pdf_solid * survives, sample);
            }
            continue;
        }
#endif
        if !is_delta && bounce.pdf_solid > 0.0 {
            bounce.pdf_solid = value.pdf_solid;
            bounce.weight = select(vec3f(0.0), reflected / value.pdf_solid, value.pdf_solid > 0.0);
        }
    }

    let next_throughput = throughput * bounce.weight / survives;
    if bounce.pdf_solid == 0.0 || !any(next_throughput != vec3f(0.0)) {
        return;
    }
    paths_out[atomicAdd(&counts.paths_out, 1u)] = PathRay(
        ray_origin(point, bounce.w),
        ray.path,
        bounce.w,
        select(bounce.pdf_solid * survives, 0.0, is_delta),
        next_throughput,
        (depth + 1u) | (medium_towards(point, bounce.w) << 16u),
    );
}
