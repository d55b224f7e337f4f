#import lib/surface

// Russian roulette as a function of the vertex alone: the density of a path, roulette included, can then be told
// for sub-paths that were not traced, which every bidirectional weight needs.

/// Least probability to go on.
override ROULETTE_CAP: f32 = 0.3;
/// Below one, so that a path between surfaces that absorb nothing ends as well.
const MAX_SURVIVAL: f32 = 0.99609375;

/// Probability that a path goes on from a vertex.
fn survival(surface: Surface) -> f32 {
    let albedo = bsdf_albedo(surface);
    return min(max(max(albedo.x, max(albedo.y, albedo.z)), ROULETTE_CAP), MAX_SURVIVAL);
}
