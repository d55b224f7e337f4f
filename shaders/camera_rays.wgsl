#import bind/queue
#import lib/path_key

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
    let u = uniform4(path_key(path), DIMENSION_CAMERA);
    let x = (f32(pixel.x) + u.x) / f32(batch.width);
    let y = (f32(pixel.y) + u.y) / f32(batch.height);
    let direction = camera.direction + x * camera.direction_dx + y * camera.direction_dy;
    let origin = camera.origin + x * camera.origin_dx + y * camera.origin_dy;
    paths_in[path] = PathRay(origin, path, normalize(direction), 0.0, vec3f(1.0), 0u);
    radiance[path] = vec4f(0.0);
}
