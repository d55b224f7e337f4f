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
#if instances
/// In the tree of the scene, in the place of a triangle: an instance, whose index is in `light`.
const TRIANGLE_INSTANCE: u32 = 0x08000000u;
#endif
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
#if instances

/// A mesh in one of its places. Its linear part comes in columns.
struct Instance {
    x: vec3f,
    /// The root of the mesh's tree.
    root: u32,
    y: vec3f,
    /// What the numbers of its triangles are beyond their indices.
    shift: u32,
    z: vec3f,
    /// -1 of a mirror image, or 1.
    handedness: f32,
    /// Where the mesh's origin is in unit space.
    origin: vec3f,
    /// The largest coordinate of any of its points.
    reach: f32,
    /// What rounding leaves out of `origin`.
    origin_rest: vec3f,
    pad0: u32,
    /// From unit space to that of the mesh.
    inverse_x: vec3f,
    pad1: u32,
    inverse_y: vec3f,
    pad2: u32,
    inverse_z: vec3f,
    pad3: u32,
}

@group(0) @binding(14) var<storage, read> instances: array<Instance>;
/// The instance of each block of numbers.
@group(0) @binding(15) var<storage, read> instance_blocks: array<u32>;

struct InstanceNumbers {
    /// Numbers of triangles of instances begin here.
    first: u32,
    /// So many bits of them are a place in a block.
    block_bits: u32,
}

@group(0) @binding(18) var<uniform> instance_numbers: InstanceNumbers;
#endif
#if coincident
/// What is in front of triangles in their own plane: see src/accel/covers.rs.
@group(0) @binding(12) var<storage, read> covers: array<u32>;
#endif
