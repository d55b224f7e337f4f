//! The loss over Gamma and its gradient.
//!
//! A pass reads the connections path by path for the densities, then entry by entry of Gamma for the gradient: no two
//! threads add to the same number, and every sum has one order.

use rayon::prelude::*;
use serde::Serialize;

use super::smoothing::{Neighbours, Smoothing};

/// Paths, or entries, per task. Fixed: sums are cut in the same places for any number of threads.
const TASK: usize = 8192;

/// A path's part in the loss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// W: squared contribution.
    pub squared: f64,
    /// Weight of its entries in the matrix that the optimisation starts from.
    pub start: f64,
    /// The part of D that does not depend on Gamma.
    pub p0: f64,
    /// It judges the steps instead of teaching them.
    pub held_out: bool,
}

/// A share of smoothing and the loss with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tried {
    pub smoothing: f64,
    pub held_out: f64,
}

/// Index of an entry of Gamma (row K + column), or of a path, and the factor of the entry in D.
#[derive(Clone, Copy, Debug)]
struct Connection {
    index: u32,
    coefficient: f32,
}

/// Paths that are summed together: those that teach, or those held out.
#[derive(Clone, Debug)]
struct Part {
    squared: Vec<f64>,
    start: Vec<f64>,
    p0: Vec<f64>,
    offsets: Vec<u32>,
    connections: Vec<Connection>,
}

impl Default for Part {
    fn default() -> Self {
        let (squared, start, p0) = (Vec::new(), Vec::new(), Vec::new());
        Self { squared, start, p0, offsets: vec![0], connections: Vec::new() }
    }
}

impl Part {
    fn connections_of(&self, path: usize) -> &[Connection] {
        &self.connections[self.offsets[path] as usize..self.offsets[path + 1] as usize]
    }

    fn density(&self, path: usize, mixed: &[f64]) -> f64 {
        let sum = |sum, e: &Connection| sum + f64::from(e.coefficient) * mixed[e.index as usize];
        self.connections_of(path).iter().fold(self.p0[path], sum)
    }

    fn loss(&self, mixed: &[f64]) -> f64 {
        let chunk = |paths: Vec<usize>| {
            paths.into_iter().map(|path| self.squared[path] / self.density(path, mixed)).sum::<f64>()
        };
        let sums: Vec<f64> = (0..self.squared.len()).into_par_iter().chunks(TASK).map(chunk).collect();
        sums.iter().sum()
    }
}

/// Collects paths.
#[derive(Clone, Debug)]
pub struct ProblemBuilder {
    subspaces: usize,
    parts: [Part; 2],
    unreachable: usize,
}

impl ProblemBuilder {
    /// For a matrix of `subspaces` x `subspaces`.
    pub fn new(subspaces: u32) -> Self {
        Self { subspaces: subspaces as usize, parts: Default::default(), unreachable: 0 }
    }

    /// Adds a path with its connections: (row, column, coefficient mass / Q).
    pub fn push(&mut self, term: Term, connections: impl Iterator<Item = (u32, u32, f64)> + Clone) {
        // D in units of its greatest possible value: all that follows is near one.
        let scale = connections.clone().fold(term.p0, |sum, (_, _, coefficient)| sum + coefficient);
        if !(scale > 0.0 && scale.is_finite()) {
            self.unreachable += 1;
            return;
        }
        let part = &mut self.parts[usize::from(term.held_out)];
        for (row, column, coefficient) in connections {
            let coefficient = (coefficient / scale) as f32;
            if coefficient > 0.0 {
                let index = (row as usize * self.subspaces + column as usize) as u32;
                part.connections.push(Connection { index, coefficient });
            }
        }
        part.squared.push(term.squared / scale);
        part.start.push(term.start);
        part.p0.push(term.p0 / scale);
        part.offsets.push(part.connections.len() as u32);
    }

    /// Paths that no strategy of the mixture makes; they were left out.
    pub fn unreachable(&self) -> usize {
        self.unreachable
    }

    /// `uniform_share`: of every row, spread evenly over the columns that are `active`; `power_share`: of the rest, spread as
    /// `power` is, which sums to one and is the row of an eye subspace that no training path connects from.
    pub fn finish(self, uniform_share: f64, power_share: f64, active: &[bool], power: &[f64]) -> Problem {
        let Self { subspaces, parts: [train, held_out], .. } = self;
        let uniform = uniform_share / active.iter().filter(|a| **a).count().max(1) as f64;
        let by_power = (1.0 - uniform_share) * power_share;
        let kept = |(power, active): (&f64, &bool)| if *active { uniform + by_power * power } else { 0.0 };
        let mut problem = Problem {
            subspaces,
            learnt_share: 1.0 - uniform_share - by_power,
            kept: power.iter().zip(active).map(kept).collect(),
            by_entry: Vec::new(),
            entry_starts: Vec::new(),
            start: vec![0.0; subspaces * subspaces],
            learnt: vec![false; subspaces],
            train,
            held_out,
            smoothing: None,
        };
        problem.transpose();
        problem.set_start(power);
        problem
    }
}

/// The loss of a set of paths as a function of q, a distribution over the columns for each row, before what does not
/// depend on learning is mixed in. Columns that are not active have nothing of either.
#[derive(Clone, Debug)]
pub struct Problem {
    subspaces: usize,
    learnt_share: f64,
    /// Of each column, what every row has of it, whatever is learnt.
    kept: Vec<f64>,
    train: Part,
    held_out: Part,
    /// The training part's connections in the order of entries; indices are paths.
    by_entry: Vec<Connection>,
    entry_starts: Vec<u32>,
    /// The row has training paths.
    learnt: Vec<bool>,
    start: Vec<f64>,
    smoothing: Option<Smoothing>,
}

