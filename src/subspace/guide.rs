//! Where light paths should go: for each light subspace a histogram of where the light went on to that pictures are made
//! of, and for each light how often it should be picked. Light paths that follow it are denser where eye paths connect to
//! them; whatever it says, pictures are unbiased.

use std::f32::consts::TAU;

use glam::Vec3;
use rayon::prelude::*;

use super::prepare::PathWeight;
use super::sources::SourceLabels;
use super::training::{Feature, LightEnd, TrainingNode, TrainingSet};
use crate::device::layout::GuidePick;
use crate::device::scene::{LightSourceInfo, SourceKind};
use crate::math::MathError;
use crate::math::alias::{AliasEntry, AliasTable};
use crate::math::frame::Frame;
use crate::math::sampling::disk_to_square;

/// Cells along a side of the square that directions are drawn from; as in `shaders/lib/guide.wgsl`.
pub const GUIDE_SIDE: usize = 8;
/// Cells of a row.
pub const GUIDE_CELLS: usize = GUIDE_SIDE * GUIDE_SIDE;
/// Share of the histogram in what is drawn from, beside an even choice.
const MOST_SHARE: f64 = 0.5;
/// Paths from which on it has all of it; with fewer, less.
const ENOUGH_PATHS: f64 = 1e5;
/// Paths per task. Fixed: sums are cut in the same places for any number of threads.
const TASK: usize = 1 << 16;

/// Probabilities by which light paths are drawn; all of them positive where there is light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightGuide {
    /// K rows of [`GUIDE_CELLS`], column by column of the square; each sums to 1.
    pub cells: Vec<f32>,
    /// Of each light of the device's list; they sum to 1.
    pub picks: Vec<f32>,
}

impl LightGuide {
    /// Says nothing.
    pub fn even(subspaces: u32, lights: &[LightSourceInfo]) -> Self {
        Self { cells: even_cells(subspaces), picks: lights.iter().map(|light| light.power as f32).collect() }
    }

    /// The lights' alias table as the device draws from it.
    ///
    /// # Errors
    /// Probabilities that are none; those of a trained or loaded model are.
    pub fn pick_table(&self) -> Result<Vec<GuidePick>, MathError> {
        let picks: Vec<f64> = self.picks.iter().map(|&pick| f64::from(pick)).collect();
        let table = AliasTable::new(&picks)?;
        let pick = |(index, entry): (usize, &AliasEntry)| GuidePick {
            threshold: entry.threshold,
            alias_index: entry.alias,
            pdf_select: table.pdf_select(index) as f32,
            pad: 0,
        };
        Ok(table.entries().iter().enumerate().map(pick).collect())
    }
}

/// Rows that say nothing.
pub fn even_cells(subspaces: u32) -> Vec<f32> {
    vec![1.0 / GUIDE_CELLS as f32; subspaces as usize * GUIDE_CELLS]
}

/// Rows as the device draws from them: for each the upper bounds of the columns' shares, then of the cells' in each column.
pub fn cell_bounds(cells: &[f32]) -> Vec<f32> {
    cells.chunks(GUIDE_CELLS).flat_map(bounds).collect()
}

fn bounds(row: &[f32]) -> Vec<f32> {
    let cells: Vec<f64> = row.iter().map(|&cell| f64::from(cell)).collect();
    let columns: Vec<f64> = cells.chunks(GUIDE_SIDE).map(|column| column.iter().sum()).collect();
    let upper = |parts: &[f64]| -> Vec<f32> {
        let total: f64 = parts.iter().sum();
        let mut sum = 0.0;
        let mut upper: Vec<f32> = parts
            .iter()
            .map(|part| {
                sum += part;
                (sum / total) as f32
            })
            .collect();
        // So that the last interval holds all that is left.
        upper[GUIDE_SIDE - 1] = 1.0;
        upper
    };
    let mut all = upper(&columns);
    all.extend(cells.chunks(GUIDE_SIDE).flat_map(upper));
    all
}

