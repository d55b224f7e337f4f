#import bind/queue
#import bind/subpath
#import lib/emission
#import lib/path_key
#if light_cache
#import lib/light_vertex
#endif
#if light_only
#import lib/camera
#endif
#if subspaces
#import lib/weights
#endif

// Starts light paths: a point on a light, drawn by power, and a ray that leaves it.

#if light_only
/// Connects the light itself to the camera.
fn connect_camera(path: u32, emission: Emission) {
    var pixel = NO_PIXEL;
    var seen = 0.0;
    var shadow = ShadowRay(camera.origin, 0u, vec3f(0.0), MAX_FLOAT, vec3f(0.0), 0u);
    switch emission.kind {
#if area_lights
        case LIGHT_TRIANGLE: {
            let point = surface_point(emission.index, emission.at.x, emission.at.y);
            let view = camera_view(point.position);
            let cosine = emission_pdf_solid(point, view.direction) * PI * emitting_sides(point);
            pixel = view.pixel;
            seen = view.pdf_area * cosine;
#if coincident
            seen *= uncovered(point, view.direction);
#endif
            shadow.origin = ray_origin(point, view.direction);
            shadow.direction = view.direction * view.distance;
            shadow.t_max = 1.0 - 0x1p-20;
        }
#endif
#if environment
        case LIGHT_ENVIRONMENT: {
            // An orthographic camera sees one direction only, which no sample has.
            if any(camera.direction_dx != vec3f(0.0)) {
                pixel = direction_pixel(-emission.direction);
                seen = camera_pdf(-emission.direction);
                shadow.direction = -emission.direction;
            }
        }
#endif
        default: {}
    }
    shadow.slot = pixel;
    shadow.contribution = emission.weight * (seen / f32(batch.light_path_count));
    if pixel != NO_PIXEL && any(shadow.contribution != vec3f(0.0)) {
        shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = shadow;
    }
}
#endif

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let path = invocation(id);
    let paths = batch.pixel_count * batch.sample_count;
    if path >= paths {
        return;
    }
    if path == 0u {
        atomicStore(&counts.paths_out, paths);
    }
    let emission = sample_emission(
        path_words(path, bounce_dimension(0u, DIMENSION_LIGHT)),
        path_words(path, bounce_dimension(0u, DIMENSION_LIGHT_POINT)),
        path_uniform4(path, bounce_dimension(0u, DIMENSION_BSDF)),
    );
    // No path hits a punctual light by chance; without eye paths none hits any.
#if light_only
    let ratio = 0.0;
#else
    let can_be_hit = emission.kind == LIGHT_TRIANGLE || emission.kind == LIGHT_ENVIRONMENT;
    let ratio = select(0.0, batch.hit_scale, can_be_hit);
#endif
    paths_in[path] =
        PathRay(emission.origin, path, emission.direction, emission.pdf_solid, emission.throughput, 1u);
    sub_paths_in[path] =
        SubPath(emission.position, ratio / emission.pdf_light, emission.normal, emission.flags);
#if subspaces
    let label = source_label(emission.light, emission.at);
    let nominal = emission.nominal_pick * emission.nominal_ray;
    light_mis_in[path] = light_mis_of_bounce(emission.weight, 0.0, false, label, nominal);
#else
    let label = 0u;
#endif
#if light_cache
    let light_path = batch.first_light_path + path;
    light_path_lengths[light_path] = 1u;
    let slot = atomicAdd(&counts.light_vertices, 1u);
    if slot < arrayLength(&light_vertices) {
        light_vertices[slot] = source_vertex(
            emission.kind,
            emission.index,
            emission.at,
            -emission.direction,
            emission.weight,
            emission.pdf_light,
            ratio,
            vec2u(light_path, label << 16u),
        );
        keep_nominal(slot, emission.nominal_pick);
    }
#if at_records
    light_ends_in[path] = slot;
#endif
#endif
#if light_only
    connect_camera(path, emission);
#endif
}
