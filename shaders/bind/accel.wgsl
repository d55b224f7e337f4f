// The acceleration structure and the triangles in its order.

struct Triangle {
    v0: vec3f,
    material_flags: u32,
    v1: vec3f,
    light: u32,
    v2: vec3f,
    /// Index into `covers`; 0 where nothing of the triangle's plane is in front of it.
    cover: u32,
}

const TRIANGLE_FLIPPED: u32 = 0x01000000u;
const TRIANGLE_ALPHA: u32 = 0x02000000u;
const TRIANGLE_CULLED: u32 = 0x04000000u;
const TRIANGLE_MATERIAL: u32 = 0x00ffffffu;
/// In the place of a triangle's index: none.
const NO_TRIANGLE: u32 = 0xffffffffu;

/// A compressed wide node (Ylitie et al., Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs,
/// HPG 2017) as obvhs lays it out.
struct Node {
    n0: vec4u,
    n1: vec4u,
    n2: vec4u,
    n3: vec4u,
    n4: vec4u,
}

@group(0) @binding(0) var<storage, read> nodes: array<Node>;
@group(0) @binding(1) var<storage, read> triangles: array<Triangle>;
#if coincident
/// What is in front of triangles in their own plane: see src/accel/covers.rs.
@group(0) @binding(12) var<storage, read> covers: array<u32>;
#endif
