#import lib/surface

// Russian roulette as a function of the vertex and of its place in a row of delta surfaces: the density of a path, roulette
// included, can then be told for sub-paths that were not traced, which every bidirectional weight needs.
//
// A path goes on with the probability that light does, so what it carries does not grow, and its noise is bounded as long as
// light ends. Lower, q in place of the albedo r, it would have no bound in a room where r^2 > q: so it is between mirrors
// that lose less than a twentieth, and for the light of long rows of them noise grows with each.

/// Least probability to go on.
override ROULETTE_CAP: f32 = 0.3;
/// An albedo above this counts as one: what absorbs so little ends no path that 16 bits of depth can count.
const WHITE: f32 = 0.999755859375;
/// Below one, so that a path between surfaces that absorb nothing ends as well.
const WHITE_SURVIVAL: f32 = 0.99609375;
/// So many delta surfaces in a row are passed like any others. Beyond, paths end sooner: what is caught in clear glass brings
/// nothing, and all others of its batch wait for it. Shorter rows would be noise in what mirrors and glass show. A cap above
/// CAUGHT_SURVIVAL turns it down, one of 1 off.
const CAUGHT_RUN: u32 = 16u;
const CAUGHT_SURVIVAL: f32 = 0.95;

/// Probability that a path goes on from a vertex.
fn survival(surface: Surface) -> f32 {
    let albedo = bsdf_albedo(surface);
    let kept = max(max(albedo.x, max(albedo.y, albedo.z)), ROULETTE_CAP);
    return select(kept, WHITE_SURVIVAL, kept > WHITE);
}

/// What `survival` is times at a delta surface with so many in a row before it. By its place in the row alone: nothing connects
/// within one, so an eye path or a light path has all of it, and the product is the same from both ends.
fn run_survival(before: u32) -> f32 {
    return select(1.0, max(CAUGHT_SURVIVAL, ROULETTE_CAP), before >= CAUGHT_RUN);
}
