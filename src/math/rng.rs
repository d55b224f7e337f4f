//! Counter-based random numbers: a pure function of (pixel, sample, dimension, seed); mirrors `lib/rng.wgsl`
//! bit for bit.

use glam::{UVec4, Vec4};

/// What a path is known by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RandomKey {
    pub pixel: u32,
    pub sample: u32,
    /// [`seed_key`] of the user's seed.
    pub seed: u32,
}

/// The 32-bit key of a 64-bit seed, so that near seeds give unrelated pictures: upper half of SplitMix64
/// (Steele, Lea and Flood, Fast Splittable Pseudorandom Number Generators, OOPSLA 2014).
pub fn seed_key(seed: u64) -> u32 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 32) as u32
}

/// pcg4d: Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020, listing of section 5.
pub fn pcg4d(counter: [u32; 4]) -> [u32; 4] {
    let mut v = counter.map(|c| c.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    mix(&mut v);
    v = v.map(|c| c ^ (c >> 16));
    mix(&mut v);
    v
}

fn mix(v: &mut [u32; 4]) {
    v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
    v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
    v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
    v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
}

/// Four independent 32-bit words. A caller uses each dimension of a key once.
pub fn random4(key: RandomKey, dimension: u32) -> UVec4 {
    UVec4::from(pcg4d([key.pixel, key.sample, dimension, key.seed]))
}

/// A word as a number in [0, 1), a multiple of 2^-24, at most 1 - 2^-24.
pub fn uniform_from_word(word: u32) -> f32 {
    const STEP: f32 = 1.0 / (1 << 24) as f32;
    (word >> 8) as f32 * STEP
}

/// Four independent numbers in [0, 1).
pub fn uniform4(key: RandomKey, dimension: u32) -> Vec4 {
    Vec4::from(random4(key, dimension).to_array().map(uniform_from_word))
}
