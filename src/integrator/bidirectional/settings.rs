//! The bidirectional methods: settings, and what users are told.

use serde::Serialize;

use crate::integrator::method::{Descriptor, Given, Method, Setting};

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

pub static BDPT: Descriptor = Descriptor {
    name: "bdpt",
    help: "Bidirectional path tracing: every eye path is connected to a light path of its own",
    key: '2',
    how: "each eye path connected to every vertex of a light path of its own",
    suits: "the same as `lvcbpt`, at a higher price per sample; for comparison, as its pixels do not share light paths",
    takes: &[Setting::LightTracing],
    make: |given| Method::Bdpt(Bdpt { light_tracing: given.light_tracing }),
};

pub static LVCBPT: Descriptor = Descriptor {
    name: "lvcbpt",
    help: "Bidirectional path tracing with a light vertex cache that the whole picture shares",
    key: '3',
    how: "eye paths, connected to vertices of light paths that the whole picture shares",
    suits: "light that arrives by way of other surfaces: lamps behind shades, a door ajar",
    takes: &[Setting::LightPaths, Setting::Connections, Setting::LightTracing],
    make: |&Given { light_paths, connections, light_tracing }| {
        let connections = connections.unwrap_or(DEFAULT_CONNECTIONS);
        Method::LvcBpt(LvcBpt { light_paths, connections, light_tracing })
    },
};

pub static SPCBPT: Descriptor = Descriptor {
    name: "spcbpt",
    help: "Bidirectional path tracing that has learnt which light vertices are worth a connection (SPCBPT)",
    key: '4',
    how: "as `lvcbpt`, but it first learns which light vertices are worth a connection: seconds, once for many renders",
    suits: "light that is hard to find, such as rooms lit through a door ajar",
    takes: &[Setting::LightPaths, Setting::Connections, Setting::LightTracing, Setting::Learning],
    make: |&Given { light_paths, connections, light_tracing }| {
        let connections = connections.unwrap_or(DEFAULT_CONNECTIONS);
        Method::SpcBpt(SpcBpt { light_paths, connections, light_tracing })
    },
};

pub static LIGHT: Descriptor = Descriptor {
    name: "light",
    help: "Light tracing: light paths alone, connected to the camera",
    key: '5',
    how: "light paths, connected to the camera",
    suits: "caustics on matte surfaces. Does not show what is seen through, or mirrored in, perfectly smooth glass and metal",
    takes: &[Setting::LightPaths],
    make: |given| Method::Light(LightTracing { light_paths: given.light_paths }),
};
