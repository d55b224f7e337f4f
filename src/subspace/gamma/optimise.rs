//! Ways down the loss. All start from the contribution matrix, keep rows normalised, do not depend on the unit of the
//! loss, and are judged using paths that they do not see: too many steps learn the paths instead of the scene.

use serde::Serialize;

use super::problem::{Problem, Tried};
use crate::subspace::settings::Optimiser;

/// Steps in a row without progress that end the optimisation.
const PATIENCE: u32 = 2;
/// Relative fall of the judged loss that counts as progress.
const PROGRESS: f64 = 1e-4;
/// Adam: Kingma and Ba, ICLR 2015.
const ADAM_RATE: f64 = 0.05;
const ADAM_MEAN: f64 = 0.9;
const ADAM_SQUARE: f64 = 0.999;
const ADAM_EPSILON: f64 = 1e-12;
/// Halvings of a mirror step that raises the loss.
const HALVINGS: u32 = 12;
/// Of a mirror step, so that no row overflows; backtracking decides whether such a step is taken.
const LARGEST_EXPONENT: f64 = 100.0;

/// The loss after a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Loss {
    pub train: f64,
    pub held_out: Option<f64>,
    /// Share of what was learnt from neighbours in this step.
    pub smoothing: f64,
}

/// The best matrix that was met.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimised {
    /// One per entry of the problem.
    pub q: Vec<f64>,
    /// At the start and after each step.
    pub losses: Vec<Loss>,
    /// Index in `losses` of what was kept.
    pub best_step: u32,
    /// What the smoothing of the kept step was chosen from.
    pub tried: Vec<Tried>,
}

/// Goes down for at most `max_steps`, or until the held-out loss no longer falls; without held-out paths the training
/// loss judges. The start and each step are smoothed: a step leaves nothing to entries that no training path connects.
pub fn optimise(problem: &Problem, optimiser: Optimiser, max_steps: u32) -> Optimised {
    let mut q = problem.start().to_vec();
    let mut state = State::new(optimiser, problem);
    let mut best = Optimised { q: q.clone(), losses: Vec::new(), best_step: 0, tried: Vec::new() };
    let (mut lowest, mut idle) = (f64::INFINITY, 0);
    for step in 0..=max_steps {
        let (smoothing, tried) = problem.smooth(&mut q);
        let (train, gradient) = problem.gradient(&q);
        let loss = Loss { train, held_out: problem.held_out_loss(&q), smoothing };
        best.losses.push(loss);
        let judged = loss.held_out.unwrap_or(loss.train);
        idle = if judged < lowest * (1.0 - PROGRESS) || step == 0 { 0 } else { idle + 1 };
        if judged < lowest {
            lowest = judged;
            best.q.clone_from(&q);
            best.best_step = step;
            best.tried = tried;
        }
        let finished = step == max_steps || (idle >= PATIENCE && loss.held_out.is_some());
        if finished || !state.step(problem, &mut q, train, &gradient) {
            break;
        }
    }
    best
}

/// What an optimiser carries from step to step.
enum State {
    Mm,
    Softmax(Adam),
    Mirror { rate: f64 },
}

#[derive(Default)]
struct Adam {
    step: i32,
    mean: Vec<f64>,
    square: Vec<f64>,
    /// One per row, from the start: what the derivatives are divided by, so that Adam's epsilon does not stop rows that
    /// contribute little.
    row_scale: Vec<f64>,
}

impl State {
    fn new(optimiser: Optimiser, problem: &Problem) -> Self {
        match optimiser {
            Optimiser::Mm => Self::Mm,
            Optimiser::Mirror => Self::Mirror { rate: 1.0 },
            Optimiser::Softmax => {
                let zeros = vec![0.0; problem.start().len()];
                Self::Softmax(Adam { mean: zeros.clone(), square: zeros, ..Adam::default() })
            }
        }
    }

    /// Moves `q`; false where there is no way down.
    fn step(&mut self, problem: &Problem, q: &mut [f64], loss: f64, gradient: &[f64]) -> bool {
        match self {
            // q^2 (-g) / q' majorises an entry's share of the loss and touches it at q' = q; its minimum under the rows'
            // sums is q' ~ q sqrt(-g).
            Self::Mm => by_row(problem, q, |_, q, g| q * (-g).max(0.0).sqrt(), gradient),
            Self::Softmax(adam) => adam.step(problem, q, gradient),
            Self::Mirror { rate } => {
                let before = q.to_vec();
                for _ in 0..HALVINGS {
                    let eta = *rate;
                    by_row(
                        problem,
                        q,
                        |mean, q, g| q * (eta * (g / mean - 1.0)).min(LARGEST_EXPONENT).exp(),
                        gradient,
                    );
                    if problem.loss(q) <= loss {
                        *rate = (2.0 * eta).min(1.0);
                        return true;
                    }
                    q.copy_from_slice(&before);
                    *rate = 0.5 * eta;
                }
                return false;
            }
        }
        true
    }
}

/// Replaces each q of the rows that have something to learn by `new(mean of the row's g, q, g)`, and normalises.
fn by_row(problem: &Problem, q: &mut [f64], new: impl Fn(f64, f64, f64) -> f64, gradient: &[f64]) {
    for (row, learnt) in problem.learnt().iter().enumerate() {
        let entries = problem.row(row);
        let mean = mean_gradient(q, gradient, entries.clone());
        if !learnt || mean >= 0.0 {
            continue;
        }
        let values: Vec<f64> = entries.clone().map(|entry| new(mean, q[entry], gradient[entry])).collect();
        let sum: f64 = values.iter().sum();
        // A row whose numbers left the range of f64 stays as it was.
        if sum > 0.0 && sum.is_finite() {
            for (entry, value) in entries.zip(values) {
                q[entry] = value / sum;
            }
        }
    }
}

/// sum q g of a row.
fn mean_gradient(q: &[f64], gradient: &[f64], entries: std::ops::Range<usize>) -> f64 {
    entries.map(|entry| q[entry] * gradient[entry]).sum()
}

impl Adam {
    fn step(&mut self, problem: &Problem, q: &mut [f64], gradient: &[f64]) {
        self.step += 1;
        let rows = problem.learnt().len();
        if self.row_scale.is_empty() {
            self.row_scale = (0..rows).map(|row| -mean_gradient(q, gradient, problem.row(row))).collect();
        }
        let correct = |decay: f64| 1.0 - decay.powi(self.step);
        let (correct_mean, correct_square) = (correct(ADAM_MEAN), correct(ADAM_SQUARE));
        for row in 0..rows {
            let entries = problem.row(row);
            let scale = self.row_scale[row];
            if !problem.learnt()[row] || scale <= 0.0 {
                continue;
            }
            let mean = mean_gradient(q, gradient, entries.clone());
            for entry in entries.clone() {
                // dL/dz = q (g - sum q g), by the chain rule through the softmax.
                let slope = q[entry] * (gradient[entry] - mean) / scale;
                let (m, s) = (&mut self.mean[entry], &mut self.square[entry]);
                *m = ADAM_MEAN * *m + (1.0 - ADAM_MEAN) * slope;
                *s = ADAM_SQUARE * *s + (1.0 - ADAM_SQUARE) * slope * slope;
                let step = *m / correct_mean / ((*s / correct_square).sqrt() + ADAM_EPSILON);
                // A logit moves by -rate step.
                q[entry] *= (-ADAM_RATE * step).exp();
            }
            let sum: f64 = q[entries.clone()].iter().sum();
            q[entries].iter_mut().for_each(|q| *q /= sum);
        }
    }
}
