//! Weights of the training paths: relative to the brightness of their part of the picture, outliers held back, faulty
//! ones left out and counted, and some kept aside to judge the optimisation.

use rayon::prelude::*;

use super::settings::Settings;
use super::training::{LightEnd, TrainingSet};
use crate::math::rng::{pcg4d, seed_key};
use crate::subspace::SubspaceError;

/// Brightness that is added to every tile's, relative to the picture's mean: dark tiles do not count without bound.
const TILE_FLOOR: f64 = 1e-3;
/// Largest W relative to the mean of all: outliers beyond it would decide the loss alone.
const LARGEST_SQUARED: f64 = 1000.0;
/// Largest weight as a sample, relative to the mean of all.
const LARGEST_WEIGHT: f64 = 10.0;
/// Keeps the choice of held-out paths apart from other uses of the seed.
const HELD_OUT_STREAM: u32 = 0x4845_4c44;

/// A path's part in the training.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathWeight {
    /// W: square of the contribution after tile normalisation, over the share of the way that found the path.
    pub squared: f64,
    /// The contribution as a weight for centroids and the contribution matrix; 0: the path takes no part.
    pub weight: f64,
    pub held_out: bool,
}

/// What [`weigh`] found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weighed {
    pub paths: Vec<PathWeight>,
    /// Paths with a number that is negative, infinite or none; left out.
    pub faulty: u64,
    /// Paths whose W was held back.
    pub clamped: u64,
}

/// Weighs the paths. Brightness and outlier bounds are of all paths: they define what is minimised. Everything that
/// is learnt from paths (centroids, trees, the contribution matrix, Gamma) comes from those not held out.
///
/// # Errors
/// A tile or a light that does not exist.
pub fn weigh(
    set: &TrainingSet,
    lights: usize,
    settings: &Settings,
    seed: u64,
) -> Result<Weighed, SubspaceError> {
    let tiles = set.tile_pixels().len();
    if let Some(path) = set.paths().iter().find(|path| path.tile as usize >= tiles) {
        return Err(SubspaceError::UnknownTile { tile: path.tile, count: tiles });
    }
    check_lights(set.nodes().par_iter().map(|node| &node.light), lights)?;

    let is_sound = |index: usize| {
        let path = &set.paths()[index];
        let good = |x: f32| x.is_finite() && x >= 0.0;
        let sound_node = |at: usize| {
            let node = &set.nodes()[at];
            good(node.mass) && node.eye.is_finite() && node.light.is_finite()
        };
        good(path.contribution) && good(path.p0) && path.share > 0.0 && set.nodes_of(index).all(sound_node)
    };
    let sound: Vec<bool> = (0..set.paths().len()).into_par_iter().map(is_sound).collect();

    let mut brightness = vec![0.0; tiles];
    for (path, _) in set.paths().iter().zip(&sound).filter(|(_, sound)| **sound) {
        brightness[path.tile as usize] += f64::from(path.contribution);
    }
    let pixels: f64 = set.tile_pixels().iter().map(|count| f64::from(*count)).sum();
    let mean = brightness.iter().sum::<f64>() / pixels;
    for (sum, pixels) in brightness.iter_mut().zip(set.tile_pixels()) {
        *sum = *sum / f64::from(*pixels) + TILE_FLOOR * mean;
    }

    let mut paths: Vec<PathWeight> = set
        .paths()
        .iter()
        .zip(&sound)
        .enumerate()
        .map(|(index, (path, sound))| {
            let counts = *sound && path.contribution > 0.0;
            let contribution =
                if counts { f64::from(path.contribution) / brightness[path.tile as usize] } else { 0.0 };
            PathWeight {
                squared: contribution * contribution / f64::from(path.share),
                weight: contribution,
                held_out: is_held_out(set.group_of(index), settings, seed),
            }
        })
        .collect();
    let count = paths.iter().filter(|path| path.weight > 0.0).count().max(1) as f64;
    let most_squared = LARGEST_SQUARED * paths.iter().map(|path| path.squared).sum::<f64>() / count;
    let most_weight = LARGEST_WEIGHT * paths.iter().map(|path| path.weight).sum::<f64>() / count;
    let mut clamped = 0;
    for path in &mut paths {
        clamped += u64::from(path.squared > most_squared);
        path.squared = path.squared.min(most_squared);
        path.weight = path.weight.min(most_weight);
    }
    let faulty = sound.iter().filter(|sound| !**sound).count() as u64;
    Ok(Weighed { paths, faulty, clamped })
}

/// Every light that is named exists.
pub(super) fn check_lights<'a>(
    ends: impl ParallelIterator<Item = &'a LightEnd>,
    lights: usize,
) -> Result<(), SubspaceError> {
    let unknown = |end: &LightEnd| match end {
        LightEnd::Source { light, .. } if *light as usize >= lights => Some(*light),
        _ => None,
    };
    match ends.filter_map(unknown).min() {
        Some(light) => Err(SubspaceError::UnknownLight { light, count: lights }),
        None => Ok(()),
    }
}

/// By the group and the seed alone.
fn is_held_out(group: u32, settings: &Settings, seed: u64) -> bool {
    let key = [group, 0, HELD_OUT_STREAM, seed_key(seed)];
    f64::from(pcg4d(key)[0]) < settings.held_out * 2f64.powi(32)
}
