//! Centroids of the subspaces: training vertices drawn in proportion to what their paths contribute, moved to the middle of
//! what is nearest to them, and the nearest of them to a vertex.

use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::training::Feature;
use crate::math::rng::{RandomKey, random4, seed_key};

/// Centroids that the search looks at together.
const LANES: usize = 4;

/// Squared distance d_s^2 + s2 (1 - cos_n) + k_d s2 (1 - cos_d), and the centroids it is taken to.
#[derive(Clone, Debug)]
pub struct Centroids {
    features: Vec<Feature>,
    normal_scale: f32,
    direction_scale: f32,
    /// The features' nine numbers, [`LANES`] centroids at a time.
    lanes: Vec<[Vec4; 9]>,
}

/// s2: the largest variance of the positions along an axis.
pub fn largest_variance(positions: impl Iterator<Item = Vec3> + Clone) -> f32 {
    let count = positions.clone().count().max(1) as f64;
    let mean = positions.clone().map(|p| p.as_dvec3()).sum::<glam::DVec3>() / count;
    let sum: glam::DVec3 = positions.map(|p| (p.as_dvec3() - mean) * (p.as_dvec3() - mean)).sum();
    (sum.max_element() / count) as f32
}

/// At most `count` different indices in proportion to the weights: systematic sampling (one random number, then equal
/// steps through the running sum), where a weight above the step counts once.
pub fn systematic(weights: impl Iterator<Item = f64> + Clone, count: u32, seed: u64) -> Vec<u32> {
    let total: f64 = weights.clone().sum();
    // A sum of nothing, or one that overflowed, has nothing to draw from.
    if !(total > 0.0 && total.is_finite()) || count == 0 {
        return Vec::new();
    }
    let step = total / f64::from(count);
    let word = random4(RandomKey { pixel: 0, sample: 0, seed: seed_key(seed) }, 0).x;
    let mut next = (f64::from(word) + 0.5) / 2f64.powi(32) * step;
    let mut running = 0.0;
    let mut drawn = Vec::with_capacity(count as usize);
    for (index, weight) in weights.enumerate() {
        running += weight;
        if running > next && weight > 0.0 {
            drawn.push(index as u32);
            next += step * (((running - next) / step).floor() + 1.0);
        }
    }
    drawn
}

impl Centroids {
    /// `variance`: s2. `direction_weight`: k_d.
    pub fn new(features: Vec<Feature>, variance: f32, direction_weight: f32) -> Self {
        // A scene seen at one point only is still classified by its normals.
        let normal_scale = variance.max(f32::MIN_POSITIVE);
        Self::with_scales(features, normal_scale, direction_weight * normal_scale)
    }

    fn with_scales(features: Vec<Feature>, normal_scale: f32, direction_scale: f32) -> Self {
        let lanes = features
            .chunks(LANES)
            .map(|chunk| {
                std::array::from_fn(|number| {
                    // Absent centroids are infinitely far.
                    let of = |lane: usize| chunk.get(lane).map_or(f32::INFINITY, |f| numbers(f)[number]);
                    Vec4::from_array(std::array::from_fn(of))
                })
            })
            .collect();
        Self { features, normal_scale, direction_scale, lanes }
    }

    /// Each centroid moves to the mean of the features that are nearest to it, `steps` times; normals and directions are made
    /// unit vectors again. A centroid that is nearest to none stays.
    /// Lloyd, Least Squares Quantization in PCM, IEEE Transactions on Information Theory 28(2), 1982.
    pub fn relaxed(self, samples: &[Feature], steps: u32) -> Self {
        (0..steps).fold(self, |centroids, _| {
            let nearest: Vec<u32> = samples.par_iter().map(|sample| centroids.nearest(sample)).collect();
            let mut sums = vec![Sum::default(); centroids.features.len()];
            for (sample, nearest) in samples.iter().zip(nearest) {
                sums[nearest as usize].add(sample);
            }
            let features = sums.iter().zip(&centroids.features).map(|(sum, old)| sum.mean(old)).collect();
            Self::with_scales(features, centroids.normal_scale, centroids.direction_scale)
        })
    }

    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Of each centroid, itself and the nearest others, `count` in all if there are so many; the first of equals.
    pub fn neighbours(&self, count: usize) -> Vec<Vec<u32>> {
        let of = |index: usize| {
            let distance = |other: usize| match other == index {
                true => f32::NEG_INFINITY,
                false => self.distance(&self.features[index], &self.features[other]),
            };
            let mut order: Vec<(f32, u32)> =
                (0..self.features.len()).map(|other| (distance(other), other as u32)).collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            order.iter().take(count).map(|(_, other)| *other).collect()
        };
        (0..self.features.len()).into_par_iter().map(of).collect()
    }

    fn distance(&self, a: &Feature, b: &Feature) -> f32 {
        a.position.distance_squared(b.position)
            + self.normal_scale * (1.0 - a.normal.dot(b.normal))
            + self.direction_scale * (1.0 - a.direction.dot(b.direction))
    }

    /// Index of the nearest centroid, the first of equals; 0 if there are none.
    pub fn nearest(&self, feature: &Feature) -> u32 {
        let x = numbers(feature).map(Vec4::splat);
        let (mut least, mut nearest) = (f32::INFINITY, 0);
        for (group, c) in self.lanes.iter().enumerate() {
            let (dx, dy, dz) = (x[0] - c[0], x[1] - c[1], x[2] - c[2]);
            let mut distance = dx * dx + dy * dy + dz * dz;
            // Nearly all are too far away already.
            if !distance.cmplt(Vec4::splat(least)).any() {
                continue;
            }
            distance += self.normal_scale * (1.0 - (x[3] * c[3] + x[4] * c[4] + x[5] * c[5]));
            if self.direction_scale > 0.0 {
                distance += self.direction_scale * (1.0 - (x[6] * c[6] + x[7] * c[7] + x[8] * c[8]));
            }
            for (lane, distance) in distance.to_array().into_iter().enumerate() {
                if distance < least {
                    (least, nearest) = (distance, (group * LANES + lane) as u32);
                }
            }
        }
        nearest
    }
}

/// Of features, number by number.
#[derive(Clone, Copy, Default)]
struct Sum {
    position: DVec3,
    normal: DVec3,
    direction: DVec3,
    count: f64,
}

impl Sum {
    fn add(&mut self, feature: &Feature) {
        self.position += feature.position.as_dvec3();
        self.normal += feature.normal.as_dvec3();
        self.direction += feature.direction.as_dvec3();
        self.count += 1.0;
    }

    /// What there is no mean of is as in `old`.
    fn mean(&self, old: &Feature) -> Feature {
        if self.count == 0.0 {
            return *old;
        }
        let unit = |sum: DVec3, old: Vec3| sum.try_normalize().map_or(old, |unit| unit.as_vec3());
        Feature {
            position: (self.position / self.count).as_vec3(),
            normal: unit(self.normal, old.normal),
            direction: unit(self.direction, old.direction),
        }
    }
}

fn numbers(f: &Feature) -> [f32; 9] {
    let (p, n, d) = (f.position, f.normal, f.direction);
    [p.x, p.y, p.z, n.x, n.y, n.z, d.x, d.y, d.z]
}
