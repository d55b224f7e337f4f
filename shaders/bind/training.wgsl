// What pre-tracing hands to the host: the vertices of eye paths, and the lights that they found.

/// A vertex x_i of an eye path.
struct TrainingVertex {
    position: vec3f,
    path: u32,
    /// As the classification sees it (lib/subspaces).
    normal: vec3f,
    /// Depth in the low 16 bits; above them 1 for a delta vertex.
    depth_thinning: u32,
    /// Unit direction to x_{i-1}.
    direction: vec3f,
    /// pE(i)
    pdf_area: f32,
    /// The BSDF on the way to x_{i+1}; 0 where the path ended.
    f: vec3f,
    /// G(x_i, x_{i-1})
    geometry: f32,
}

/// A path that was found: from the eye's vertex x_{n-1} to a point on a light or, where learning goes by the renderer's
/// own connections, to a vertex y of the light cache. p: density of the whole path by all ways to find it.
struct TrainingEnd {
    /// |.|'s colour of the light's sub-path times the density of the eye's, over p: Le PE(n-1) / p, or w_y / p's part.
    emitted: vec3f,
    path: u32,
    /// The BSDF at x_{n-1} towards the light's end; a light that was hit has it in the vertex.
    f: vec3f,
    /// Depth of x_{n-1} in the low 16 bits; above them, where the ends were connected, 1 and by how many the vertex's
    /// connections came before this one.
    depth_sampled: u32,
    /// The BSDF at y, or what a light emits this way as a share; absorption in between.
    f_light: vec3f,
    /// Place of y in the cache's order; NO_LIGHT_VERTEX for a point on a light that is not in it.
    vertex: u32,
    /// What it counts in the picture: |f| / p times its share. (Connected ends have to see each other as well: its slot of `radiance` says so.)
    contribution: f32,
    /// PE(n) / p; of a vertex of the cache the host works it out.
    p0: f32,
    /// G between the ends.
    geometry: f32,
    /// Index in `lights` and point on the light.
    light: u32,
    at: vec2f,
    /// Density per area of y, and of the vertex before it in its sub-path, as the eye's side samples them.
    pdf_light: f32,
    pdf_back: f32,
    /// From x_{n-1} to the light's end.
    direction: vec3f,
    /// Of the way that found the path: lib/connections.
    share: f32,
}

const NO_LIGHT_VERTEX: u32 = 0xffffffffu;

struct TrainingCounts {
    vertices: atomic<u32>,
    ends: atomic<u32>,
}

@group(3) @binding(16) var<storage, read_write> training_vertices: array<TrainingVertex>;
@group(3) @binding(17) var<storage, read_write> training_ends: array<TrainingEnd>;
@group(3) @binding(18) var<storage, read_write> training_counts: TrainingCounts;
