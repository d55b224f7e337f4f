// The vertices of the eye paths in flight as lists, of each path the last one first: lib/weights_records.

#if at_records
/// lib/weights_at_records
struct RecordLink {
    /// The BSDF on the way on, times the geometry term to the vertex before and what lies between lets pass.
    step: vec3f,
    /// The entry of the vertex before; NO_LINK where that is the camera.
    before: u32,
    /// The same to each of the records of the vertex before, in place of that vertex.
    reach0: vec3f,
    /// Density per area of the vertex before, as sampled from here coming from where the path goes on.
    pdf_before: f32,
    reach1: vec3f,
    /// Density per area of this vertex.
    pdf_area: f32,
    reach2: vec3f,
    /// What the density of its connections is times; 0 of a delta vertex.
    scale: f32,
    /// Nearest to this vertex.
    records: vec3u,
    pad0: u32,
}

alias EyeLink = RecordLink;
#else
struct EyeLink {
    /// The BSDF on the way on, times the geometry term to the vertex before and what lies between lets pass.
    step: vec3f,
    /// The entry of the vertex before; NO_LINK where that is the camera.
    before: u32,
    /// 1 / Q of the nearest records; 0 in the place of one that is not there.
    inv_q: vec3f,
    /// Density per area of the vertex before, as sampled from here coming from where the path goes on.
    pdf_before: f32,
    /// Density per area of this vertex.
    pdf_area: f32,
    /// What the density of its connections is times; 0 of a delta vertex.
    scale: f32,
    pad0: u32,
    pad1: u32,
}
#endif

const NO_LINK: u32 = 0xffffffffu;

@group(1) @binding(16) var<storage, read_write> eye_links: array<EyeLink>;
/// How many there are; more than fit when it is full.
@group(1) @binding(17) var<storage, read_write> eye_link_count: atomic<u32>;
/// Of each ray of the queue the entry of the vertex that it leaves.
@group(1) @binding(18) var<storage, read_write> eye_ends_in: array<u32>;
@group(1) @binding(19) var<storage, read_write> eye_ends_out: array<u32>;
#if at_records
/// For the vertices that eye paths in the queue have just reached: the geometry term to each of the records of the vertex
/// before, with what of it is hidden.
@group(1) @binding(20) var<storage, read_write> eye_reach: array<vec4f>;
#endif
