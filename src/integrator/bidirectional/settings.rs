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
        Connections { counts: [9, 2, 1], shares: [3.0, 2.0, 1.0, 4.0], thinning: true };
}

impl PcBpt {
    /// Connections where none are asked for.
    pub const CONNECTIONS: Connections = Connections::even(3);
    /// Nabata et al. 2020.
    pub const RECORD_SHARE: f64 = 0.004;
    pub const LIGHT_PATHS: u32 = 200;
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
