//! The film of a render as one value: what its samples have come to, wherever it lies.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::sums::{FilmSums, PixelSums, SAMPLES_A_FLUSH};
use crate::device::layout::{FilmPixel, SAMPLES_A_GROUP};

/// Unit of the sums of dim squares in `shaders/film_accumulate.wgsl`, which are negative: -2^-120.
const DIM_UNIT: f32 = -1.0 / (1u128 << 120) as f32;
/// Below it squares are dim, and what they are multiplied by before they are squared (there as well).
const DIM: f32 = 1.0 / (1u64 << 50) as f32;
const DIM_SCALE: f32 = (1u64 << 60) as f32;

/// Blocks of [`SAMPLES_A_FLUSH`] samples, counted from the first of the picture, are summed in `f32` before they are added
/// to the sums. A block's sum depends on the order of its groups, which is theirs in the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmState {
    /// Over whole blocks.
    pub sums: FilmSums,
    /// Blocks that are not whole, as far as they go from their first group on; by their numbers.
    pub open: BTreeMap<u32, Vec<FilmPixel>>,
    /// Groups of blocks whose first ones are not here, one by one.
    pub groups: BTreeMap<u32, Group>,
}

/// One group of every pixel; its number is counted from the first of the picture.
pub type Group = Vec<GroupPixel>;

/// A pixel's group.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupPixel {
    pub sum: [f32; 3],
    /// Samples in the sum, and those that were left out because they were not finite.
    pub count: u32,
    pub non_finite: u32,
}

/// Groups of a block.
const GROUPS_A_BLOCK: u32 = SAMPLES_A_FLUSH / SAMPLES_A_GROUP;

/// The samples that a film has taken, which are one group and nothing else.
pub fn group_of(film: &[FilmPixel]) -> Group {
    let pixel =
        |pixel: &FilmPixel| GroupPixel { sum: pixel.sum, count: pixel.count, non_finite: pixel.non_finite };
    film.iter().map(pixel).collect()
}

/// What has been taken of a group that is not whole yet.
pub fn open_group_of(film: &[FilmPixel]) -> Group {
    let pixel =
        |pixel: &FilmPixel| GroupPixel { sum: pixel.open, count: pixel.open_groups & 0xff, non_finite: 0 };
    film.iter().map(pixel).collect()
}

/// Adds a group to what the groups before it have come to, as the device would have done.
pub fn add_group(film: &mut [FilmPixel], group: &Group) {
    film.par_iter_mut().zip(group).for_each(|(pixel, group)| {
        pixel.non_finite += group.non_finite;
        if group.count > 0 {
            for channel in 0..3 {
                pixel.sum[channel] += group.sum[channel];
                pixel.sum_sq[channel] =
                    add_square(pixel.sum_sq[channel], group.sum[channel], group.count as f32);
            }
            pixel.count += group.count;
            pixel.open_groups += 1 << 8;
        }
    });
}

/// As `add_square` of `shaders/film_accumulate.wgsl`.
fn add_square(sum_sq: f32, x: f32, samples: f32) -> f32 {
    if sum_sq > 0.0 || x.abs() >= DIM {
        let plain = if sum_sq < 0.0 { sum_sq * DIM_UNIT } else { sum_sq };
        return plain + x * x / samples;
    }
    let scaled = x * DIM_SCALE;
    sum_sq - scaled * scaled / samples
}

/// A pixel of the film as the device hands it over.
pub fn pixel_sums(pixel: &FilmPixel) -> PixelSums {
    let unit = |value: f32| if value < 0.0 { f64::from(DIM_UNIT) } else { 1.0 };
    let mut sums = PixelSums {
        sum: pixel.sum.map(f64::from),
        sum_sq: pixel.sum_sq.map(|value| f64::from(value) * unit(value)),
        count: u64::from(pixel.count),
        groups: u64::from(pixel.open_groups >> 8),
        non_finite: u64::from(pixel.non_finite),
    };
    sums.add_group(pixel.open.map(f64::from), u64::from(pixel.open_groups & 0xff));
    sums
}

impl FilmState {
    /// No samples of a picture of so many pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { sums: FilmSums::new(width, height), ..Self::default() }
    }

    /// Samples left out because they were not finite.
    pub fn non_finite(&self) -> u64 {
        let open = self.open.values().flatten().map(|pixel| u64::from(pixel.non_finite));
        let groups = self.groups.values().flatten().map(|pixel| u64::from(pixel.non_finite));
        self.sums.non_finite() + open.sum::<u64>() + groups.sum::<u64>()
    }

    /// Adds other samples of as many pixels.
    pub fn add(&mut self, other: Self) {
        self.sums.add_sums(&other.sums);
        self.open.extend(other.open);
        self.groups.extend(other.groups);
    }

    /// No more samples will come before `end`: parts of blocks become one as far as their first groups are here.
    pub fn fold(&mut self, end: u32) {
        let by_block = self.groups.keys().map(|index| index / GROUPS_A_BLOCK);
        let blocks: BTreeSet<u32> = self.open.keys().copied().chain(by_block).collect();
        for block in blocks {
            let first = block * GROUPS_A_BLOCK;
            if self.open.contains_key(&block) || self.groups.contains_key(&first) {
                let film = self.take_block(block);
                match u64::from(block + 1) * u64::from(SAMPLES_A_FLUSH) <= u64::from(end) {
                    true => self.sums.add(film.par_iter().map(pixel_sums)),
                    false => drop(self.open.insert(block, film)),
                }
            }
        }
    }

    /// What there is of a block, in the order of its groups.
    fn take_block(&mut self, block: u32) -> Vec<FilmPixel> {
        let mut film = self.open.remove(&block).unwrap_or_default();
        film.resize(self.sums.pixels.len(), FilmPixel::default());
        for index in block * GROUPS_A_BLOCK..(block + 1) * GROUPS_A_BLOCK {
            if let Some(group) = self.groups.remove(&index) {
                add_group(&mut film, &group);
            }
        }
        film
    }

    /// All samples of each pixel together.
    pub fn into_sums(mut self) -> FilmSums {
        self.fold(u32::MAX);
        while let Some(index) = self.groups.keys().next().copied() {
            let film = self.take_block(index / GROUPS_A_BLOCK);
            self.sums.add(film.par_iter().map(pixel_sums));
        }
        self.open.into_values().for_each(|film| self.sums.add(film.par_iter().map(pixel_sums)));
        self.sums
    }
}
