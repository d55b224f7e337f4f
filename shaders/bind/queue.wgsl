// The queues between the kernels of a batch. Their order may differ from run to run; nothing that reaches the
// film depends on it, since every path owns its connection slots of `radiance` and its numbers come from its own key.

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

/// A connection waiting for its visibility test. The ray runs over t in (0, t_max).
struct ShadowRay {
    origin: vec3f,
    /// What the contribution is added to: a connection slot of `radiance`, or a pixel of `splats`.
    slot: u32,
    direction: vec3f,
    t_max: f32,
    contribution: vec3f,
    depth: u32,
}

/// Lengths of queues, and totals over the render as 64-bit numbers (low word, high word).
struct Counts {
    paths_in: u32,
    paths_out: atomic<u32>,
    shadow_in: u32,
    shadow_out: atomic<u32>,
    closest_total: vec2u,
    shadow_total: vec2u,
    /// Vertices in the light cache; more than fit when it is full.
    light_vertices: atomic<u32>,
    /// Most vertices that one light path has in the cache.
    longest_light_path: atomic<u32>,
    /// How many times the eye vertices of this bounce have connected.
    connection_round: u32,
    /// Light vertices that were left out: their weight is infinite or none. A total over the render.
    non_finite_vertices: atomic<u32>,
}

@group(1) @binding(0) var<storage, read_write> paths_in: array<PathRay>;
@group(1) @binding(1) var<storage, read_write> paths_out: array<PathRay>;
@group(1) @binding(2) var<storage, read_write> hits: array<Hit>;
@group(1) @binding(3) var<storage, read_write> shadow_rays: array<ShadowRay>;
@group(1) @binding(4) var<storage, read_write> counts: Counts;
/// Light found so far by each path of the batch, CONNECTIONS_IN_FLIGHT connection slots per path: one for each connection
/// that a vertex may have in flight, so that no two invocations add to the same.
@group(1) @binding(5) var<storage, read_write> radiance: array<vec4f>;

/// Connections that an eye vertex has in flight at once.
override CONNECTIONS_IN_FLIGHT: u32 = 1u;

const WORKGROUP: u32 = 64u;

/// Index of an invocation; `Bound::dispatch` lays long rows over y.
fn invocation(id: vec3u) -> u32 {
    return id.x + id.y * (65535u * WORKGROUP);
}
