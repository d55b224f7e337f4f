//! Alias tables: exact probabilities, nothing lost, host and shader alike.

use halfway::math::MathError;
use halfway::math::alias::{AliasTable, defensive_mix};
use halfway::math::cutpoints::Cutpoints;

use crate::gpu;
use crate::random::Stream;
use crate::stats::chi_square_p;

/// Families of weights that broke tables of floats.
fn weights(n: usize) -> Vec<(&'static str, Vec<f64>)> {
    let mut stream = Stream::new(14);
    let mut u = move || stream.f64();
    vec![
        ("equal", vec![0.3; n]),
        ("30 % zeros", (0..n).map(|i| if i > 0 && u() < 0.3 { 0.0 } else { u() + 1e-3 }).collect()),
        ("20 decades", (0..n).map(|_| 10f64.powf(20.0 * u() - 10.0)).collect()),
        ("1e-37 to 1e37", (0..n).map(|i| if i % 2 == 0 { 1e-37 } else { 1e37 }).collect()),
        ("one hot", (0..n).map(|i| if i == n / 2 { 1.0 } else { 1e-30 }).collect()),
        ("one hot, the rest zero", (0..n).map(|i| if i == n / 2 { 1.0 } else { 0.0 }).collect()),
        ("beyond f32", (0..n).map(|i| if i % 3 == 0 { 1e308 } else { 1e300 * u() }).collect()),
    ]
}

/// The units with which each entry is drawn, read from the slots alone.
fn implied_units(table: &AliasTable) -> Vec<u64> {
    let mut units = vec![0u64; table.entries().len()];
    for (slot, entry) in table.entries().iter().enumerate() {
        units[slot] += u64::from(entry.threshold);
        units[entry.alias as usize] += (1 << 32) - u64::from(entry.threshold);
    }
    units
}

#[test]
fn n14_alias_exact() {
    for n in [1, 2, 3, 1000, 1_000_000, 4_000_000] {
        for (name, weights) in weights(n) {
            let table = AliasTable::new(&weights).unwrap();
            assert!(implied_units(&table) == table.units(), "{name}, n = {n}: drawn otherwise than reported");
            assert_eq!(table.units().iter().map(|&c| u128::from(c)).sum::<u128>(), (n as u128) << 32);
            let scale = weights.iter().copied().fold(0.0, f64::max);
            let sum: f64 = weights.iter().map(|w| w / scale).sum();
            let mut distance = 0.0;
            for (i, &weight) in weights.iter().enumerate() {
                assert_eq!(weight > 0.0, table.units()[i] > 0, "{name}, n = {n}: weight {i} is {weight}");
                distance += (table.pdf_select(i) - weight / scale / sum).abs();
            }
            // At most half a unit of rounding, or a whole one for weights that would round to none, each.
            assert!(0.5 * distance <= 2.4e-10, "{name}, n = {n}: total variation {:e}", 0.5 * distance);
        }
    }
}

#[test]
fn n14_alias_refuses() {
    assert_eq!(AliasTable::new(&[]), Err(MathError::NoWeights));
    assert_eq!(AliasTable::new(&[0.0, 0.0]), Err(MathError::AllWeightsZero { count: 2 }));
    assert_eq!(AliasTable::new(&[1.0, -1.0]), Err(MathError::BadWeight { index: 1, weight: -1.0 }));
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(AliasTable::new(&[bad]), Err(MathError::BadWeight { index: 0, .. })));
    }
}

/// Words at the ends of their range draw what has weight.
#[test]
fn n16_alias_extreme_words() {
    let extremes = [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ff7f, 0xffff_ff80, 0xffff_ffff];
    for n in [1, 2, 3, 7, 1000, 65_537] {
        for (name, weights) in weights(n) {
            let table = AliasTable::new(&weights).unwrap();
            for word0 in extremes {
                for word1 in extremes {
                    let drawn = table.sample([word0, word1]);
                    assert!(weights[drawn] > 0.0 && table.pdf_select(drawn) > 0.0, "{name}, n = {n}");
                }
            }
        }
    }
}

