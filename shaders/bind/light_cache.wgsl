#import lib/color

// The light vertex cache: the vertices of an iteration's light paths, for eye paths to connect to. Depth 0 is the
// point on the light. Delta vertices are not in it: no connection can end at one.

#if lambert_vertices
/// 48 bytes, where there is nothing but Lambert's law: what it does with light is known on arrival but for cosines, and
/// stored in place of what it follows from (lib/connect_lambert).
struct LambertVertex {
    /// Of the light that leaves: throughput over density of the sub-path up to here, times the BSDF. At depth 0 emitted
    /// radiance (intensity, irradiance of a punctual light) over density.
    weight: vec3f,
    /// Triangle, or index of the punctual light, in the low 28 bits; above them in 3 bits 0, or at depth 0 LIGHT_* plus one;
    /// then LIT_FROM_FRONT.
    index_kind: u32,
    b1: f32,
    b2: f32,
    /// |.| of the light that arrives: what subspaces draw by. At depth 0 that of `weight`.
    size: f32,
    /// The vertex's `mis_step`, and what of it is the edge to the vertex before, both with the scale of DEEP.
    step: f32,
    edge_step: f32,
    /// Density per solid angle of scattering to a direction, roulette included, over its cosine; 0 at depth 0.
    pdf_scale: f32,
    /// Light path, and depth, which is the vertex's number among those that the path has in the cache, as there are no delta
    /// vertices; above its 16 bits the light subspace.
    path: u32,
    depth_label: u32,
}

const INDEX_BITS: u32 = 28u;
/// In `index_kind` of a surface: light arrives on the side of its geometric normal.
const LIT_FROM_FRONT: u32 = 0x80000000u;

alias LightVertex = LambertVertex;

fn index_of(vertex: LightVertex) -> u32 {
    return vertex.index_kind & ((1u << INDEX_BITS) - 1u);
}

/// 0, or for a point on a light LIGHT_* plus one.
fn kind_of(vertex: LightVertex) -> u32 {
    return (vertex.index_kind >> INDEX_BITS) & 7u;
}

fn is_lit_from_front(vertex: LightVertex) -> bool {
    return (vertex.index_kind & LIT_FROM_FRONT) != 0u;
}

fn depth_of(vertex: LightVertex) -> u32 {
    return vertex.depth_label & 0xffffu;
}

fn number_of(vertex: LightVertex) -> u32 {
    return vertex.depth_label & 0xffffu;
}

/// Light subspace.
fn label_of(vertex: LightVertex) -> u32 {
    return vertex.depth_label >> 16u;
}

/// |.| of the light that arrives.
fn arriving(vertex: LightVertex) -> f32 {
    return vertex.size;
}
#else
/// 64 bytes. Everything that a connection needs is stored or follows from the triangle.
struct LightVertex {
    /// Of the light that arrives: throughput over density of the sub-path up to here, the BSDF here not included. At
    /// depth 0 emitted radiance (intensity, irradiance of a punctual light) over density.
    weight: vec3f,
    /// Triangle, or index of the punctual light.
    index: u32,
    /// Unit direction to the vertex before; at depth 0 to an infinitely far light.
    world_from: vec3f,
    /// Depth in the low 16 bits; above them in 4 bits 0, or at depth 0 LIGHT_* plus one. With `subspace_directions`, in
    /// the highest 12, the light subspace of the vertex before.
    depth_kind: u32,
    b1: f32,
    b2: f32,
    /// Density of this vertex per area from the one before, roulette included; per solid angle for an environment.
    pdf_area: f32,
    /// lib/mis
    ratio: f32,
    /// Turns a density per solid angle towards the vertex before into its density per area there.
    to_previous: f32,
    /// Density of connecting this vertex, as an eye vertex at DEEP, to the one before: lib/mis. With `subspace_directions`, which
    /// make it depend on the direction to the camera's side, |w| / Q of the vertex before, 0 for a delta vertex.
    edge: f32,
    /// Light path, and the vertex's number among those that the path has in the cache; above its 16 bits the light
    /// subspace.
    path: u32,
    number_label: u32,
}

fn index_of(vertex: LightVertex) -> u32 {
    return vertex.index;
}

/// 0, or for a point on a light LIGHT_* plus one.
fn kind_of(vertex: LightVertex) -> u32 {
    return (vertex.depth_kind >> 16u) & 0xfu;
}

fn depth_of(vertex: LightVertex) -> u32 {
    return vertex.depth_kind & 0xffffu;
}

fn number_of(vertex: LightVertex) -> u32 {
    return vertex.number_label & 0xffffu;
}

/// Light subspace.
fn label_of(vertex: LightVertex) -> u32 {
    return vertex.number_label >> 16u;
}

/// |.| of the light that arrives.
fn arriving(vertex: LightVertex) -> f32 {
    return magnitude(vertex.weight);
}
#endif

@group(3) @binding(0) var<storage, read_write> light_vertices: array<LightVertex>;
/// How many vertices each light path has in the cache.
@group(3) @binding(1) var<storage, read_write> light_path_lengths: array<u32>;
/// Their sums: where each path's vertices begin in `light_order`, and the end of the last.
@group(3) @binding(2) var<storage, read_write> light_path_offsets: array<u32>;
/// Indices into the cache by path and number. The order in the cache itself changes from run to run.
@group(3) @binding(3) var<storage, read_write> light_order: array<u32>;

#if nominal
/// Of each vertex of the cache: density of an unguided sub-path up to there over that of its own.
@group(3) @binding(21) var<storage, read_write> light_nominals: array<f32>;
#endif
#if learns
/// Of each vertex of the cache: density per area of the last but one before it, as the eye's side would sample it, coming
/// from here.
@group(3) @binding(14) var<storage, read_write> light_backs: array<f32>;
#endif
