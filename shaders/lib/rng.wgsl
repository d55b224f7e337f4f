// Counter-based random numbers: every number is a pure function of (pixel, sample, dimension, seed), so that a
// kernel keeps no state, kernels agree on what a path draws, and a picture does not depend on the order of work.

/// What a path is known by. `seed` is the host's hash of the user's 64-bit seed (`math::rng::seed_key`).
struct RandomKey {
    pixel: u32,
    sample: u32,
    seed: u32,
}

/// pcg4d: Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020, listing of section 5.
fn pcg4d(counter: vec4u) -> vec4u {
    var v = counter * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> vec4u(16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

/// Four independent 32-bit words. A caller uses each dimension of a key once.
fn random4(key: RandomKey, dimension: u32) -> vec4u {
    return pcg4d(vec4u(key.pixel, key.sample, dimension, key.seed));
}

/// A word as a number in [0, 1), a multiple of 2^-24, at most 1 - 2^-24: u32 * 2^-32 would round to 1.
fn uniform_from_word(word: u32) -> f32 {
    return f32(word >> 8u) * 0x1p-24;
}

fn uniforms_from_words(words: vec4u) -> vec4f {
    return vec4f(words >> vec4u(8u)) * 0x1p-24;
}

/// Four independent numbers in [0, 1).
fn uniform4(key: RandomKey, dimension: u32) -> vec4f {
    return uniforms_from_words(random4(key, dimension));
}
