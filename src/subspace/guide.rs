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
/// Most that a histogram has of what is drawn from, beside an even choice.
const MOST_SHARE: f64 = 0.5;
/// A histogram has half of that where as many independent observations made it as it has cells.
const OBSERVATIONS_PER_CELL: f64 = 1.0;
/// Of light sub-paths and eye paths, so many of all judge what the others taught.
const JUDGES: u64 = 8;

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
        Self {
            cells: even_cells(subspaces),
            picks: powers(lights).into_iter().map(|power| power as f32).collect(),
        }
    }

    /// Of each light subspace: its strongest cell over an even one, at least 1.
    pub fn strongest(&self) -> Vec<f64> {
        let most = |row: &[f32]| row.iter().copied().fold(0.0, f32::max);
        self.cells.chunks(GUIDE_CELLS).map(|row| f64::from(most(row)) * GUIDE_CELLS as f64).collect()
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

/// Of each light, as a share of all.
fn powers(lights: &[LightSourceInfo]) -> Vec<f64> {
    let total: f64 = lights.iter().map(|light| light.power).sum();
    lights.iter().map(|light| light.power / total).collect()
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

/// Light that was seen to set out.
#[derive(Clone, Copy)]
struct Seen {
    /// A light subspace, or a group of lights.
    row: u32,
    cell: u32,
    /// What was seen with the same eye path or light sub-path is one observation.
    by: u64,
    weight: f64,
}

impl GuideInput<'_> {
    /// The guide; and the mean of the logarithm of its density over that of even choices along light paths that had no part
    /// in it, each as it counts: 0 where it says nothing. `None` where there are none. `step`: from every so many-th path.
    pub fn learn(&self, step: usize) -> (LightGuide, Option<f64>) {
        let count = self.weights.len().div_ceil(step);
        let paths = (0..count).into_par_iter().map(|index| index * step);
        let of_edges = |path: usize| {
            let mut seen = Vec::new();
            self.edges(path, |one| seen.push(one));
            seen
        };
        let of_lights = |path: usize| self.light(path);
        let (judging, taught): (Vec<Seen>, Vec<Seen>) =
            paths.clone().flat_map_iter(of_edges).partition(|seen| judges(seen.by));
        let lights: Vec<Seen> = paths.filter_map(of_lights).collect();

        let mut cells = vec![0.0; self.subspaces as usize * GUIDE_CELLS];
        let trust = rows(taught, self.subspaces, |seen| {
            cells[seen.row as usize * GUIDE_CELLS + seen.cell as usize] += seen.weight;
        });
        let cells = cells.chunks(GUIDE_CELLS).zip(trust).flat_map(|(row, observations)| {
            let share = share_of(observations, GUIDE_CELLS as f64);
            mixed(row, share)
        });
        let guide = LightGuide { cells: cells.collect(), picks: self.picks(lights) };
        let gain = gain(&guide, &judging);
        (guide, gain)
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

    /// Visits the edges of a path that its light side may have sampled: where light sets out and whereto, with the path's
    /// weight times the share of strategies that sample the edge so.
    fn edges(&self, path: usize, mut visit: impl FnMut(Seen)) {
        let weight = self.weights[path].weight;
        if weight == 0.0 {
            return;
        }
        let (densities, total) = self.densities(path);
        if !(total > 0.0 && total.is_finite()) {
            return;
        }
        let of = &self.set.paths()[path];
        // Strategies that connect nearer to the eye.
        let mut nearer = 0.0;
        for (number, (at, density)) in self.set.nodes_of(path).zip(densities).enumerate() {
            let node = &self.set.nodes()[at];
            if nearer > 0.0
                && let Some(cell) = self.cell(node)
            {
                let by_eye = (number as u32) < of.eye_edges;
                let by = if by_eye { eye_path(self.set.group_of(path)) } else { of.light_path };
                visit(Seen {
                    row: self.labels[at].1,
                    cell: cell as u32,
                    by,
                    weight: weight * nearer / total,
                });
            }
            nearer += density;
        }
    }

    /// The light that a path ends on, as its group of lights, with the path's weight times the share of strategies that
    /// start from there.
    fn light(&self, path: usize) -> Option<Seen> {
        let weight = self.weights[path].weight;
        let last = self.set.nodes_of(path).last().map(|at| self.set.nodes()[at].light)?;
        let LightEnd::Source { light, .. } = last else { return None };
        let (densities, total) = self.densities(path);
        let weight = weight * densities.iter().sum::<f64>() / total;
        let (row, by) = (self.sources[light as usize].first, self.set.paths()[path].light_path);
        (weight > 0.0 && weight.is_finite()).then_some(Seen { row, cell: 0, by, weight })
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
    fn picks(&self, seen: Vec<Seen>) -> Vec<f32> {
        let mut groups = vec![[0.0; 2]; self.subspaces as usize];
        let powers = powers(self.lights);
        for (power, of) in powers.iter().zip(self.sources) {
            groups[of.first as usize][0] += power;
        }
        let observations: f64 =
            rows(seen, self.subspaces, |seen| groups[seen.row as usize][1] += seen.weight).into_iter().sum();
        let kinds = groups.iter().filter(|[power, _]| *power > 0.0).count();
        let share = share_of(observations, kinds as f64);
        let total: f64 = groups.iter().map(|[_, sum]| sum).sum();
        let pick = |(power, of): (&f64, &SourceLabels)| {
            let [of_group, sum] = groups[of.first as usize];
            let learnt = if total > 0.0 && of_group > 0.0 { sum / total / of_group } else { 1.0 };
            (power * (1.0 - share + share * learnt)) as f32
        };
        powers.iter().zip(self.sources).map(pick).collect()
    }
}

/// Of an eye path, apart from all light paths.
fn eye_path(group: u32) -> u64 {
    1 << 63 | u64::from(group)
}

/// By what was seen, so that no observation is on both sides.
fn judges(by: u64) -> bool {
    (by.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40).is_multiple_of(JUDGES)
}

/// Visits everything that was seen, row by row; returns how many independent observations of equal weight each row is worth
/// (Kish, Survey Sampling, 1965).
fn rows(mut seen: Vec<Seen>, count: u32, mut visit: impl FnMut(&Seen)) -> Vec<f64> {
    // Stable, so that sums have one order.
    seen.par_sort_by_key(|one| (one.row, one.by));
    let mut worth = vec![0.0; count as usize];
    for row in seen.chunk_by(|a, b| a.row == b.row) {
        let (mut sum, mut squares) = (0.0, 0.0);
        for observation in row.chunk_by(|a, b| a.by == b.by) {
            let weight: f64 = observation.iter().map(|one| one.weight).sum();
            sum += weight;
            squares += weight * weight;
        }
        row.iter().for_each(&mut visit);
        if let Some(worth) = worth.get_mut(row[0].row as usize).filter(|_| squares > 0.0) {
            *worth = sum * sum / squares;
        }
    }
    worth
}

/// Of what is drawn from, by how much is known.
fn share_of(observations: f64, cells: f64) -> f64 {
    MOST_SHARE * observations / (observations + OBSERVATIONS_PER_CELL * cells)
}

fn gain(guide: &LightGuide, judging: &[Seen]) -> Option<f64> {
    let (mut sum, mut total) = (0.0, 0.0);
    for seen in judging {
        let cell = guide.cells[seen.row as usize * GUIDE_CELLS + seen.cell as usize];
        sum += seen.weight * (f64::from(cell) * GUIDE_CELLS as f64).ln();
        total += seen.weight;
    }
    (total > 0.0).then_some(sum / total)
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

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::math::sampling::{sample_cosine_hemisphere, sample_disk, sample_uniform_cone};
    use crate::subspace::TrainingPath;

    const NORMAL: Vec3 = Vec3::new(0.48, -0.6, 0.64);

    /// A light, and how a ray sets out from it for a point of the square: where it arrives, and its direction.
    type Sends = fn(Vec2) -> (Vec3, Vec3);

    fn light(kind: SourceKind) -> LightSourceInfo {
        LightSourceInfo { kind, power: 1.0 }
    }

    /// Two edges: the light sets out along `leaves` to a surface at `position`, and goes on to the eye's vertex.
    fn path(set: &mut TrainingSet, light_path: u64, source: LightEnd, position: Vec3, leaves: Vec3) {
        let surface = Feature { position, normal: -leaves, direction: -leaves };
        let seen = Feature { position: Vec3::ZERO, normal: Vec3::Z, direction: Vec3::Z };
        let nodes = [
            TrainingNode { eye: seen, light: LightEnd::Surface(surface), towards: Vec3::Z, mass: 1.0 },
            TrainingNode { eye: surface, light: source, towards: -leaves, mass: 1.0 },
        ];
        let path = TrainingPath { tile: 0, contribution: 1.0, share: 1.0, p0: 0.0, eye_edges: 1, light_path };
        set.push_path(light_path as u32, path, &nodes);
    }

    /// What a set of such paths teaches of a light with label 0; surfaces have label 1.
    fn learn(set: &TrainingSet, lights: &[LightSourceInfo]) -> (LightGuide, Option<f64>) {
        let weights = vec![PathWeight { squared: 1.0, weight: 1.0, held_out: false }; set.paths().len()];
        let labels: Vec<(u32, u32)> = (0..set.nodes().len()).map(|node| (0, 1 - node as u32 % 2)).collect();
        let sources = vec![SourceLabels { first: 0, divisions: 1 }; lights.len()];
        let (gamma, q) = ([0.5; 4], [1.0; 2]);
        let (weights, labels, sources) = (&weights[..], &labels[..], &sources[..]);
        GuideInput { set, weights, labels, gamma: &gamma, q: &q, lights, sources, subspaces: 2 }.learn(1)
    }

    /// The host finds the cell that the device would draw a ray from, for every kind of light.
    #[test]
    fn cells_are_those_that_rays_are_drawn_from() {
        let sends: [(SourceKind, Sends); 4] = [
            (SourceKind::Triangle { position: Vec3::ZERO, normal: NORMAL, area: 1.0 }, |u| {
                let leaves = Frame::from_normal(NORMAL).to_world(sample_cosine_hemisphere(u));
                (leaves, leaves)
            }),
            (SourceKind::Punctual { position: Vec3::ZERO, direction: NORMAL, cone: 0.02 }, |u| {
                let leaves = Frame::from_normal(NORMAL).to_world(sample_uniform_cone(u, 0.02));
                (leaves, leaves)
            }),
            (SourceKind::Punctual { position: Vec3::ZERO, direction: NORMAL, cone: 2.0 }, |u| {
                let leaves = Frame::from_normal(Vec3::Z).to_world(sample_uniform_cone(u, 2.0));
                (leaves, leaves)
            }),
            (SourceKind::Environment, |u| {
                (Frame::from_normal(NORMAL).to_world(sample_disk(u).extend(0.3)), NORMAL)
            }),
        ];
        for (kind, send) in sends {
            for (x, y) in (0..GUIDE_SIDE).flat_map(|x| (0..GUIDE_SIDE).map(move |y| (x, y))) {
                let u = (Vec2::new(x as f32, y as f32) + 0.4) / GUIDE_SIDE as f32;
                let (position, leaves) = send(u);
                let mut set = TrainingSet::new(8, 8);
                let source = LightEnd::Source { light: 0, at: [0.0; 2] };
                (0..200).for_each(|light_path| path(&mut set, light_path, source, position, leaves));
                let (guide, gain) = learn(&set, &[light(kind)]);
                let most = guide.cells[x * GUIDE_SIDE + y];
                let others = (1.0 - most) / (GUIDE_CELLS - 1) as f32;
                assert!(most > 20.0 * others, "{kind:?} at {u}: {most}");
                assert!(gain.is_some_and(|gain| gain > 2.0), "{gain:?}");
                // Nothing was seen of where surfaces send their light.
                assert!(guide.cells[GUIDE_CELLS..].iter().all(|&cell| cell == 1.0 / GUIDE_CELLS as f32));
            }
        }
    }

    /// Many paths by way of one light sub-path are one observation.
    #[test]
    fn one_light_path_teaches_little() {
        let kind = SourceKind::Triangle { position: Vec3::ZERO, normal: NORMAL, area: 1.0 };
        let most = |light_paths: u64| {
            let mut set = TrainingSet::new(8, 8);
            let source = LightEnd::Source { light: 0, at: [0.0; 2] };
            (0..1000).for_each(|one| path(&mut set, 1 + one % light_paths, source, NORMAL, NORMAL));
            learn(&set, &[light(kind)]).0.cells[..GUIDE_CELLS].iter().copied().fold(0.0, f32::max)
        };
        let [one, many] = [1, 1000].map(most);
        assert!(one < 0.03 && many > 0.4, "{one}, {many}");
    }

    /// The device's intervals hold all of [0, 1), each as much as its cell.
    #[test]
    fn bounds_are_of_the_cells() {
        let mut row: Vec<f32> = (0..GUIDE_CELLS).map(|cell| 1.0 + (cell * 7 % 11) as f32).collect();
        let sum: f32 = row.iter().sum();
        row.iter_mut().for_each(|cell| *cell /= sum);
        let bounds = cell_bounds(&row);
        let width = |first: usize, index: usize| {
            bounds[first + index] - if index > 0 { bounds[first + index - 1] } else { 0.0 }
        };
        for (cell, share) in row.iter().enumerate() {
            let (column, inside) = (cell / GUIDE_SIDE, cell % GUIDE_SIDE);
            let product = width(0, column) * width(GUIDE_SIDE * (1 + column), inside);
            assert!((product - share).abs() < 1e-6, "{cell}: {product}, not {share}");
        }
    }
}
