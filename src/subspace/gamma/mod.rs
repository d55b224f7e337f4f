//! The subspace sampling matrix Gamma: which light subspaces an eye subspace connects to.
//!
//! It minimises L = sum W / D over the training paths, a bound on the variance of the estimator; D, the density of the
//! mixture of all strategies, is affine in Gamma, so L is convex. W is |f|^2 / p of a path, D its p0 plus, over its
//! connections, N * mass * Gamma with the uniform share mixed in. Su, Li and Wang 2022 and their public code
//! (SPCBPT-OptiX7); the number of connections N is not in theirs.

mod optimise;
mod problem;
mod smoothing;

pub use optimise::{Loss, Optimised, optimise};
pub use problem::{Problem, ProblemBuilder, Term, Tried};
pub use smoothing::Neighbours;