/// What a guide is learnt from.
pub(super) struct GuideInput<'a> {
    pub set: &'a TrainingSet,
    pub weights: &'a [PathWeight],
    /// Row and column of Gamma of each node.
    pub labels: &'a [(u32, u32)],
    pub gamma: &'a [f32],
    pub q: &'a [f64],
    pub lights: &'a [LightSourceInfo],
    pub sources: &'a [SourceLabels],
    pub subspaces: u32,
}

/// Light that goes on from each subspace into each cell, and that each light sends.
#[derive(Clone)]
struct Sums {
    cells: Vec<f64>,
    lights: Vec<f64>,
}

impl GuideInput<'_> {
    /// The guide, from the paths that are not held out; and the mean of the logarithm of its density over that of even
    /// choices along light paths that are, each as it counts: 0 where it says nothing. `None` where none is held out.
    pub fn learn(&self) -> (LightGuide, Option<f64>) {
        let paths = self.weights.len();
        let parts: Vec<Sums> = (0..paths)
            .step_by(TASK)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|first| {
                let mut sums = self.nothing();
                for path in (first..paths.min(first + TASK)).filter(|&path| !self.weights[path].held_out) {
                    self.edges(path, |label, cell, weight| sums.cells[label * GUIDE_CELLS + cell] += weight);
                    self.light(path, |light, weight| sums.lights[light] += weight);
                }
                sums
            })
            .collect();
        let mut sums = self.nothing();
        for part in parts {
            sums.cells.iter_mut().zip(part.cells).for_each(|(sum, part)| *sum += part);
            sums.lights.iter_mut().zip(part.lights).for_each(|(sum, part)| *sum += part);
        }
        let taught = self.weights.iter().filter(|path| path.weight > 0.0 && !path.held_out).count();
        let share = MOST_SHARE * (taught as f64 / ENOUGH_PATHS).min(1.0);
        let guide = LightGuide {
            cells: sums.cells.chunks(GUIDE_CELLS).flat_map(|row| mixed(row, share)).collect(),
            picks: self.picks(&sums.lights, share),
        };
        let gain = self.gain(&guide);
        (guide, gain)
    }

    fn nothing(&self) -> Sums {
        Sums { cells: vec![0.0; self.subspaces as usize * GUIDE_CELLS], lights: vec![0.0; self.lights.len()] }
    }

    /// Densities of connecting at the path's nodes, over that of the path; and their sum with that of being hit.
    fn densities(&self, path: usize) -> (Vec<f64>, f64) {
        let density = |at: usize| {
            let (row, column) = self.labels[at];
            let share = f64::from(self.gamma[(row * self.subspaces + column) as usize]);
            share * f64::from(self.set.nodes()[at].mass) / self.q[column as usize]
        };
        let densities: Vec<f64> = self.set.nodes_of(path).map(density).collect();
        let total = f64::from(self.set.paths()[path].p0) + densities.iter().sum::<f64>();
        (densities, total)
    }

    /// Visits the edges of a path that its light side may have sampled: light subspace and cell of where light sets out, and
    /// the path's weight times the share of strategies that sample the edge so.
    fn edges(&self, path: usize, mut visit: impl FnMut(usize, usize, f64)) {
        let weight = self.weights[path].weight;
        if weight == 0.0 {
            return;
        }
        let (densities, total) = self.densities(path);
        if !(total > 0.0 && total.is_finite()) {
            return;
        }
        // Strategies that connect nearer to the eye.
        let mut nearer = 0.0;
        for (at, density) in self.set.nodes_of(path).zip(densities) {
            let node = &self.set.nodes()[at];
            if nearer > 0.0
                && let Some(cell) = self.cell(node)
            {
                visit(self.labels[at].1 as usize, cell, weight * nearer / total);
            }
            nearer += density;
        }
    }

    /// Visits the light that a path ends on, with the path's weight times the share of strategies that start from there.
    fn light(&self, path: usize, mut visit: impl FnMut(usize, f64)) {
        let weight = self.weights[path].weight;
        let last = self.set.nodes_of(path).last().map(|at| self.set.nodes()[at].light);
        if let (true, Some(LightEnd::Source { light, .. })) = (weight > 0.0, last) {
            let (densities, total) = self.densities(path);
            if total > 0.0 && total.is_finite() {
                visit(light as usize, weight * densities.iter().sum::<f64>() / total);
            }
        }
    }

    /// Where in the square light sets out from a node's light end to its eye end. `None`: no such direction is drawn.
    fn cell(&self, node: &TrainingNode) -> Option<usize> {
        let leaves = -node.towards;
        let square = match node.light {
            LightEnd::Surface(Feature { normal, .. }) => hemisphere_square(normal, leaves)?,
            LightEnd::Source { light, .. } => match self.lights[light as usize].kind {
                SourceKind::Triangle { normal, .. } => {
                    hemisphere_square(normal * normal.dot(leaves).signum(), leaves)?
                }
                SourceKind::Environment => disk(leaves, node.eye.position),
                SourceKind::Punctual { direction, cone, .. } if cone > 0.0 => {
                    let local =
                        Frame::from_normal(if cone < 2.0 { direction } else { Vec3::Z }).to_local(leaves);
                    // The inverse of `sample_uniform_cone`.
                    glam::Vec2::new((1.0 - local.z) / cone, 0.5 + local.y.atan2(local.x) / TAU)
                }
                SourceKind::Punctual { direction, .. } => disk(direction, node.eye.position),
            },
        };
        square.is_finite().then(|| {
            let at = |x: f32| ((x * GUIDE_SIDE as f32).max(0.0) as usize).min(GUIDE_SIDE - 1);
            at(square.x) * GUIDE_SIDE + at(square.y)
        })
    }

    /// Lights share what was learnt of their group, each by its power: single ones may be too many to know.
    fn picks(&self, sums: &[f64], share: f64) -> Vec<f32> {
        let mut groups = vec![[0.0; 2]; self.subspaces as usize];
        for ((light, of), sum) in self.lights.iter().zip(self.sources).zip(sums) {
            groups[of.first as usize][0] += light.power;
            groups[of.first as usize][1] += sum;
        }
        let total: f64 = sums.iter().sum();
        let pick = |(light, of): (&LightSourceInfo, &SourceLabels)| {
            let [power, sum] = groups[of.first as usize];
            let learnt = if total > 0.0 && power > 0.0 { sum / total / power } else { 1.0 };
            (light.power * (1.0 - share + share * learnt)) as f32
        };
        self.lights.iter().zip(self.sources).map(pick).collect()
    }

    fn gain(&self, guide: &LightGuide) -> Option<f64> {
        let of_path = |path: usize| {
            let mut sums = [0.0; 2];
            self.edges(path, |label, cell, weight| {
                let density = f64::from(guide.cells[label * GUIDE_CELLS + cell]) * GUIDE_CELLS as f64;
                sums[0] += weight * density.ln();
                sums[1] += weight;
            });
            sums
        };
        let held_out = (0..self.weights.len()).into_par_iter().filter(|&path| self.weights[path].held_out);
        let sums: Vec<[f64; 2]> = held_out.map(of_path).collect();
        let [gain, weight] = [0, 1].map(|which| sums.iter().map(|sums| sums[which]).sum::<f64>());
        (weight > 0.0).then_some(gain / weight)
    }
}

/// A share of what was learnt of a row, the rest evenly; all of it where nothing was.
fn mixed(row: &[f64], share: f64) -> Vec<f32> {
    let total: f64 = row.iter().sum();
    let share = if total > 0.0 && total.is_finite() { share } else { 0.0 };
    let even = (1.0 - share) / GUIDE_CELLS as f64;
    row.iter().map(|cell| (even + if share > 0.0 { share * cell / total } else { 0.0 }) as f32).collect()
}

/// The inverse of cosine-weighted sampling about the normal; `None` below the horizon.
fn hemisphere_square(normal: Vec3, leaves: Vec3) -> Option<glam::Vec2> {
    let local = Frame::from_normal(normal).to_local(leaves);
    (local.z > 0.0).then(|| disk_to_square(local.truncate()))
}

/// Where parallel light that sets out along `leaves` to `position` crosses the disk that it starts from, which covers the
/// unit scene.
fn disk(leaves: Vec3, position: Vec3) -> glam::Vec2 {
    let local = Frame::from_normal(leaves).to_local(position);
    disk_to_square(local.truncate())
}
