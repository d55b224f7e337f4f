// What pre-tracing hands to the host: the vertices of eye paths, and the lights that they found.

/// A vertex x_i of an eye path.
struct TrainingVertex {
    position: vec3f,
    path: u32,
    /// As the classification sees it (lib/subspaces).
    normal: vec3f,
    /// Depth in the low 16 bits; above them 1 for a delta vertex.
    depth_delta: u32,
    /// Unit direction to x_{i-1}.
    direction: vec3f,
    /// pE(i)
    pdf_area: f32,
    /// The BSDF on the way to x_{i+1}; 0 where the path ended.
    f: vec3f,
    /// G(x_i, x_{i-1})
    geometry: f32,
}

/// A light x_n that was found from the vertex x_{n-1}.
struct TrainingEnd {
    /// Le PE(n-1) / p, p being the density of the whole path by both ways to find the light.
    emitted: vec3f,
    path: u32,
    /// The BSDF at x_{n-1} towards the light, where the light was sampled; a light that was hit has it in the vertex.
    f: vec3f,
    /// Depth of x_{n-1} in the low 16 bits; above them 1 where the light was sampled.
    depth_sampled: u32,
    /// |f| / p of the path. (A sampled light has to be seen as well: its cell of `radiance` says so.)
    contribution: f32,
    /// PE(n) / p
    p0: f32,
    /// G(x_n, x_{n-1})
    geometry: f32,
    /// Index in `lights` and point on the light.
    light: u32,
    at: vec2f,
    pad0: u32,
    pad1: u32,
    /// From x_{n-1} to the light.
    direction: vec3f,
    pad2: u32,
}

struct TrainingCounts {
    vertices: atomic<u32>,
    ends: atomic<u32>,
}

@group(3) @binding(0) var<storage, read_write> training_vertices: array<TrainingVertex>;
@group(3) @binding(1) var<storage, read_write> training_ends: array<TrainingEnd>;
@group(3) @binding(2) var<storage, read_write> training_counts: TrainingCounts;
