// What weights by subspaces need of a ray beside its SubPath, in the same slots of the queues: lib/weights_subspaces.

/// Of a ray that leaves an eye vertex.
struct EyeMis {
    /// The colour A of lib/weights_subspaces.
    a: vec3f,
    /// Eye subspace of the vertex.
    label: u32,
}

/// Of a ray that leaves a light vertex.
struct LightMis {
    /// |w| / Q of the vertex; 0 for a delta vertex.
    w_over_q: f32,
    /// What connecting it to the vertex before adds to the ratio of the ray. In training: density per area of that vertex,
    /// as the eye's side would sample it, coming from where the ray goes.
    behind: f32,
    /// Density of an unguided sub-path up to where the ray arrives, over that of this one; 1 where nothing is guided.
    nominal: f32,
    /// Light subspace of the vertex.
    label: u32,
}

@group(1) @binding(10) var<storage, read_write> eye_mis_in: array<EyeMis>;
@group(1) @binding(11) var<storage, read_write> eye_mis_out: array<EyeMis>;
/// Of the vertices that the eye paths in the queue have just reached: eye subspace, light subspace (not with
/// `subspace_directions`: it depends on where light comes from).
@group(1) @binding(12) var<storage, read_write> eye_labels: array<vec2u>;
@group(1) @binding(13) var<storage, read_write> light_mis_in: array<LightMis>;
@group(1) @binding(14) var<storage, read_write> light_mis_out: array<LightMis>;