impl Problem {
    fn transpose(&mut self) {
        let mut starts = vec![0u32; self.start.len() + 1];
        self.train.connections.iter().for_each(|e| starts[e.index as usize + 1] += 1);
        for entry in 0..self.start.len() {
            starts[entry + 1] += starts[entry];
        }
        let mut next = starts.clone();
        self.by_entry = vec![Connection { index: 0, coefficient: 0.0 }; self.train.connections.len()];
        for path in 0..self.train.squared.len() {
            for connection in self.train.connections_of(path) {
                let place = &mut next[connection.index as usize];
                self.by_entry[*place as usize] =
                    Connection { index: path as u32, coefficient: connection.coefficient };
                *place += 1;
            }
        }
        self.entry_starts = starts;
    }

    /// The contribution matrix, rows normalised: nearly all of the gain is in this start; the steps add little.
    fn set_start(&mut self, power: &[f64]) {
        for entry in 0..self.start.len() {
            self.start[entry] = self.of_entry(entry).iter().map(|e| self.train.start[e.index as usize]).sum();
        }
        for row in 0..self.subspaces {
            let entries = self.row(row);
            let row_start = &mut self.start[entries];
            let sum: f64 = row_start.iter().sum();
            self.learnt[row] = sum > 0.0;
            if self.learnt[row] {
                row_start.iter_mut().for_each(|q| *q /= sum);
            } else {
                row_start.copy_from_slice(power);
            }
        }
    }

    /// Lets rows and columns that are alike learn from each other. `power`: of each column, in any unit. `share`: of what
    /// is learnt from neighbours; `None`: what suits the held-out paths.
    pub fn smooth_over(&mut self, neighbours: &Neighbours, power: &[f64], share: Option<f64>) {
        self.smoothing = Some(Smoothing::new(neighbours, power, &self.learnt, share));
    }

    /// Smooths q by the share, of those there are, with the lowest held-out loss. Returns it, and what was tried: nothing
    /// where no path was held out, and q stays as it is unless there is but one share.
    pub(super) fn smooth(&self, q: &mut Vec<f64>) -> (f64, Vec<Tried>) {
        let Some(smoothing) = &self.smoothing else { return (0.0, Vec::new()) };
        let smoothed = smoothing.apply(q);
        let mix = |share: f64| -> Vec<f64> {
            q.iter().zip(&smoothed).map(|(q, smooth)| (1.0 - share) * q + share * smooth).collect()
        };
        let judge =
            |&smoothing: &f64| Some(Tried { smoothing, held_out: self.held_out_loss(&mix(smoothing))? });
        let tried: Vec<Tried> = smoothing.shares.iter().filter_map(judge).collect();
        let best = tried.iter().min_by(|a, b| a.held_out.total_cmp(&b.held_out)).map(|best| best.smoothing);
        let share = best.unwrap_or(smoothing.shares[0]);
        *q = mix(share);
        (share, tried)
    }

    fn of_entry(&self, entry: usize) -> &[Connection] {
        &self.by_entry[self.entry_starts[entry] as usize..self.entry_starts[entry + 1] as usize]
    }

    /// The entries of a row.
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        row * self.subspaces..(row + 1) * self.subspaces
    }

    /// True for rows that training paths connect from; the others keep to power.
    pub fn learnt(&self) -> &[bool] {
        &self.learnt
    }

    /// The contribution matrix, K x K by rows.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    pub fn train_paths(&self) -> usize {
        self.train.squared.len()
    }

    pub fn held_out_paths(&self) -> usize {
        self.held_out.squared.len()
    }

    /// A row's share of each column: of q, and of what is kept.
    fn mixed(&self, q: &[f64]) -> Vec<f64> {
        q.iter().zip(self.kept.iter().cycle()).map(|(q, kept)| self.learnt_share * q + kept).collect()
    }

    /// Loss of the training paths.
    pub fn loss(&self, q: &[f64]) -> f64 {
        self.train.loss(&self.mixed(q))
    }

    /// Loss of the held-out paths; `None` where nothing was held out.
    pub fn held_out_loss(&self, q: &[f64]) -> Option<f64> {
        let judged = self.held_out.squared.iter().any(|squared| *squared > 0.0);
        judged.then(|| self.held_out.loss(&self.mixed(q)))
    }

    /// Loss of the training paths and its derivative by each q; never positive.
    pub fn gradient(&self, q: &[f64]) -> (f64, Vec<f64>) {
        let mixed = self.mixed(q);
        let chunk = |paths: Vec<usize>| {
            let mut loss = 0.0;
            let slopes: Vec<f64> = paths
                .into_iter()
                .map(|path| {
                    let (squared, density) = (self.train.squared[path], self.train.density(path, &mixed));
                    loss += squared / density;
                    squared / density / density
                })
                .collect();
            (loss, slopes)
        };
        let chunks: Vec<(f64, Vec<f64>)> =
            (0..self.train.squared.len()).into_par_iter().chunks(TASK).map(chunk).collect();
        let loss = chunks.iter().map(|(loss, _)| loss).sum();
        let slopes: Vec<f64> = chunks.into_iter().flat_map(|(_, slopes)| slopes).collect();
        let of_entry = |entry: usize| {
            let sum = |sum, e: &Connection| sum + f64::from(e.coefficient) * slopes[e.index as usize];
            -self.learnt_share * self.of_entry(entry).iter().fold(0.0, sum)
        };
        (loss, (0..self.start.len()).into_par_iter().with_min_len(TASK / 8).map(of_entry).collect())
    }

    /// Gamma, K x K by rows, with the shares that do not depend on learning.
    pub fn expand(&self, q: &[f64]) -> Vec<f32> {
        self.mixed(q).into_iter().map(|share| share as f32).collect()
    }
}
