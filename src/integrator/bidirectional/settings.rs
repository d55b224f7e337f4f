//! Settings of the bidirectional methods.

use serde::Serialize;

use crate::subspace::Connections;

/// Bidirectional path tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Bdpt {
    /// Light paths are connected to the camera as well.
    pub light_tracing: bool,
}

/// Bidirectional path tracing with a light vertex cache.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LvcBpt {
    /// Light paths for each sample of all pixels; `None`: a share of the pixels.
    pub light_paths: Option<u32>,
    pub connections: Connections,
    /// Light paths are connected to the camera as well.
    pub light_tracing: bool,
}

/// Subspace-based probabilistic connections: settings as those of [`LvcBpt`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpcBpt {
    pub light_paths: Option<u32>,
    pub connections: Connections,
    pub light_tracing: bool,
}

/// Probabilistic connections: settings as those of [`LvcBpt`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PcBpt {
    pub light_paths: Option<u32>,
    pub connections: Connections,
    pub light_tracing: bool,
    /// Eye paths that leave records, for each of the picture's: above 0, 1 at most.
    pub record_share: f64,
}

/// The same with weights that know of the resampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RisBpt {
    #[serde(flatten)]
    pub records: PcBpt,
    pub weights: RecordWeights,
}

/// What weights know of connections by records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum RecordWeights {
    /// A light vertex is drawn by one record, and weights know what it brings to each: Nabata, Iwasaki, Dobashi 2020. Three
    /// rays more for each vertex of all paths
    #[default]
    Nabata,
    /// All records count together, and weights know what a light vertex brings to the eye vertex, seen or not: the form
    /// that Su, Li, Wang 2022 compare with
    Simple,
}

/// Light tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LightTracing {
    /// Light paths for each sample of all pixels; `None`: one per pixel.
    pub light_paths: Option<u32>,
}

impl LvcBpt {
    /// Connections where none are asked for.
    pub const CONNECTIONS: Connections = Connections::even(3);
}

impl SpcBpt {
    /// Connections where none are asked for: docs/measurements.md, Connections and shares by depth.
    pub const CONNECTIONS: Connections =
        Connections { counts: [9, 2, 1], shares: [3.0, 2.0, 1.0, 4.0], thinning: true, adapts: true };
}

impl PcBpt {
    /// Connections where none are asked for.
    pub const CONNECTIONS: Connections = Connections::even(3);
    /// Nabata et al. 2020.
    pub const RECORD_SHARE: f64 = 0.004;
    pub const LIGHT_PATHS: u32 = 200;
}

/// What records take in an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordCost {
    pub records: u64,
    /// Light vertices that each has in its table.
    pub vertices: u64,
    /// Of all eye paths, whether they leave records or not.
    pub eye_vertices: u64,
}

impl RecordCost {
    /// Vertices that a path has on average between walls of medium grey, of the eye's that leave records.
    const RECORDS_A_PATH: u64 = 4;
    const VERTICES_A_PATH: u64 = 6;
    /// In each of two buffers.
    pub const ENTRY_BYTES: u64 = 4;

    /// Shadow rays of an iteration, as many as tables have entries.
    pub fn shadow_rays(&self) -> u64 {
        self.records * self.vertices
    }

    /// Rays to records that weights take beside them, if they know what light vertices bring to records: three of each vertex.
    pub fn weight_rays(&self) -> u64 {
        3 * (self.vertices + self.eye_vertices)
    }

    /// Of the larger buffer that tables take.
    pub fn buffer_bytes(&self) -> u64 {
        self.shadow_rays() * Self::ENTRY_BYTES
    }
}

impl PcBpt {
    /// Every so many-th pixel, along both sides of the picture, has an eye path that leaves records.
    pub(super) fn stride(share: f64) -> u32 {
        ((1.0 / share).sqrt().round() as u32).max(1)
    }

    /// What its records take in an iteration, as foretold from the size of a picture alone.
    pub fn record_cost(&self, width: u32, height: u32) -> RecordCost {
        let paths = |length: u32| u64::from(length.div_ceil(Self::stride(self.record_share)));
        RecordCost {
            records: paths(width) * paths(height) * RecordCost::RECORDS_A_PATH,
            vertices: u64::from(self.light_paths.unwrap_or(Self::LIGHT_PATHS)) * RecordCost::VERTICES_A_PATH,
            eye_vertices: u64::from(width) * u64::from(height) * RecordCost::RECORDS_A_PATH,
        }
    }
}

impl Default for PcBpt {
    fn default() -> Self {
        Self {
            light_paths: None,
            connections: Self::CONNECTIONS,
            light_tracing: false,
            record_share: Self::RECORD_SHARE,
        }
    }
}

impl Default for LvcBpt {
    fn default() -> Self {
        Self { light_paths: None, connections: Self::CONNECTIONS, light_tracing: false }
    }
}

impl Default for SpcBpt {
    fn default() -> Self {
        Self { light_paths: None, connections: Self::CONNECTIONS, light_tracing: false }
    }
}
