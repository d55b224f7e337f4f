// Records: vertices of a few eye paths that each iteration traces beside those of the picture. Each has a table that draws
// light vertices by the light that they would bring to it. Popov, Ramamoorthi, Durand, Drettakis, Probabilistic
// Connections for Bidirectional Path Tracing, 2015.

struct Record {
    position: vec3f,
    triangle: u32,
    b1: f32,
    b2: f32,
    /// Of the eye path that left it.
    path: u32,
    /// Depth in the low 16 bits; above them the sides of the surface that light counts on.
    depth_sides: u32,
    /// Largest geometry term that counts: nearer light vertices would be this record's alone.
    most_geometry: f32,
    /// 1 / Q, where weights know of it: Q is about the mean light that a light path brings to the record. 0: not known.
    inv_q: f32,
    pad0: u32,
    pad1: u32,
}

const RECORD_FRONT: u32 = 0x10000u;
const RECORD_BACK: u32 = 0x20000u;
/// In the place of a record.
const NO_RECORD: u32 = 0xffffffffu;

/// As eye paths leave them, in any order, and how many; more than fit when it is full.
@group(3) @binding(21) var<storage, read_write> found_records: array<Record>;
@group(3) @binding(22) var<storage, read_write> found_count: atomic<u32>;
/// A left-balanced tree over their positions: lib/nearest_records.
@group(3) @binding(23) var<storage, read> records: array<Record>;
/// For each record and each vertex in the cache's order: the light that it brings to the record.
@group(3) @binding(24) var<storage, read_write> record_weights: array<f32>;
/// The same as running sums of whole units, this vertex included: the last is 0 of a record that no light reaches.
@group(3) @binding(25) var<storage, read_write> record_ends: array<u32>;
#if resampling
/// For each record the light that all vertices bring to it.
@group(3) @binding(26) var<storage, read_write> record_sums: array<f32>;
#endif
