//! What SPCBPT learns before it renders: eye and light sub-paths are classified into subspaces, and Gamma says which
//! light subspaces an eye subspace connects to.
//!
//! Su, Li, Wang, SPCBPT: Subspace-based Probabilistic Connections for Bidirectional Path Tracing, ACM TOG 41(4), 2022.

pub mod gamma;
pub mod settings;

pub use settings::{Optimiser, Settings};
