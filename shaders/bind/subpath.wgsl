// What the rays of bidirectional sub-paths carry beside their PathRay, in the same slots of the queues.

struct SubPath {
    /// The vertex that the ray leaves.
    position: vec3f,
    /// Of the densities of all other strategies to this one's, for the vertex to come: see lib/mis.
    ratio: f32,
    /// Geometric normal of the vertex; zero for one without.
    normal: vec3f,
    /// SUBPATH_*
    flags: u32,
}

/// The ray comes from infinitely far: parallel light, or an orthographic camera.
const SUBPATH_INFINITE: u32 = 1u;
/// The ray leaves a delta vertex, which no connection can end at.
const SUBPATH_DELTA: u32 = 2u;
/// The ray leaves the camera.
const SUBPATH_CAMERA: u32 = 4u;

@group(1) @binding(8) var<storage, read_write> sub_paths_in: array<SubPath>;
@group(1) @binding(9) var<storage, read_write> sub_paths_out: array<SubPath>;
