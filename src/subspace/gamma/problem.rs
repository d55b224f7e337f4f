//! The loss over Gamma and its gradient.
//!
//! Only pairs of subspaces that some path could connect matter to the loss, so Gamma is kept as a list of such cells.
//! A sweep reads the connections by path for the densities, then by cell for the gradient: no two threads add to the
//! same number, and every sum has one order.

use rayon::prelude::*;

/// Paths, or cells, that one task takes. Fixed: sums are cut in the same places for any number of threads.
const TASK: usize = 8192;

/// What a path says about Gamma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// W: squared contribution.
    pub squared: f64,
    /// Weight of its cells in the matrix that the optimisation starts from.
    pub start: f64,
    /// The part of D that does not depend on Gamma.
    pub p0: f64,
    /// It judges the steps instead of teaching them.
    pub held_out: bool,
}

/// A connection: index of a cell, or of a path, and what the cell's entry is multiplied with in D.
#[derive(Clone, Copy, Debug)]
struct Entry {
    index: u32,
    coefficient: f32,
}

/// Paths that are looked at together.
#[derive(Clone, Debug)]
struct Part {
    squared: Vec<f64>,
    start: Vec<f64>,
    p0: Vec<f64>,
    offsets: Vec<u32>,
    entries: Vec<Entry>,
}

impl Default for Part {
    fn default() -> Self {
        let (squared, start, p0) = (Vec::new(), Vec::new(), Vec::new());
        Self { squared, start, p0, offsets: vec![0], entries: Vec::new() }
    }
}

impl Part {
    fn entries_of(&self, path: usize) -> &[Entry] {
        &self.entries[self.offsets[path] as usize..self.offsets[path + 1] as usize]
    }

    fn density(&self, path: usize, mixed: &[f64]) -> f64 {
        let sum = |sum, e: &Entry| sum + f64::from(e.coefficient) * mixed[e.index as usize];
        self.entries_of(path).iter().fold(self.p0[path], sum)
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

    /// Adds a path with its connections: (row, column, coefficient N mass / Q).
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
                part.entries.push(Entry { index, coefficient });
            }
        }
        part.squared.push(term.squared / scale);
        part.start.push(term.start);
        part.p0.push(term.p0 / scale);
        part.offsets.push(part.entries.len() as u32);
    }

    /// Paths that no strategy of the mixture makes; they were left out.
    pub fn unreachable(&self) -> usize {
        self.unreachable
    }

    /// `uniform_share`: tau, spread over the columns that are `active`. `fallback`: the row of an eye subspace that no
    /// training path connects from; it sums to one.
    pub fn finish(self, uniform_share: f64, active: &[bool], fallback: &[f64]) -> Problem {
        let Self { subspaces, parts: [mut train, mut held_out], .. } = self;
        // Numbers the cells in the order of rows and columns.
        let mut number = vec![0u32; subspaces * subspaces];
        train.entries.iter().chain(&held_out.entries).for_each(|e| number[e.index as usize] = 1);
        let cells: Vec<u32> = (0..number.len() as u32).filter(|&cell| number[cell as usize] > 0).collect();
        for (index, &cell) in cells.iter().enumerate() {
            number[cell as usize] = index as u32;
        }
        for entry in train.entries.iter_mut().chain(&mut held_out.entries) {
            entry.index = number[entry.index as usize];
        }
        let row_starts: Vec<u32> = (0..=subspaces)
            .map(|row| cells.partition_point(|&cell| (cell as usize) < row * subspaces) as u32)
            .collect();
        let mut problem = Problem {
            subspaces,
            uniform_share,
            uniform: uniform_share / active.iter().filter(|a| **a).count().max(1) as f64,
            active: active.to_vec(),
            fallback: fallback.to_vec(),
            by_cell: Vec::new(),
            cell_starts: Vec::new(),
            start: vec![0.0; cells.len()],
            learnt: vec![false; subspaces],
            cells,
            row_starts,
            train,
            held_out,
        };
        problem.transpose();
        problem.set_start();
        problem
    }
}

