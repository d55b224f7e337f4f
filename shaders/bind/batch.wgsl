// Which samples of which pixels a batch holds, and the camera they look through.

struct Batch {
    /// The whole picture, in pixels.
    width: u32,
    height: u32,
    /// The part that is rendered: left and top edge and width. The film covers this part.
    crop_x: u32,
    crop_y: u32,
    crop_width: u32,
    /// First pixel of the batch, row-major in the part, and how many.
    first_pixel: u32,
    pixel_count: u32,
    /// First sample of each pixel in the batch, and how many.
    first_sample: u32,
    sample_count: u32,
    seed: u32,
    /// Paths end after this many surfaces.
    max_depth: u32,
    pad: u32,
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
