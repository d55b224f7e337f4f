// What ray queries go through: see src/device/structure.rs.

/// What the driver made of `triangles`.
@group(0) @binding(16) var scene_structure: acceleration_structure;
/// Of a triangle's index, the bits that are within a page: a geometry ends with its page.
override GEOMETRY_BITS: u32 = 0u;
#if instances
/// For the triangles that are shown once, then for each instance: the index of the first triangle.
@group(0) @binding(17) var<storage, read> structure_bases: array<u32>;
#endif
