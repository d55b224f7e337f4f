//! Drawing from a discrete distribution by its running sum, for draws that lie well apart: unlike an alias table, it keeps
//! their order. Probabilities are whole units of 2^-32, and those reported are those with which entries are drawn.
//!
//! Chen and Asau, On Generating Random Variates from an Empirical Distribution, AIIE Transactions 6(2), 1974.

use bytemuck::{Pod, Zeroable};

use super::alias::units_of;
use crate::math::MathError;

/// As the shaders read it: `lib/select_subspaces.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Cutpoint {
    /// Words below it draw this entry or one before it. At most 2^32 - 1.
    pub bound: u32,
    /// The first entry that a word of this slot may draw, where n slots share all words evenly.
    pub first: u32,
}

/// A discrete distribution over 0..n.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutpoints {
    entries: Vec<Cutpoint>,
    units: Vec<u64>,
}

impl Cutpoints {
    /// Draws i in proportion to `weights[i]`, in units of 2^-32. Zero weights are never drawn. A positive one gets one unit at
    /// least; the last unit of all goes to the entry before, so the last entry wants a weight of two.
    ///
    /// # Errors
    /// Those of [`super::alias::AliasTable::new`].
    pub fn new(weights: &[f64]) -> Result<Self, MathError> {
        let n = weights.len() as u64;
        let units = units_of(weights, 1 << 32)?;
        let mut sum = 0;
        let sums: Vec<u64> = units
            .iter()
            .map(|units| {
                sum += units;
                sum
            })
            .collect();
        let mut first = 0;
        let entries = (0..n)
            .map(|slot| {
                // The least word w with w n / 2^32 in the slot.
                let least = (slot << 32).div_ceil(n);
                while sums[first] <= least {
                    first += 1;
                }
                let bound = u32::try_from(sums[slot as usize]).unwrap_or(u32::MAX);
                Cutpoint { bound, first: first as u32 }
            })
            .collect();
        Ok(Self { entries, units })
    }

    /// One entry per slot, to be uploaded as they are.
    pub fn entries(&self) -> &[Cutpoint] {
        &self.entries
    }

    /// Probability (discrete) with which `index` is drawn.
    pub fn pdf_select(&self, index: usize) -> f64 {
        self.units[index] as f64 / 2f64.powi(32)
    }

    /// The entry that a word draws; mirrors `select_light_vertex` of `lib/select_subspaces.wgsl`.
    pub fn sample(&self, word: u32) -> usize {
        let word = word.min(u32::MAX - 1);
        let slot = (u64::from(word) * self.entries.len() as u64) >> 32;
        let mut index = self.entries[slot as usize].first as usize;
        while word >= self.entries[index].bound {
            index += 1;
        }
        index
    }
}
