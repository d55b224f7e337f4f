// Which samples of which pixels a batch holds, and the camera they look through.

struct Batch {
    width: u32,
    height: u32,
    first_pixel: u32,
    pixel_count: u32,
    first_sample: u32,
    sample_count: u32,
    seed: u32,
    max_depth: u32,
}

struct Camera {
    origin: vec3f,
    pad0: u32,
    origin_dx: vec3f,
    pad1: u32,
    origin_dy: vec3f,
    pad2: u32,
    direction: vec3f,
    pad3: u32,
    direction_dx: vec3f,
    pad4: u32,
    direction_dy: vec3f,
    pad5: u32,
}

@group(1) @binding(6) var<uniform> batch: Batch;
@group(1) @binding(7) var<uniform> camera: Camera;
