#import bind/queue
#import lib/math
#import lib/path_key

// Starts the paths of a batch: one ray through a uniform point of each sample's pixel (box filter).

@group(1) @binding(5) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let path = id.x + id.y * 65535u * 64u;
    if path >= batch.pixel_count * batch.sample_count {
        return;
    }
    let pixel = path_pixel(path);
    let u = uniform4(path_key(path), DIMENSION_CAMERA);
    let x = (f32(pixel % batch.width) + u.x) / f32(batch.width);
    let y = (f32(pixel / batch.width) + u.y) / f32(batch.height);
    let direction = camera.direction + x * camera.direction_dx + y * camera.direction_dy;
    let origin = camera.origin + x * camera.origin_dx + y * camera.origin_dy;
    paths_in[path] = PathRay(origin, path, normalize(direction), 0.0, vec3f(1.0), 0u);
    radiance[path] = vec4f(0.0);
    if path == 0u {
        atomicStore(&counts[COUNT_PATHS_IN], batch.pixel_count * batch.sample_count);
    }
}
