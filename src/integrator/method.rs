//! The methods of light transport: what each is told, and what is told of each.
//!
//! What a method computes is its [`Plan`](super::Plan), which [`Method::plan`](super::plan) makes; nothing else asks
//! which method it is.

use serde::Serialize;

use super::Connections;
use super::bidirectional::settings::{Bdpt, LightTracing, LvcBpt, PcBpt, RecordWeights, RisBpt, SpcBpt};

/// How light is transported, with the settings of each way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(tag = "integrator", rename_all = "lowercase")]
pub enum Method {
    /// Path tracing with next-event estimation.
    #[default]
    Path,
    /// Bidirectional path tracing: a light path for each eye path, all their vertices connected.
    Bdpt(Bdpt),
    /// Bidirectional path tracing with a light vertex cache (Davidovic et al. 2014).
    LvcBpt(LvcBpt),
    /// Subspace-based probabilistic connections for bidirectional path tracing (Su, Li, Wang 2022).
    SpcBpt(SpcBpt),
    /// Light tracing: light paths alone, connected to the camera.
    Light(LightTracing),
    /// Probabilistic connections for bidirectional path tracing (Popov et al. 2015).
    PcBpt(PcBpt),
    /// Connections as those of [`Self::PcBpt`], with weights that know of the resampling (Nabata et al. 2020).
    RisBpt(RisBpt),
}

/// What users are told of a method, and how their settings make it.
#[derive(Debug)]
pub struct Descriptor {
    /// On the command line.
    pub name: &'static str,
    /// One sentence, for `--help`.
    pub help: &'static str,
    /// In the preview window.
    pub key: char,
    /// A row of README's table: how it works, and what it is for.
    pub how: &'static str,
    pub suits: &'static str,
    /// Settings that it has; others are refused.
    pub takes: &'static [Setting],
    pub make: fn(&Given) -> Method,
}

/// A setting that some methods have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    LightPaths,
    /// How many, and how far weights trust them.
    Connections,
    LightTracing,
    /// How many eye paths leave records.
    Records,
    /// What weights know of connections by records.
    RecordWeights,
    /// All that says what is learnt, and from what.
    Learning,
}

/// Settings as users give them; `None`: the method's default.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    pub light_paths: Option<u32>,
    /// N of the first eye vertices; the last that is given holds for all that follow.
    pub connections: Option<[u32; 3]>,
    /// [`Connections::shares`]
    pub shares: Option<[f32; 4]>,
    /// [`Connections::thinning`] is off.
    pub no_thinning: bool,
    pub light_tracing: bool,
    /// [`PcBpt::record_share`]
    pub record_share: Option<f64>,
    /// [`RisBpt::weights`]
    pub record_weights: Option<RecordWeights>,
}

impl Given {
    fn connections_or(&self, default: Connections) -> Connections {
        Connections {
            counts: self.connections.unwrap_or(default.counts),
            shares: self.shares.unwrap_or(default.shares),
            thinning: default.thinning && !self.no_thinning,
            adapts: default.adapts && self.connections.is_none(),
        }
    }
}

/// Every method, in the order in which users see them.
pub static METHODS: [&Descriptor; 7] = [&PATH, &BDPT, &LVCBPT, &SPCBPT, &LIGHT, &PCBPT, &RISBPT];

pub static PATH: Descriptor = Descriptor {
    name: "path",
    help: "Path tracing with next-event estimation",
    key: '1',
    how: "eye paths, connected to points on lights",
    suits: "most scenes: light that comes straight from lamps and the sky. The cheapest sample",
    takes: &[],
    make: |_| Method::Path,
};

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
    make: |given| {
        let Given { light_paths, light_tracing, .. } = *given;
        let connections = given.connections_or(LvcBpt::CONNECTIONS);
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
    make: |given| {
        let Given { light_paths, light_tracing, .. } = *given;
        let connections = given.connections_or(SpcBpt::CONNECTIONS);
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

pub static PCBPT: Descriptor = Descriptor {
    name: "pcbpt",
    help: "Bidirectional path tracing that connects by records of which light vertices reach some eye vertices (PCBPT)",
    key: '6',
    how: "as `lvcbpt` with few light paths, of which a few eye vertices of each sample tell the others which reach them",
    suits: "comparison with `spcbpt`, which needs no such records",
    takes: &[Setting::LightPaths, Setting::Connections, Setting::LightTracing, Setting::Records],
    make: |given| Method::PcBpt(by_records(given)),
};

pub static RISBPT: Descriptor = Descriptor {
    name: "risbpt",
    help: "As pcbpt, with weights that know how well records choose (RISBPT)",
    key: '7',
    how: "as `pcbpt`, with weights that know how well records choose",
    suits: "comparison with `spcbpt`: the best of its rivals in its paper",
    takes: &[
        Setting::LightPaths,
        Setting::Connections,
        Setting::LightTracing,
        Setting::Records,
        Setting::RecordWeights,
    ],
    make: |given| {
        let weights = given.record_weights.unwrap_or_default();
        Method::RisBpt(RisBpt { records: by_records(given), weights })
    },
};

fn by_records(given: &Given) -> PcBpt {
    PcBpt {
        light_paths: given.light_paths,
        connections: given.connections_or(PcBpt::CONNECTIONS),
        light_tracing: given.light_tracing,
        record_share: given.record_share.unwrap_or(PcBpt::RECORD_SHARE),
    }
}

impl Descriptor {
    /// The method of that name.
    pub fn find(name: &str) -> Option<&'static Self> {
        METHODS.into_iter().find(|method| method.name == name)
    }

    /// Has this setting.
    pub fn takes(&self, setting: Setting) -> bool {
        self.takes.contains(&setting)
    }

    /// With its default settings.
    pub fn default_method(&self) -> Method {
        (self.make)(&Given::default())
    }
}
