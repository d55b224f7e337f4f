// What `select_light_vertex` returns: which vertex of the light cache a connection of an eye vertex ends at. The files
// lib/select_* define it, each in its way, and are exchangeable. `number` is below what `connect_vertex` knows of how many there are.

/// A light vertex, and the inverse of the expected number of times that this iteration's connections of one eye
/// vertex choose it, over light paths: what a sum over the cache is multiplied with.
struct Selection {
    vertex: u32,
    inv_density: f32,
#if at_records
    /// What the vertex brings to the eye vertex's records, and which choice it was drawn by: lib/record_shares.
    light: vec3f,
    choice: u32,
#endif
}

/// In the place of a vertex: this connection has none.
const NO_VERTEX: u32 = 0xffffffffu;
