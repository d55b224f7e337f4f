//! Random numbers: quality and equality of host and shader.

use halfway::math::rng::{RandomKey, random4, seed_key, uniform_from_word, uniform4};
use rayon::prelude::*;

use crate::gpu;
use crate::random::Stream;
use crate::stats::{FAMILY_ALPHA, chi_square_survival, normal_two_sided, sidak};

/// The keys that lie next to each other along one of the counter's axes.
const AXES: [&str; 4] = ["pixel", "sample", "dimension", "seed"];

/// Words at position `step` along an axis, the other counters small numbers as they are in a picture.
fn words(axis: usize, block: u32, step: u32) -> [u32; 4] {
    let mut counter = [block % 1013, block / 1013 % 31, block / 1013 / 31, seed_key(u64::from(block % 7))];
    counter[axis] = counter[axis].wrapping_mul(4099).wrapping_add(step);
    random4(RandomKey { pixel: counter[0], sample: counter[1], seed: counter[3] }, counter[2]).to_array()
}

fn p_of_counts(counts: &[u64]) -> f64 {
    let expected = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
    let statistic: f64 = counts.iter().map(|&c| (c as f64 - expected).powi(2) / expected).sum();
    chi_square_survival(statistic, (counts.len() - 1) as f64)
}

/// Chi-square tests of 1, 2 and 3 neighbours along each axis, of each component, of its high bits and of the
/// lowest bits that `uniform4` keeps: neither a value nor a pair nor a triple may prefer a cell.
#[test]
fn n17_neighbouring_counters_are_independent() {
    const DRAWS: u32 = 2_500_000;
    let bits_of = |dimensions: u32| 12 / dimensions;
    let cases: Vec<(usize, usize, u32, bool)> = (0..4)
        .flat_map(|axis| (0..4).map(move |component| (axis, component)))
        .flat_map(|(axis, component)| (1..=3).map(move |dimensions| (axis, component, dimensions)))
        .flat_map(|(a, c, d)| [false, true].map(|low| (a, c, d, low)))
        .collect();
    let level = sidak(FAMILY_ALPHA, cases.len());
    cases.par_iter().for_each(|&(axis, component, dimensions, low)| {
        let bits = bits_of(dimensions);
        let mut counts = vec![0u64; 1 << (bits * dimensions)];
        for block in 0..DRAWS / dimensions {
            let cell = (0..dimensions).fold(0, |cell, step| {
                let word = words(axis, block, step)[component];
                let part = if low { (word >> 8) & ((1 << bits) - 1) } else { word >> (32 - bits) };
                cell << bits | part as usize
            });
            counts[cell] += 1;
        }
        let p = p_of_counts(&counts);
        assert!(
            p > level && p < 1.0 - level,
            "{dimensions} neighbours by {}, component {component}, low bits {low}: p = {p:e}",
            AXES[axis]
        );
    });
}

/// Pairs of components of one draw.
#[test]
fn n17_components_are_independent() {
    let pairs: Vec<(usize, usize)> = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b))).collect();
    let level = sidak(FAMILY_ALPHA, pairs.len());
    for (a, b) in pairs {
        let mut counts = vec![0u64; 64 * 64];
        for block in 0..1_000_000 {
            let words = words(0, block, block % 3);
            counts[(words[a] >> 26 << 6 | words[b] >> 26) as usize] += 1;
        }
        let p = p_of_counts(&counts);
        assert!(p > level && p < 1.0 - level, "components {a} and {b}: p = {p:e}");
    }
}

/// Counters that differ in anything draw different numbers: a seed such as pixel + sample * width would give
/// neighbours each other's.
#[test]
fn n17_no_two_counters_share_numbers() {
    let key = |pixel, sample| RandomKey { pixel, sample, seed: seed_key(0) };
    let mut drawn: Vec<[u32; 4]> = (0..1000)
        .flat_map(|pixel| {
            (0..100).flat_map(move |sample| (0..4).map(move |d| random4(key(pixel, sample), d).to_array()))
        })
        .collect();
    drawn.sort_unstable();
    drawn.dedup();
    assert_eq!(drawn.len(), 400_000);
}

/// Autocorrelation along each axis at lags 1 to 64.
#[test]
fn n17_no_autocorrelation() {
    const DRAWS: usize = 1_000_000;
    let level = sidak(FAMILY_ALPHA, 4 * 64);
    (0..4usize).into_par_iter().for_each(|axis| {
        let values: Vec<f64> = (0..DRAWS as u32 + 64)
            .map(|step| f64::from(uniform_from_word(words(axis, 5, step)[axis])) - 0.5)
            .collect();
        for lag in 1..=64 {
            let sum: f64 = (0..DRAWS).map(|i| values[i] * values[i + lag]).sum();
            // A product of two such numbers has variance 1/144.
            let p = normal_two_sided(sum * 12.0 / (DRAWS as f64).sqrt());
            assert!(p > level, "lag {lag} by {}: p = {p:e}", AXES[axis]);
        }
    });
}

#[test]
fn n16_uniform_stays_below_one() {
    for word in [0, 1, 0xff, 0x100, 0xffff_ff7f, 0xffff_ff80, 0xffff_ffff] {
        let u = uniform_from_word(word);
        assert!((0.0..1.0).contains(&u), "{word:x} became {u}");
    }
    assert_eq!(uniform_from_word(u32::MAX), 0.999_999_94);
}

/// SplitMix64's published first outputs from the state 0.
#[test]
fn seed_key_is_splitmix64() {
    assert_eq!(seed_key(0), 0xe220_a839);
    assert_eq!(seed_key(0x9e37_79b9_7f4a_7c15), 0x6e78_9e6a);
}

#[test]
fn c15_rng_twin_is_bit_equal() {
    let mut stream = Stream::new(15);
    let inputs: Vec<[u32; 4]> = (0..100_000)
        .map(|i| if i < 1000 { [i, i % 7, i % 5, 0] } else { std::array::from_fn(|_| stream.word()) })
        .collect();
    let outputs: Vec<[u32; 8]> = gpu::map(
        &["lib/rng"],
        "fn twin(x: array<u32, 4>) -> array<u32, 8> {
            let key = RandomKey(x[0], x[1], x[3]);
            let words = random4(key, x[2]);
            let u = bitcast<vec4u>(uniform4(key, x[2]));
            return array<u32, 8>(words.x, words.y, words.z, words.w, u.x, u.y, u.z, u.w);
        }",
        &inputs,
    );
    for ([pixel, sample, dimension, seed], out) in inputs.into_iter().zip(outputs) {
        let key = RandomKey { pixel, sample, seed };
        assert_eq!(random4(key, dimension).to_array(), out[..4]);
        assert_eq!(uniform4(key, dimension).to_array().map(f32::to_bits), out[4..]);
    }
}
