// What the rays of bidirectional sub-paths carry beside their PathRay, in the same slots of the queues.

struct SubPath {
    /// The vertex that the ray leaves.
    position: vec3f,
    /// Of the densities of all other strategies to this one's, for the vertex to come: see lib/mis.
    ratio: f32,
    /// Geometric normal of the vertex; zero for one without.
    normal: vec3f,
    /// SUBPATH_*, and above them what lib/thinning has.
    flags: u32,
}

/// The ray comes from infinitely far: parallel light, or an orthographic camera.
const SUBPATH_INFINITE: u32 = 1u;
/// The ray leaves a delta vertex, which no connection can end at.
const SUBPATH_DELTA: u32 = 2u;
/// The ray leaves the camera.
const SUBPATH_CAMERA: u32 = 4u;
/// Five bits: delta vertices in a row up to the one that the ray leaves, SUBPATH_RUN_MOST for more.
const SUBPATH_RUN_SHIFT: u32 = 3u;
const SUBPATH_RUN_MOST: u32 = 31u;

/// Delta vertices in a row before the one that a ray with these flags comes to.
fn run_before(flags: u32) -> u32 {
    return (flags >> SUBPATH_RUN_SHIFT) & SUBPATH_RUN_MOST;
}

/// Flags of a ray that leaves a delta vertex, to which it came with `flags`.
fn delta_flags(flags: u32) -> u32 {
    return SUBPATH_DELTA | (min(run_before(flags) + 1u, SUBPATH_RUN_MOST) << SUBPATH_RUN_SHIFT);
}

@group(1) @binding(8) var<storage, read_write> sub_paths_in: array<SubPath>;
@group(1) @binding(9) var<storage, read_write> sub_paths_out: array<SubPath>;
