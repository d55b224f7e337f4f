#import bind/queue
#import lib/path_key
#if bidirectional
#import bind/subpath
#if subspaces
#import bind/subspace_mis
#endif
#if resampling
#import bind/eye_links
#endif
#import lib/camera
#endif

// Starts the paths of a batch: one ray through a uniform point of each sample's pixel (box filter).

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let path = invocation(id);
    let paths = batch.pixel_count * batch.sample_count;
    if path >= paths {
        return;
    }
    if path == 0u {
        atomicStore(&counts.paths_out, paths);
        atomicStore(&counts.shadow_out, 0u);
    }
    let pixel = path_pixel(path);
    let u = path_uniform4(path, DIMENSION_CAMERA);
    let x = (f32(pixel.x) + u.x) / f32(batch.width);
    let y = (f32(pixel.y) + u.y) / f32(batch.height);
    let direction = camera.direction + x * camera.direction_dx + y * camera.direction_dy;
    let origin = camera.origin + x * camera.origin_dx + y * camera.origin_dy;
#if bidirectional
    let unit_direction = normalize(direction);
    let parallel = all(camera.direction_dx == vec3f(0.0));
    paths_in[path] = PathRay(origin, path, unit_direction, camera_pdf(unit_direction), vec3f(1.0), 0u);
    sub_paths_in[path] =
        SubPath(origin, 0.0, vec3f(0.0), SUBPATH_CAMERA | select(0u, SUBPATH_INFINITE, parallel));
#if subspaces
    eye_mis_in[path] = EyeMis(vec3f(0.0), 0u);
#endif
#if resampling
    eye_ends_in[path] = NO_LINK;
#endif
#else
    paths_in[path] = PathRay(origin, path, normalize(direction), 0.0, vec3f(1.0), 0u);
#endif
    for (var slot = path * CONNECTIONS_IN_FLIGHT; slot < (path + 1u) * CONNECTIONS_IN_FLIGHT; slot++) {
        radiance[slot] = vec4f(0.0);
    }
}
