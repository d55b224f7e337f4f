//! Integer alias tables: drawing an entry by weight with two random words, with probabilities that are known
//! exactly. A slot holds 2^32 units; entries get whole units that sum to n 2^32 exactly, and the probability
//! reported for an entry is the one with which it is drawn. A table of floats built in f32 would be wrong by up to
//! 98 % for single entries.
//!
//! Construction: Vose, A Linear Algorithm for Generating Random Numbers with a Given Distribution, IEEE TSE 17(9),
//! 1991, in integers.

use bytemuck::{Pod, Zeroable};

use crate::math::MathError;

/// Units in a slot.
const SLOT: u64 = 1 << 32;
/// Bound on the number of entries: the units of a table then stay far below 2^64, and rounding far below one slot.
const MAX_ENTRIES: usize = 1 << 28;

/// A slot as the shaders read it: levels below `threshold` draw the slot's own entry, the others `alias`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct AliasEntry {
    pub threshold: u32,
    pub alias: u32,
}

/// A discrete distribution over 0..n.
#[derive(Clone, Debug, PartialEq)]
pub struct AliasTable {
    entries: Vec<AliasEntry>,
    units: Vec<u64>,
}

impl AliasTable {
    /// A table that draws i in proportion to `weights[i]`. Positive weights get at least one unit and so are
    /// never lost; zero weights are never drawn. The same weights give the same table everywhere.
    ///
    /// # Errors
    /// No weights, more than 2^28, a negative or non-finite one, or none above zero.
    pub fn new(weights: &[f64]) -> Result<Self, MathError> {
        let units = units_of(weights, weights.len() as u64 * SLOT)?;
        let entries = entries_of(units.clone());
        Ok(Self { entries, units })
    }

    /// One entry per slot, to be uploaded as they are.
    pub fn entries(&self) -> &[AliasEntry] {
        &self.entries
    }

    /// Units of each entry; they sum to n 2^32.
    pub fn units(&self) -> &[u64] {
        &self.units
    }

    /// Probability (discrete) with which `index` is drawn.
    pub fn pdf_select(&self, index: usize) -> f64 {
        self.units[index] as f64 / (self.units.len() as f64 * SLOT as f64)
    }

    /// The entry that two random words draw; mirrors `alias_draw` and `alias_pick` of `lib/alias.wgsl`.
    pub fn sample(&self, words: [u32; 2]) -> usize {
        let fraction = u128::from(words[0]) << 32 | u128::from(words[1]);
        let product = fraction * self.entries.len() as u128;
        let (slot, level) = ((product >> 64) as usize, (product >> 32) as u32);
        let entry = self.entries[slot];
        if level < entry.threshold { slot } else { entry.alias as usize }
    }
}

/// Mixes a share `b` of the uniform distribution over the non-zero weights into them, so that a weight which was
/// estimated far too low is still drawn. The result sums to one; zero weights stay zero.
///
/// # Errors
/// Those of [`AliasTable::new`].
pub fn defensive_mix(weights: &[f64], b: f64) -> Result<Vec<f64>, MathError> {
    let (largest, sum) = checked_sum(weights)?;
    let drawable = weights.iter().filter(|&&weight| weight > 0.0).count() as f64;
    let mix = |weight: f64| (1.0 - b) * (weight / largest / sum) + b / drawable;
    Ok(weights.iter().map(|&weight| if weight > 0.0 { mix(weight) } else { 0.0 }).collect())
}

/// The largest weight, and the sum of all weights divided by it (which cannot overflow).
fn checked_sum(weights: &[f64]) -> Result<(f64, f64), MathError> {
    if weights.is_empty() {
        return Err(MathError::NoWeights);
    }
    if weights.len() > MAX_ENTRIES {
        return Err(MathError::TooManyWeights { count: weights.len(), max: MAX_ENTRIES });
    }
    if let Some(index) = weights.iter().position(|weight| !(weight.is_finite() && *weight >= 0.0)) {
        return Err(MathError::BadWeight { index, weight: weights[index] });
    }
    let largest = weights.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return Err(MathError::AllWeightsZero { count: weights.len() });
    }
    // Blockwise, so that the error of the sum grows with the square root of the count at most.
    let sum = weights.chunks(4096).map(|block| block.iter().map(|w| w / largest).sum::<f64>()).sum();
    Ok((largest, sum))
}

/// Whole units, `total` in all, in proportion to the weights. What rounding leaves over goes to the largest, which holds
/// at least its even share of them.
pub(super) fn units_of(weights: &[f64], total: u64) -> Result<Vec<u64>, MathError> {
    let (largest, sum) = checked_sum(weights)?;
    let share = total as f64 / sum;
    let unit =
        |weight: f64| if weight > 0.0 { ((weight / largest * share).round() as u64).max(1) } else { 0 };
    let mut units: Vec<u64> = weights.iter().map(|&weight| unit(weight)).collect();
    let given = units.iter().map(|&c| u128::from(c)).sum::<u128>() as i128;
    let first_largest =
        (0..weights.len()).fold(0, |best, i| if weights[i] > weights[best] { i } else { best });
    let corrected = i128::from(units[first_largest]) + i128::from(total) - given;
    units[first_largest] =
        u64::try_from(corrected).expect("rounding moves less than the largest entry's slot");
    Ok(units)
}

/// The entries of [`AliasTable::new`] alone, for tables of millions.
///
/// # Errors
/// Those of [`AliasTable::new`].
pub fn alias_entries(weights: &[f64]) -> Result<Vec<AliasEntry>, MathError> {
    Ok(entries_of(units_of(weights, weights.len() as u64 * SLOT)?))
}

/// Vose's pairing: every slot is filled by its own entry and at most one other.
fn entries_of(mut left: Vec<u64>) -> Vec<AliasEntry> {
    let mut entries: Vec<_> =
        (0..left.len() as u32).map(|alias| AliasEntry { threshold: u32::MAX, alias }).collect();
    let (mut small, mut large): (Vec<u32>, Vec<u32>) =
        (0..left.len() as u32).partition(|&i| left[i as usize] < SLOT);
    // The units that are left always fill the slots that are left, so while a slot is short another one is
    // over-full; at the end every remaining slot is exactly full and aliases to itself.
    while let (Some(&short), Some(&long)) = (small.last(), large.last()) {
        small.pop();
        let units = left[short as usize];
        entries[short as usize] = AliasEntry { threshold: units as u32, alias: long };
        let rest = &mut left[long as usize];
        *rest -= SLOT - units;
        if *rest < SLOT {
            large.pop();
            small.push(long);
        }
    }
    entries
}
