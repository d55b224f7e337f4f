#import lib/hit
#import lib/rng

// Masked and blended surfaces, decided while tracing. A blended surface is there with probability alpha: each
// crossing is an independent draw, so the picture is right on average, and no ray needs to be split.

/// A random word of the ray; set before `trace`.
var<private> alpha_word: u32;

/// True where the surface is there.
fn is_present(triangle: u32, b1: f32, b2: f32) -> bool {
    return uniform_from_word(pcg4d(vec4u(alpha_word, triangle, 0u, 0u)).x) < presence_at(triangle, b1, b2);
}
