#import bind/lights
#import bind/subpath
#if light_guide
#import bind/subspaces
#endif
#import lib/alias
#if coincident
#import lib/coincident
#endif
#import lib/frame
#import lib/guide
#import lib/hit
#import lib/rng
#import lib/sampling
#if punctual_lights
#import lib/spot
#endif
#if environment
#import lib/environment
#endif

// Light from the light's side: points on lights, and the rays that leave them. `lib/light` samples the same
// points as seen from a surface; both have the same densities.

/// Radius of the disk that parallel light passes on its way to the scene, which lies around the origin.
const SCENE_RADIUS: f32 = 1.0;

/// Density per area, across the direction, of parallel light.
fn disk_pdf_area() -> f32 {
    return INV_PI / (SCENE_RADIUS * SCENE_RADIUS);
}

/// Sides that a surface emits from.
fn emitting_sides(point: SurfacePoint) -> f32 {
    return select(1.0, 2.0, (materials[point.material].flags & MATERIAL_DOUBLE_SIDED) != 0u);
}

/// Density per solid angle of the directions in which a surface emits; 0 where it does not.
fn emission_pdf_solid(point: SurfacePoint, direction: vec3f) -> f32 {
    let sides = emitting_sides(point);
    let cosine = dot(direction, point.world_ng);
    return max(select(cosine, abs(cosine), sides == 2.0), 0.0) * INV_PI / sides;
}

#if area_lights
/// Share of what a surface emits that leaves it in a direction.
fn emission_share(point: SurfacePoint, direction: vec3f) -> f32 {
    var share = select(0.0, 1.0, emission_pdf_solid(point, direction) > 0.0);
#if coincident
    share *= uncovered(point, direction);
#endif
    return share;
}
#endif

#if punctual_lights
/// Intensity of a point or spot light in a direction, as a share of its largest.
fn emission_falloff(light: PunctualLight, direction: vec3f, is_spot: bool) -> f32 {
    return select(1.0, spot_falloff(light, direction), is_spot);
}
#endif

/// A point on a light and the ray that leaves it.
struct Emission {
    /// LIGHT_*; index of the triangle or punctual light.
    kind: u32,
    index: u32,
    /// Index in `lights`, and the point on the light: barycentrics of a triangle, equal-area square of an environment.
    light: u32,
    at: vec2f,
    /// Density of the point per area (per solid angle of an environment; probability of a punctual light).
    pdf_light: f32,
    /// Were nothing guided, the probability of the light over what it is, and the same of the ray's place or direction.
    nominal_pick: f32,
    nominal_ray: f32,
    /// Radiance, intensity or irradiance over that density.
    weight: vec3f,
    origin: vec3f,
    direction: vec3f,
    /// Density of the direction per solid angle (area across it of parallel light), and what the ray carries.
    pdf_solid: f32,
    throughput: vec3f,
    /// Position and normal of the light as the next vertex sees it, SUBPATH_* flags.
    position: vec3f,
    normal: vec3f,
    flags: u32,
}

/// Where the place or the direction of a light's ray comes from: `at` is the point on the light.
fn emission_draw(light: u32, at: vec2f, u: vec2f) -> GuideDraw {
#if light_guide
    return guide_draw(source_label(light, at), u);
#else
    return guide_draw(0u, u);
#endif
}

/// A ray of parallel light towards the scene.
fn emit_parallel(emission: ptr<function, Emission>, direction: vec3f, draw: GuideDraw) {
    let frame = frame_from_normal(direction);
    let disk = sample_disk(draw.square) * SCENE_RADIUS;
    (*emission).direction = direction;
    (*emission).origin = disk.x * frame.tangent + disk.y * frame.bitangent - 2.0 * SCENE_RADIUS * direction;
    (*emission).pdf_solid = disk_pdf_area() * draw.density;
    (*emission).nominal_ray = 1.0 / draw.density;
    (*emission).throughput = (*emission).weight / (*emission).pdf_solid;
    (*emission).flags = SUBPATH_INFINITE;
}

