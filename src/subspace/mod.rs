//! What SPCBPT learns before it renders: eye and light sub-paths are classified into subspaces, and Gamma holds
//! the probability with which an eye subspace connects to each light subspace.
//!
//! Su, Li, Wang, SPCBPT: Subspace-based Probabilistic Connections for Bidirectional Path Tracing, ACM TOG 41(4), 2022.
//!
//! ```text
//! training paths -> weights -> centroids -> trees -> labels -> Gamma
//! light vertices ------------------------------------> Q --^
//! ```
//!
//! Whatever is learnt, rendering with it is unbiased as long as it is fixed: this module is about variance only.

pub mod centroid;
mod connections;
mod error;
mod file;
pub mod gamma;
pub mod guide;
mod judge;
pub mod model;
pub mod normaliser;
pub mod prepare;
pub mod settings;
pub mod sources;
mod train;
mod training;
pub mod tree;

pub use connections::{Connections, FirstConnections, MAX_CONNECTIONS};
pub use error::SubspaceError;
pub use guide::LightGuide;
pub use judge::relative_loss;
pub use model::{CentroidMove, GammaTables, Model, TrainingReport};
pub use settings::{LEAST_UNIFORM_SHARE, Optimiser, Settings};
pub use sources::SourceLabels;
pub use train::train;
pub use training::{
    Feature, LightEnd, LightSample, TILE_SIZE, TrainingInput, TrainingNode, TrainingPath, TrainingSet,
};
pub use tree::Tree;
