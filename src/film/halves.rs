//! A picture's samples in two halves that know nothing of each other: every other group in the first, all others in the second.
//! What is made of one of them can be judged by the other.

use rayon::prelude::*;

use super::Picture;
use super::state::{Group, GroupPixel};
use super::sums::FilmSums;

/// Of a pixel's first half: its samples times their weights, summed, and these weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct HalfPixel {
    pub sum: [f64; 3],
    pub weight: f64,
}

impl HalfPixel {
    fn add(&mut self, other: &Self) {
        self.sum = [0, 1, 2].map(|c| self.sum[c] + other.sum[c]);
        self.weight += other.weight;
    }
}

/// Sums over the first half, in the units of [`FilmSums`]: those of the second are what is left of the film.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HalfSums {
    pub(super) pixels: Vec<HalfPixel>,
    /// Of samples before the last [`settle`](Self::settle); empty where there was none.
    pub(super) earlier: Vec<HalfPixel>,
}

impl HalfSums {
    pub fn new(pixels: usize) -> Self {
        Self { pixels: vec![HalfPixel::default(); pixels], earlier: Vec::new() }
    }

    /// The group of this number, counted from the first of the picture, belongs to the first half.
    pub fn takes(group: u32) -> bool {
        group.is_multiple_of(2)
    }

    /// Adds a group, or the part of one that there is.
    pub fn add(&mut self, group: &Group) {
        self.pixels.par_iter_mut().zip(group).for_each(|(pixel, group)| {
            let GroupPixel { sum, count, .. } = group;
            pixel.add(&HalfPixel { sum: sum.map(f64::from), weight: f64::from(*count) });
        });
    }

    /// As [`FilmSums::settle`].
    pub fn settle(&mut self) {
        self.earlier.resize(self.pixels.len(), HalfPixel::default());
        self.earlier.iter_mut().zip(&self.pixels).for_each(|(earlier, pixel)| earlier.add(pixel));
        self.pixels.fill(HalfPixel::default());
    }

    /// As [`FilmSums::weigh_earlier`].
    pub fn weigh_earlier(&mut self, factor: f64) {
        for earlier in &mut self.earlier {
            earlier.sum = earlier.sum.map(|sum| factor * sum);
            earlier.weight *= factor;
        }
    }

    /// The pictures of both halves and their shares of the film's weight; `sums` are those of all samples. Pixels of which a
    /// half has no sample are NaN in it.
    pub fn pictures(&self, sums: &FilmSums, radiance_scale: f64) -> Halves {
        let none = HalfPixel::default();
        let mut rgb = [(); 2].map(|()| Vec::with_capacity(self.pixels.len()));
        let mut weights = [0.0; 2];
        for (index, (weight, sum)) in sums.weighted().enumerate() {
            let mut first = *self.earlier.get(index).unwrap_or(&none);
            first.add(&self.pixels[index]);
            let second =
                HalfPixel { sum: [0, 1, 2].map(|c| sum[c] - first.sum[c]), weight: weight - first.weight };
            for (half, (rgb, total)) in [first, second].into_iter().zip(rgb.iter_mut().zip(&mut weights)) {
                rgb.push(half.sum.map(|sum| (sum / half.weight * radiance_scale) as f32));
                *total += half.weight;
            }
        }
        let share = |weight: f64| weight / (weights[0] + weights[1]);
        Halves {
            pictures: rgb.map(|rgb| Picture::new(sums.width, sums.height, rgb)),
            shares: weights.map(share),
        }
    }
}

/// Two pictures of the same by samples that know nothing of each other.
#[derive(Clone, Debug)]
pub struct Halves {
    pub pictures: [Picture; 2],
    /// Of the samples of both, by weight.
    pub shares: [f64; 2],
}
