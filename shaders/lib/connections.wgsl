#import bind/batch
#import lib/thinning

// How many connections an eye vertex has, and what their density is times in weights, by the depth of the vertex: 0 is
// what the camera sees.

/// Vertices of this depth and beyond are all alike.
const DEEP: u32 = 2u;

/// Connections of an eye vertex.
fn connections_at(depth: u32) -> u32 {
    return batch.connections[min(depth, DEEP)];
}

/// Connections that an eye vertex on this material makes: as many as expected on average, by the random `word`.
fn connections_drawn(depth: u32, material: u32, word: u32) -> u32 {
    let expected = connections_at(depth) * thinning_units(material);
    let part = expected % THINNING_UNITS;
    return expected / THINNING_UNITS + select(0u, 1u, (word >> 24u) < part);
}

/// The mean number of them.
fn connections_expected(depth: u32, material: u32) -> f32 {
    return f32(connections_at(depth)) * thinning_at(material);
}

/// What the density of a connection is times: lib/mis. Light paths do not know how far from the camera they are, and take
/// that of DEEP.
fn density_scale(depth: u32) -> f32 {
    return batch.density_scales[min(depth, DEEP)];
}

/// From the scale of DEEP to that of `depth`. Where nothing is connected to light vertices, all are 0.
fn scale_from_deep(depth: u32) -> f32 {
    let deep = density_scale(DEEP);
    return select(density_scale(depth) / deep, 1.0, deep == 0.0);
}

/// What weights are told beside the number of connections: the density's scale for each of them.
fn share_at(depth: u32) -> f32 {
    return density_scale(depth) / f32(connections_at(depth));
}