/// The loss of a set of paths as a function of the cells' probabilities q, before the uniform share is mixed in.
#[derive(Clone, Debug)]
pub struct Problem {
    subspaces: usize,
    uniform_share: f64,
    /// tau / active columns
    uniform: f64,
    active: Vec<bool>,
    fallback: Vec<f64>,
    /// row K + column, ascending.
    cells: Vec<u32>,
    /// Where each row's cells begin, and the end of the last.
    row_starts: Vec<u32>,
    train: Part,
    held_out: Part,
    /// The training part's entries by cell; indices are paths.
    by_cell: Vec<Entry>,
    cell_starts: Vec<u32>,
    /// The row has training paths.
    learnt: Vec<bool>,
    start: Vec<f64>,
}

impl Problem {
    fn transpose(&mut self) {
        let mut starts = vec![0u32; self.cells.len() + 1];
        self.train.entries.iter().for_each(|e| starts[e.index as usize + 1] += 1);
        for cell in 0..self.cells.len() {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        self.by_cell = vec![Entry { index: 0, coefficient: 0.0 }; self.train.entries.len()];
        for path in 0..self.train.squared.len() {
            for entry in self.train.entries_of(path) {
                let place = &mut next[entry.index as usize];
                self.by_cell[*place as usize] = Entry { index: path as u32, coefficient: entry.coefficient };
                *place += 1;
            }
        }
        self.cell_starts = starts;
    }

    /// The contribution matrix, rows normalised: nearly all of the gain is in this start (`prototype.md`, fact 2).
    fn set_start(&mut self) {
        for cell in 0..self.cells.len() {
            self.start[cell] = self.of_cell(cell).iter().map(|e| self.train.start[e.index as usize]).sum();
        }
        for row in 0..self.subspaces {
            let cells = self.row(row);
            let sum: f64 = self.start[cells.clone()].iter().sum();
            self.learnt[row] = sum > 0.0;
            for cell in cells {
                let column = self.cells[cell] as usize % self.subspaces;
                self.start[cell] =
                    if self.learnt[row] { self.start[cell] / sum } else { self.fallback[column] };
            }
        }
    }

    fn of_cell(&self, cell: usize) -> &[Entry] {
        &self.by_cell[self.cell_starts[cell] as usize..self.cell_starts[cell + 1] as usize]
    }

    /// Row and column of every cell.
    pub fn cells(&self) -> impl Iterator<Item = (u32, u32)> {
        let k = self.subspaces as u32;
        self.cells.iter().map(move |cell| (cell / k, cell % k))
    }

    /// The cells of a row.
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.row_starts[row] as usize..self.row_starts[row + 1] as usize
    }

    /// True for rows that training paths connect from; the others keep their fallback.
    pub fn learnt(&self) -> &[bool] {
        &self.learnt
    }

    /// The contribution matrix.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    pub fn train_paths(&self) -> usize {
        self.train.squared.len()
    }

    pub fn held_out_paths(&self) -> usize {
        self.held_out.squared.len()
    }

    /// E = (1 - tau) q + tau / active, of the cells.
    fn mixed(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| (1.0 - self.uniform_share) * q + self.uniform).collect()
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
        let of_cell = |cell: usize| {
            let sum = |sum, e: &Entry| sum + f64::from(e.coefficient) * slopes[e.index as usize];
            -(1.0 - self.uniform_share) * self.of_cell(cell).iter().fold(0.0, sum)
        };
        (loss, (0..self.cells.len()).into_par_iter().with_min_len(TASK / 8).map(of_cell).collect())
    }

    /// Gamma in full, K x K by rows: E with the uniform share in it. Rows that no path taught are the fallback's.
    pub fn expand(&self, q: &[f64]) -> Vec<f32> {
        let mut gamma = vec![0.0f32; self.subspaces * self.subspaces];
        gamma.par_chunks_mut(self.subspaces).enumerate().for_each(|(row, out)| {
            let mut dense = vec![0.0; self.subspaces];
            if self.learnt[row] {
                for cell in self.row(row) {
                    dense[self.cells[cell] as usize % self.subspaces] = q[cell];
                }
            } else {
                dense.copy_from_slice(&self.fallback);
            }
            for ((out, q), active) in out.iter_mut().zip(dense).zip(&self.active) {
                if *active {
                    *out = ((1.0 - self.uniform_share) * q + self.uniform) as f32;
                }
            }
        });
        gamma
    }
}