/// `words`, `point_words`: which light and where on it; `u`: direction.
fn sample_emission(words: vec4u, point_words: vec4u, u: vec4f) -> Emission {
    var emission: Emission;
#if light_guide
    let pick = alias_draw(words.xy, arrayLength(&guide_picks));
    let index = alias_pick(pick, guide_picks[pick.slot].threshold, guide_picks[pick.slot].alias_index);
    let pdf_select = guide_picks[index].pdf_select;
#else
    let pick = alias_draw(words.xy, arrayLength(&lights));
    let index = alias_pick(pick, lights[pick.slot].threshold, lights[pick.slot].alias_index);
    let pdf_select = lights[index].pdf_select;
#endif
    let light = lights[index];
    emission.nominal_pick = light.pdf_select / pdf_select;
    emission.kind = light.kind;
    emission.index = light.index;
    emission.light = index;
    let u_point = vec2f(uniform_from_word(words.z), uniform_from_word(words.w));
    switch light.kind {
#if area_lights
        case LIGHT_TRIANGLE: {
            let b = sample_triangle(u_point);
            let point = surface_point(light.index, b.y, b.z);
            let sides = emitting_sides(point);
            let side = select(1.0, -1.0, sides == 2.0 && u.z < 0.5);
            let frame = frame_from_normal(side * point.world_ng);
            emission.at = b.yz;
            emission.pdf_light = pdf_select / point.area;
            emission.weight = point_emission(point, frame.normal) * point_presence(point) / emission.pdf_light;
            let draw = emission_draw(index, emission.at, u.xy);
            emission.direction = to_world(frame, sample_cosine_hemisphere(draw.square));
            emission.pdf_solid = emission_pdf_solid(point, emission.direction) * draw.density;
            emission.nominal_ray = 1.0 / draw.density;
            emission.throughput = emission.weight * (PI * sides / draw.density);
#if coincident
            emission.throughput *= uncovered(point, emission.direction);
#endif
            emission.origin = ray_origin(point, emission.direction);
            emission.position = point.position;
            emission.normal = point.world_ng;
        }
#endif
#if environment
        case LIGHT_ENVIRONMENT: {
            let texels = environment_map.size * environment_map.size;
            let slot = alias_draw(point_words.xy, texels);
            let entry = environment_alias[slot.slot];
            let texel = alias_pick(slot, entry.x, entry.y);
            let corner = vec2f(f32(texel % environment_map.size), f32(texel / environment_map.size));
            emission.at = (corner + u_point) / f32(environment_map.size);
            let to_light = square_to_sphere(emission.at);
            let radiance = texel_radiance(texel);
            emission.pdf_light = pdf_select * texel_pdf_solid(radiance);
            emission.weight = radiance / emission.pdf_light;
            emit_parallel(&emission, -to_light, emission_draw(index, emission.at, u.xy));
        }
#endif
#if punctual_lights
        case LIGHT_DIRECTIONAL: {
            emission.pdf_light = pdf_select;
            emission.weight = punctual_lights[light.index].intensity / pdf_select;
            let draw = emission_draw(index, vec2f(0.0), u.xy);
            emit_parallel(&emission, punctual_lights[light.index].direction, draw);
        }
        case LIGHT_POINT, LIGHT_SPOT: {
            let punctual = punctual_lights[light.index];
            let is_spot = light.kind == LIGHT_SPOT;
            let frame = frame_from_normal(select(vec3f(0.0, 0.0, 1.0), punctual.direction, is_spot));
            emission.pdf_light = pdf_select;
            emission.weight = punctual.intensity / pdf_select;
            let draw = emission_draw(index, vec2f(0.0), u.xy);
            emission.direction = to_world(frame, sample_uniform_cone(draw.square, punctual.cone));
            emission.pdf_solid = uniform_cone_pdf_solid(punctual.cone) * draw.density;
            emission.nominal_ray = 1.0 / draw.density;
            let falloff = emission_falloff(punctual, emission.direction, is_spot);
            emission.throughput = emission.weight * (falloff / emission.pdf_solid);
            emission.origin = punctual.position;
            emission.position = punctual.position;
        }
#endif
        default: {}
    }
    return emission;
}
