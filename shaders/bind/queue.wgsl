// The queues between the kernels of a batch. Their order may differ from run to run; nothing that reaches the
// film depends on it, since every path owns its cell of `radiance` and its numbers come from its own key.

struct PathRay {
    origin: vec3f,
    path: u32,
    direction: vec3f,
    pdf_solid: f32,
    throughput: vec3f,
    depth_medium: u32,
}

struct Hit {
    t: f32,
    triangle: u32,
    b1: f32,
    b2: f32,
}

const NO_HIT: u32 = 0xffffffffu;

/// Lengths of the queues: one slot for each use, see `src/integrator/queue.rs`.
const COUNT_PATHS_IN: u32 = 0u;
const COUNT_PATHS_OUT: u32 = 1u;
const COUNT_SHADOW: u32 = 2u;

@group(1) @binding(0) var<storage, read_write> paths_in: array<PathRay>;
@group(1) @binding(1) var<storage, read_write> hits: array<Hit>;
@group(1) @binding(2) var<storage, read_write> counts: array<atomic<u32>>;
