//! Settings of the bidirectional methods.

use serde::Serialize;

/// Connections that an eye vertex may have at once.
pub const MAX_CONNECTIONS: u32 = 64;
/// Connections of an eye vertex where no number is asked for.
pub const DEFAULT_CONNECTIONS: u32 = 3;

/// Bidirectional path tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Bdpt {
    /// Light paths are connected to the camera as well.
    pub light_tracing: bool,
}

/// Bidirectional path tracing with a light vertex cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LvcBpt {
    /// Light paths for each sample of all pixels; `None`: a share of the pixels.
    pub light_paths: Option<u32>,
    /// Connections of each eye vertex, 1 to [`MAX_CONNECTIONS`].
    pub connections: u32,
    /// Light paths are connected to the camera as well.
    pub light_tracing: bool,
}

/// Subspace-based probabilistic connections: settings as those of [`LvcBpt`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct SpcBpt {
    pub light_paths: Option<u32>,
    pub connections: u32,
    pub light_tracing: bool,
}

/// Light tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LightTracing {
    /// Light paths for each sample of all pixels; `None`: one per pixel.
    pub light_paths: Option<u32>,
}

impl Default for LvcBpt {
    fn default() -> Self {
        Self { light_paths: None, connections: DEFAULT_CONNECTIONS, light_tracing: false }
    }
}

impl Default for SpcBpt {
    fn default() -> Self {
        Self { light_paths: None, connections: DEFAULT_CONNECTIONS, light_tracing: false }
    }
}
