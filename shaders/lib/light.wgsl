#import bind/lights
#import bind/queue
#import lib/alias
#if coincident
#import lib/coincident
#endif
#import lib/hit
#import lib/rng
#import lib/sampling
#if punctual_lights
#import lib/spot
#endif
#if environment
#import lib/environment
#endif

// Sampling a point on a light as seen from a point of the scene, and the density of doing so.

struct LightSample {
    /// Unit direction to the light.
    direction: vec3f,
    /// Length of the connection, MAX_FLOAT to infinity.
    distance: f32,
    /// Radiance along the connection (area, environment), or irradiance (punctual): what f cos is multiplied with
    /// and `pdf_solid` divides.
    radiance: vec3f,
    /// Density per solid angle; for punctual lights the probability of the light.
    pdf_solid: f32,
    /// Where the connection ends, stepped off the light's surface.
    end: vec3f,
    /// A light that no direction can hit by chance.
    is_delta: bool,
    /// Index in `lights`, and the point on the light: barycentrics of a triangle, equal-area square of an environment.
    light: u32,
    at: vec2f,
    /// Cosine at the light; 1 where it has no surface.
    cos_light: f32,
}

#if environment
/// Density of `sample_light` for a direction to the environment.
fn environment_pdf_solid(direction: vec3f) -> f32 {
    return lights[environment_map.light].pdf_select * texel_pdf_solid(environment_radiance(direction));
}
#endif

#if area_lights
/// Density of `sample_light` for the point of an emitting triangle, seen along `direction` over `distance`.
fn area_light_pdf_solid(point: SurfacePoint, light: u32, direction: vec3f, distance: f32) -> f32 {
    let cos_light = abs(dot(direction, point.world_ng));
    return lights[light].pdf_select * distance * distance / (point.area * cos_light);
}
#endif

/// The ray that tests a connection from `point` to a sample.
fn light_ray(point: SurfacePoint, sample: LightSample, contribution: vec3f, depth: u32) -> ShadowRay {
    let origin = ray_origin(point, sample.direction);
    if sample.distance < MAX_FLOAT {
        return ShadowRay(origin, 0u, sample.end - origin, 1.0 - 0x1p-20, contribution, depth);
    }
    return ShadowRay(origin, 0u, sample.direction, MAX_FLOAT, contribution, depth);
}

/// Picks a light by power and a point on it. `words`: which light, then where. pdf_solid 0: nothing to connect to.
fn sample_light(origin: SurfacePoint, words: vec4u, point_words: vec4u) -> LightSample {
    var sample: LightSample;
    let draw = alias_draw(words.xy, arrayLength(&lights));
    let index = alias_pick(draw, lights[draw.slot].threshold, lights[draw.slot].alias_index);
    let light = lights[index];
    sample.light = index;
    sample.cos_light = 1.0;
    let u = vec2f(uniform_from_word(words.z), uniform_from_word(words.w));
    switch light.kind {
#if area_lights
        case LIGHT_TRIANGLE: {
            let b = sample_triangle(u);
            let point = surface_point(light.index, b.y, b.z);
            let towards = point.position - origin.position;
            let start = ray_origin(origin, towards);
            let span = point.position - start;
            let distance = length(span);
            sample.end = ray_end(point, towards, distance);
            if distance > 0.0 {
                sample.direction = span / distance;
                sample.distance = distance;
                sample.radiance = point_emission(point, -sample.direction) * point_presence(point);
                sample.at = b.yz;
                sample.cos_light = abs(dot(sample.direction, point.world_ng));
                if sample.cos_light >= MIN_COS {
                    sample.pdf_solid = area_light_pdf_solid(point, index, sample.direction, distance);
#if coincident
                    sample.radiance *= uncovered(point, -sample.direction);
#endif
                }
            }
        }
#endif
#if environment
        case LIGHT_ENVIRONMENT: {
            let texels = environment_map.size * environment_map.size;
            let slot = alias_draw(point_words.xy, texels);
            let entry = environment_alias[slot.slot];
            let texel = alias_pick(slot, entry.x, entry.y);
            let corner = vec2f(f32(texel % environment_map.size), f32(texel / environment_map.size));
            sample.at = (corner + u) / f32(environment_map.size);
            sample.direction = square_to_sphere(sample.at);
            sample.distance = MAX_FLOAT;
            sample.radiance = texel_radiance(texel);
            sample.pdf_solid = light.pdf_select * texel_pdf_solid(sample.radiance);
        }
#endif
#if punctual_lights
        case LIGHT_DIRECTIONAL: {
            sample.direction = -punctual_lights[light.index].direction;
            sample.distance = MAX_FLOAT;
            sample.radiance = punctual_lights[light.index].intensity;
            sample.pdf_solid = light.pdf_select;
            sample.is_delta = true;
        }
        case LIGHT_POINT, LIGHT_SPOT: {
            let punctual = punctual_lights[light.index];
            let start = ray_origin(origin, punctual.position - origin.position);
            let span = punctual.position - start;
            let distance = length(span);
            if distance > 0.0 {
                sample.direction = span / distance;
                sample.distance = distance;
                sample.end = punctual.position;
                sample.pdf_solid = light.pdf_select;
                sample.is_delta = true;
                var falloff = 1.0;
                if light.kind == LIGHT_SPOT {
                    falloff = spot_falloff(punctual, -sample.direction);
                }
                sample.radiance = punctual.intensity * falloff / distance / distance;
            }
        }
#endif
        default: {}
    }
    return sample;
}
