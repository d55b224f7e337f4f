//! The samples of a render in two halves, beside its film.
//!
//! The device's sums are taken over group by group then. The host adds the groups of a block up as the device does, so that
//! the picture is the same to the last bit.

use std::mem;

use rayon::prelude::*;

use super::RenderOptions;
use crate::device::layout::FilmPixel;
use crate::film::halves::HalfSums;
use crate::film::state::{Group, add_group, pixel_sums};
use crate::film::sums::FilmSums;

/// Of the word [`FilmPixel::open_groups`]: samples of the open group, beside the number of whole ones.
const SAMPLES_OF_OPEN: u32 = 0xff;

/// Halves of a render that goes on.
pub(super) struct HalvesInProgress {
    pub first: HalfSums,
    /// The block that is not whole yet, without the group that is not; empty where there is none.
    block: Vec<FilmPixel>,
}

impl HalvesInProgress {
    /// Of a render that begins, where it wants them.
    pub fn begin(options: &RenderOptions, pixels: usize) -> Option<Self> {
        options.halves.then(|| Self { first: HalfSums::new(pixels), block: Vec::new() })
    }

    /// Of a render that goes on from there.
    pub fn going_on(first: HalfSums) -> Self {
        Self { first, block: Vec::new() }
    }

    /// Takes the block of a film that is not whole, and leaves the group that is not.
    pub fn take_block(&mut self, film: &mut [FilmPixel]) {
        let whole = |pixel: &FilmPixel| FilmPixel {
            open: [0.0; 3],
            open_groups: pixel.open_groups & !SAMPLES_OF_OPEN,
            ..*pixel
        };
        self.block = film.iter().map(whole).collect();
        for pixel in film {
            let open_groups = pixel.open_groups & SAMPLES_OF_OPEN;
            *pixel = FilmPixel { open: pixel.open, open_groups, ..FilmPixel::default() };
        }
    }

    /// Adds the group of this number, to the first half where it belongs to it, and to its block.
    pub fn add(&mut self, index: u32, group: &Group, is_apart: bool) {
        if HalfSums::takes(index) {
            self.first.add(group);
        }
        // One that is apart is kept beside the film.
        if !is_apart {
            self.block.resize(group.len(), FilmPixel::default());
            add_group(&mut self.block, group);
        }
    }

    /// Adds a block to the sums as far as it goes.
    pub fn end_block(&mut self, sums: &mut FilmSums) {
        let block = mem::take(&mut self.block);
        if !block.is_empty() {
            sums.add(block.par_iter().map(pixel_sums));
        }
    }

    /// Adds the block, as far as it goes, to its group that is not whole.
    pub fn add_block_to(&self, open: &mut Vec<FilmPixel>) {
        if open.is_empty() {
            open.clone_from(&self.block);
            return;
        }
        for (open, block) in open.iter_mut().zip(&self.block) {
            let non_finite = open.non_finite + block.non_finite;
            let open_groups = open.open_groups + block.open_groups;
            *open = FilmPixel { open: open.open, open_groups, non_finite, ..*block };
        }
    }
}

/// Why a picture has no halves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoHalves {
    /// Its options do not ask for them, or the render went on from samples that were not kept in halves.
    NotKept,
    /// All samples are of one group.
    OneGroup,
}
