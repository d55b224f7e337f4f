//! The methods of light transport: what each is told, and what is told of each.
//!
//! What a method computes is its [`Plan`](super::Plan), which [`Method::plan`](super::plan) makes; nothing else asks
//! which method it is.

use serde::Serialize;

use super::bidirectional::settings::{self, Bdpt, LightTracing, LvcBpt, SpcBpt};
use super::path;

/// How light is transported, with the settings of each way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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
    Connections,
    LightTracing,
    /// All that says what is learnt, and from what.
    Learning,
}

/// Settings as users give them; `None`: the method's default.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    pub light_paths: Option<u32>,
    pub connections: Option<u32>,
    pub light_tracing: bool,
}

/// Every method, in the order in which users see them.
pub static METHODS: [&Descriptor; 5] =
    [&path::DESCRIPTOR, &settings::BDPT, &settings::LVCBPT, &settings::SPCBPT, &settings::LIGHT];

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

impl Method {
    pub fn descriptor(&self) -> &'static Descriptor {
        self.plan().descriptor
    }

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        self.descriptor().name
    }
}
