// What `select_light_vertex` of the files lib/select_* gives: which vertex of the light cache a connection of an eye vertex
// ends at. The files are exchangeable; this is all that sets the bidirectional methods apart.

/// A light vertex, and the inverse of the expected number of times that this iteration's connections of one eye
/// vertex choose it, over light paths: what a sum over the cache is multiplied with.
struct Selection {
    vertex: u32,
    inv_density: f32,
}

/// In the place of a vertex: this connection has none.
const NO_VERTEX: u32 = 0xffffffffu;
