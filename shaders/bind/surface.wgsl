#import bind/accel
#if instances
#import lib/instance
#endif

// Materials, and what the vertices of a triangle carry beside their positions. Buffers that a scene has no use
// for do not exist: see `scene::features`.

struct Material {
    base_color: vec3f,
    flags: u32,
    /// Radiance per channel.
    emission: vec3f,
    opacity: f32,
    /// What lib/surface has of a microfacet; where textures have a say, of the factors alone.
    f0: vec3f,
    f90: f32,
    /// Absorption per unit of length inside the volume.
    absorption: vec3f,
    alpha_cutoff: f32,
    metallic: f32,
    alpha: f32,
    transmission: f32,
    eta: f32,
    inv_base_average: f32,
    albedo_row: u32,
    /// What that follows from.
    roughness: f32,
    ior: f32,
    specular_color: vec3f,
    specular: f32,
    normal_scale: f32,
    /// Indices into `texture_slots` plus one; 0 for none.
    base_color_texture: u32,
    metallic_roughness_texture: u32,
    normal_texture: u32,
    emission_texture: u32,
    specular_texture: u32,
    specular_color_texture: u32,
    transmission_texture: u32,
}

// The first two are the SURFACE_DELTA and SURFACE_VOLUME of lib/surface.
const MATERIAL_DELTA: u32 = 1u;
const MATERIAL_VOLUME: u32 = 2u;
const MATERIAL_DOUBLE_SIDED: u32 = 4u;
const MATERIAL_UNLIT: u32 = 8u;
const MATERIAL_MASK: u32 = 16u;

@group(0) @binding(2) var<storage, read> materials: array<Material>;

#if attributes
/// Three vertices a triangle, in the order of its sorted corners.
@group(0) @binding(3) var<storage, read> corner_vertices: array<u32>;
/// ATTRIBUTE_STRIDE numbers a vertex; what they are is said by the offsets.
@group(0) @binding(4) var<storage, read> vertex_attributes: array<f32>;

override ATTRIBUTE_STRIDE: u32 = 0u;
override NORMAL_OFFSET: u32 = 0u;
override UV0_OFFSET: u32 = 0u;
override UV1_OFFSET: u32 = 0u;
override TANGENT_OFFSET: u32 = 0u;
override COLOR_OFFSET: u32 = 0u;

/// A number of a vertex interpolated over the triangle; what is equal at all three is so between them, to the last bit.
fn attribute1(vertices: vec3u, b: vec3f, offset: u32) -> f32 {
    let first = vertex_attributes[vertices.x + offset];
    let second = vertex_attributes[vertices.y + offset];
    let third = vertex_attributes[vertices.z + offset];
    return first + b.y * (second - first) + b.z * (third - first);
}

/// Where the numbers of a triangle's vertices begin.
fn attribute_vertices(triangle: u32) -> vec3u {
#if instances
    return stored_vertices(stored_triangle(triangle));
}

fn stored_vertices(triangle: u32) -> vec3u {
#endif
    let first = corner_vertices[triangle * 3u];
    let second = corner_vertices[triangle * 3u + 1u];
    let third = corner_vertices[triangle * 3u + 2u];
    return vec3u(first, second, third) * ATTRIBUTE_STRIDE;
}

fn attribute2(triangle: u32, b: vec3f, offset: u32) -> vec2f {
    let vertices = attribute_vertices(triangle);
    return vec2f(attribute1(vertices, b, offset), attribute1(vertices, b, offset + 1u));
}

fn attribute3(triangle: u32, b: vec3f, offset: u32) -> vec3f {
    let vertices = attribute_vertices(triangle);
    let first = vec2f(attribute1(vertices, b, offset), attribute1(vertices, b, offset + 1u));
    return vec3f(first, attribute1(vertices, b, offset + 2u));
}

fn attribute4(triangle: u32, b: vec3f, offset: u32) -> vec4f {
    let vertices = attribute_vertices(triangle);
    let first = vec2f(attribute1(vertices, b, offset), attribute1(vertices, b, offset + 1u));
    return vec4f(first, attribute1(vertices, b, offset + 2u), attribute1(vertices, b, offset + 3u));
}
#endif

#if textures
/// A texture in a material's slot.
struct TextureSlot {
    /// First texel in `texels`.
    offset: u32,
    width: u32,
    height: u32,
    /// Wrap mode along u and v in two bits each, then TEXTURE_* bits.
    flags: u32,
    /// uv' = (row_u . (u, v, 1), row_v . (u, v, 1))
    row_u: vec3f,
    pad0: u32,
    row_v: vec3f,
    pad1: u32,
}

const TEXTURE_NEAREST: u32 = 16u;
const TEXTURE_SRGB: u32 = 32u;
const TEXTURE_UV1: u32 = 64u;

@group(0) @binding(5) var<storage, read> texture_slots: array<TextureSlot>;
/// RGBA, one byte each, red lowest.
@group(0) @binding(6) var<storage, read> texels: array<u32>;
#endif
