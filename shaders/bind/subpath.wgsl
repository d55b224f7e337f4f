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

#if subspaces
/// What weights by subspaces need beside `ratio`. Eye: the colour A of lib/subspaces, and the eye subspace of the vertex
/// that the ray leaves. Light: |w| / Q of the vertex that the ray leaves, 0, 0, and its light subspace.
@group(1) @binding(10) var<storage, read_write> shares_in: array<vec4f>;
@group(1) @binding(11) var<storage, read_write> shares_out: array<vec4f>;
/// Of the vertices that the eye paths in the queue have just reached: eye subspace, light subspace (not with
/// `subspace_directions`: it depends on where light comes from).
@group(1) @binding(12) var<storage, read_write> eye_labels: array<vec2u>;
#endif
