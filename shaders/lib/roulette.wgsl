#import lib/surface

// Russian roulette as a function of the vertex alone: the density of a path, roulette included, can then be told
// for sub-paths that were not traced, which every bidirectional weight needs.
//
// A path goes on with the probability that light does, so what it carries does not grow, and its noise is bounded as long as
// light ends. Lower, q in place of the albedo r, it would have no bound in a room where r^2 > q.

/// Least probability to go on.
override ROULETTE_CAP: f32 = 0.3;
/// An albedo above this counts as one: what absorbs so little ends no path that 16 bits of depth can count.
const WHITE: f32 = 0.999755859375;
/// Below one, so that a path between surfaces that absorb nothing ends as well.
const WHITE_SURVIVAL: f32 = 0.99609375;

/// Probability that a path goes on from a vertex.
fn survival(surface: Surface) -> f32 {
    let albedo = bsdf_albedo(surface);
    let kept = max(max(albedo.x, max(albedo.y, albedo.z)), ROULETTE_CAP);
    return select(kept, WHITE_SURVIVAL, kept > WHITE);
}
