//! The subspace sampling matrix Gamma: which light subspaces an eye subspace connects to.
//!
//! It minimises L = sum W / D over the training paths, a bound on the variance of the estimator; D, the density of the
//! mixture of all strategies, is affine in Gamma, so L is convex.

mod optimise;
mod problem;
mod smoothing;

pub use optimise::{Loss, Optimised, optimise};
pub use problem::{Problem, ProblemBuilder, Term, Tried};
pub use smoothing::Neighbours;