#[test]
fn n15_alias_sampled_frequencies() {
    let (n, draws) = (1000, 4_000_000);
    for (name, weights) in weights(n) {
        let table = AliasTable::new(&weights).unwrap();
        let mut stream = Stream::new(151);
        let mut observed = vec![0u64; n];
        for _ in 0..draws {
            observed[table.sample([stream.word(), stream.word()])] += 1;
        }
        let expected: Vec<f64> = (0..n).map(|i| table.pdf_select(i) * f64::from(draws)).collect();
        if name.starts_with("one hot") {
            assert!(observed[n / 2] >= draws as u64 - 1, "{name}");
        } else {
            let p = chi_square_p(&observed, &expected);
            assert!(p > 1e-4, "{name}: p = {p:e}");
        }
    }
}

#[test]
fn n21_defensive_mix_bounds_every_ratio() {
    let weights = [1e30, 1e-30, 0.0, 1.0];
    let mixed = defensive_mix(&weights, 0.05).unwrap();
    assert_eq!(mixed[2], 0.0);
    assert!((mixed.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    assert!(mixed[1] >= 0.05 / 3.0 && (mixed[0] - (0.95 + 0.05 / 3.0)).abs() < 1e-15);
    assert_eq!(defensive_mix(&[], 0.05), Err(MathError::NoWeights));
}

/// The shader draws what the host draws, for every size of table that occurs.
#[test]
fn c15_alias_twin_is_equal() {
    let mut stream = Stream::new(150);
    let inputs: Vec<[u32; 3]> = (0..100_000u32)
        .map(|i| {
            let n = match i % 4 {
                0 => 1 + stream.word() % 8,
                1 => 1 + stream.word() % (1 << 20),
                2 => 1 + stream.word() % (1 << 28),
                _ => u32::MAX - stream.word() % 8,
            };
            let word = |r: u32, w: u32| if r.is_multiple_of(8) { u32::MAX - (w & 3) } else { w };
            let [a, b, c, d] = std::array::from_fn(|_| stream.word());
            [word(a, b), word(c, d), n]
        })
        .collect();
    let outputs: Vec<[u32; 3]> = gpu::map(
        &["lib/alias"],
        "fn twin(x: array<u32, 3>) -> array<u32, 3> {
            let draw = alias_draw(vec2u(x[0], x[1]), x[2]);
            return array<u32, 3>(draw.slot, draw.level, alias_pick(draw, 0x80000000u, 77u));
        }",
        &inputs,
    );
    for ([word0, word1, n], out) in inputs.into_iter().zip(outputs) {
        let product = (u128::from(word0) << 32 | u128::from(word1)) * u128::from(n);
        let (slot, level) = ((product >> 64) as u32, (product >> 32) as u32);
        assert_eq!(
            out,
            [slot, level, if level < 0x8000_0000 { slot } else { 77 }],
            "{word0:x} {word1:x} {n}"
        );
        assert!(slot < n);
    }
}

/// Every word draws the first entry whose running sum is above it, and each entry as often as is reported.
#[test]
fn cutpoints_draw_by_the_running_sum() {
    let mut random = Stream::new(31);
    for n in [1, 2, 3, 300] {
        let sparse =
            |random: &mut Stream| if random.f32() < 0.3 { 0.0 } else { f64::from(random.f32()).powi(8) };
        let mut weights: Vec<f64> = (0..n).map(|_| sparse(&mut random)).collect();
        weights[n / 2] = 1.0;
        let table = Cutpoints::new(&weights).expect("weights");
        let sums: Vec<u64> = (0..n)
            .scan(0.0, |sum, index| {
                *sum += table.pdf_select(index) * 2f64.powi(32);
                Some(*sum as u64)
            })
            .collect();
        assert_eq!(sums[n - 1], 1 << 32);
        let total: f64 = weights.iter().sum();
        for (index, weight) in weights.iter().enumerate() {
            let pdf = table.pdf_select(index);
            assert!((pdf - weight / total).abs() <= n as f64 * 2f64.powi(-32), "{index} of {n}: {pdf}");
            assert_eq!(pdf > 0.0, *weight > 0.0);
        }
        let edges = sums.iter().flat_map(|&sum| [sum.saturating_sub(1), sum, sum + 1]);
        let edges = edges.filter_map(|word| u32::try_from(word).ok()).filter(|&word| word < u32::MAX);
        for word in edges.chain((0..10_000).map(|_| random.word().min(u32::MAX - 1))) {
            let expected = sums.iter().position(|&sum| sum > u64::from(word)).expect("an entry");
            assert_eq!(table.sample(word), expected, "{word} of {n}");
        }
    }
}
