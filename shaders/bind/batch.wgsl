// Which samples of which pixels a batch holds, and the camera they look through.

struct Batch {
    /// Connections of an eye vertex, by its depth: 0, 1, 2 and beyond.
    connections: vec3u,
    /// In weights, the density of light that is hit is times this, and those of connections, by the depth of their eye
    /// vertex, are times these: lib/mis.
    hit_scale: f32,
    density_scales: vec3f,
    /// The whole picture, in pixels.
    width: u32,
    height: u32,
    /// The part that is rendered: first column and row, how many of each, and how far from one to the next. The film
    /// covers this part.
    crop_x: u32,
    crop_y: u32,
    crop_width: u32,
    crop_height: u32,
    crop_stride: u32,
    /// First pixel of the batch, row-major in the part, and how many.
    first_pixel: u32,
    pixel_count: u32,
    /// First sample of each pixel in the batch, and how many.
    first_sample: u32,
    sample_count: u32,
    seed: u32,
    /// Paths end after this many surfaces.
    max_depth: u32,
    /// The seed of light paths, the index of the first one in flight, and how many an iteration has.
    light_seed: u32,
    first_light_path: u32,
    light_path_count: u32,
    /// Light paths that connect to the camera, times the share that weights trust them with; 0 where none does.
    camera_paths: f32,
    /// Of all strategies, only the one with so many light and eye vertices; EVERY_STRATEGY for all.
    only_s: u32,
    only_t: u32,
    /// 1: strategies are weighed against each other; 0: each is taken alone.
    weighted: u32,
    /// K, subspaces a side.
    subspaces: u32,
    /// What light paths bring to the camera is summed in units that are so many times finer: a power of two.
    splat_scale: f32,
    /// How many records there are, and the first one that is under way.
    records: u32,
    first_record: u32,
    /// Mean number of vertices on a light path, where weights know of records.
    vertices_per_path: f32,
}

/// Samples of a pixel that belong together, counted from the first.
const SAMPLES_A_GROUP: u32 = 8u;

const EVERY_STRATEGY: u32 = 0xffffffffu;

/// No pixel of the rendered part.
const NO_PIXEL: u32 = 0xffffffffu;

struct Camera {
    origin: vec3f,
    before: f32,
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
