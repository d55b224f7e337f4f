//! What a method comes down to. This is the only place that asks which method it is: all other code reads the plan.

use crate::device::Feature;
use crate::subspace::Connections;

use super::method::{BDPT, Descriptor, LIGHT, LVCBPT, Method, PATH, PCBPT, RISBPT, SPCBPT};
use super::{Bdpt, LvcBpt, PcBpt, RecordWeights, RisBpt, SpcBpt};

/// Where the light paths of an iteration come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightPaths {
    /// There are none.
    None,
    /// One for each eye path.
    OnePerEyePath,
    /// So many for each sample of the whole picture, shared by all its pixels; `wanted` by the user, or `per_pixel` of
    /// the whole picture.
    Shared { wanted: Option<u32>, per_pixel: f64 },
}

/// Which vertices of the light vertex cache an eye vertex is connected to: `shaders/lib/select_*.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Selector {
    /// All of the light path that belongs to the eye path.
    OwnPath,
    /// Any, all alike.
    Uniform,
    /// A light subspace by Gamma, then a vertex of it by its power.
    Subspaces,
    /// By the tables of the nearest records, or any: in each sample `share` of the pixels has an eye path that leaves
    /// records.
    Records { share: f64 },
}

impl Selector {
    /// What the kernel of connections is compiled with.
    pub fn features(self) -> &'static [Feature] {
        match self {
            Self::OwnPath => &[Feature::OwnLightPath],
            Self::Records { .. } => &[Feature::Records],
            Self::Uniform | Self::Subspaces => &[],
        }
    }
}

/// What goes into the weights of multiple importance sampling: `shaders/lib/weights_*.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// Densities that do not depend on what a light path carries: one ratio per vertex.
    Ratio,
    /// Gamma and Q: the density of a connection depends on the light path's weight.
    Subspaces,
    /// The density of a connection is that of a draw from few light paths in proportion to the light that they bring: Su, Li,
    /// Wang's form.
    Resampling,
    /// The same, for the draw by each record alone, of the light that is brought to it: Nabata, Iwasaki, Dobashi's form.
    AtRecords,
}

/// See the module.
#[derive(Clone, Copy)]
pub struct Plan {
    pub descriptor: &'static Descriptor,
    pub light_paths: LightPaths,
    /// Connections that eye vertices have. (Of vertices connected to the whole of their own light path, how many are in
    /// flight at once.)
    pub connections: Connections,
    /// `None`: eye vertices are not connected to light vertices.
    pub selector: Option<Selector>,
    pub weights: Weights,
    /// Light paths are connected to the camera.
    pub to_camera: bool,
}

/// How far weights trust connections of light paths to the camera, beside what the balance heuristic does, where samples
/// share these light paths: docs/measurements.md, Light tracing.
const CAMERA_SHARE: f32 = 0.25;
/// Light paths for each sample of each pixel of the picture, where none are asked for.
const LIGHT_PATHS_PER_PIXEL: f64 = 0.25;
/// Connections in flight where an eye vertex is connected to all vertices of its light path; longer paths take several
/// rounds.
const OWN_PATH_CONNECTIONS: u32 = 4;

impl Method {
    pub fn descriptor(&self) -> &'static Descriptor {
        self.plan().descriptor
    }

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        self.descriptor().name
    }

    /// The same with light paths connected to the camera as well; `None` where it has that already, or cannot, or is one of
    /// few light paths, as of old.
    pub fn with_light_tracing(self) -> Option<Self> {
        match self {
            Self::Bdpt(method) => (!method.light_tracing).then_some(Self::Bdpt(Bdpt { light_tracing: true })),
            Self::LvcBpt(method) => {
                (!method.light_tracing).then_some(Self::LvcBpt(LvcBpt { light_tracing: true, ..method }))
            }
            Self::SpcBpt(method) => {
                (!method.light_tracing).then_some(Self::SpcBpt(SpcBpt { light_tracing: true, ..method }))
            }
            Self::Path | Self::Light(_) | Self::PcBpt(_) | Self::RisBpt(_) => None,
        }
    }

    /// What it comes down to.
    pub fn plan(&self) -> Plan {
        match *self {
            Self::Path => Plan {
                descriptor: &PATH,
                light_paths: LightPaths::None,
                connections: Connections::even(1),
                selector: None,
                weights: Weights::Ratio,
                to_camera: false,
            },
            Self::Bdpt(method) => Plan {
                descriptor: &BDPT,
                light_paths: LightPaths::OnePerEyePath,
                connections: Connections::even(OWN_PATH_CONNECTIONS),
                selector: Some(Selector::OwnPath),
                weights: Weights::Ratio,
                to_camera: method.light_tracing,
            },
            Self::LvcBpt(method) => Plan {
                descriptor: &LVCBPT,
                light_paths: shared(method.light_paths),
                connections: method.connections,
                selector: Some(Selector::Uniform),
                weights: Weights::Ratio,
                to_camera: method.light_tracing,
            },
            Self::SpcBpt(method) => Plan {
                descriptor: &SPCBPT,
                light_paths: shared(method.light_paths),
                connections: method.connections,
                selector: Some(Selector::Subspaces),
                weights: Weights::Subspaces,
                to_camera: method.light_tracing,
            },
            Self::Light(method) => Plan {
                descriptor: &LIGHT,
                light_paths: LightPaths::Shared { wanted: method.light_paths, per_pixel: 1.0 },
                connections: Connections::even(1),
                selector: None,
                weights: Weights::Ratio,
                to_camera: true,
            },
            Self::PcBpt(method) => by_records(&PCBPT, method, Weights::Ratio),
            Self::RisBpt(RisBpt { records, weights }) => {
                let weights = match weights {
                    RecordWeights::Nabata => Weights::AtRecords,
                    RecordWeights::Simple => Weights::Resampling,
                };
                by_records(&RISBPT, records, weights)
            }
        }
    }
}

fn by_records(descriptor: &'static Descriptor, method: PcBpt, weights: Weights) -> Plan {
    Plan {
        descriptor,
        light_paths: shared(Some(method.light_paths.unwrap_or(PcBpt::LIGHT_PATHS))),
        connections: method.connections,
        selector: Some(Selector::Records { share: method.record_share }),
        weights,
        to_camera: method.light_tracing,
    }
}

fn shared(wanted: Option<u32>) -> LightPaths {
    LightPaths::Shared { wanted, per_pixel: LIGHT_PATHS_PER_PIXEL }
}

impl LightPaths {
    /// Light paths for each sample of a picture of so many pixels, of which `rendered` are rendered.
    pub fn count(self, pixels: u32, rendered: u32) -> u32 {
        match self {
            Self::None | Self::OnePerEyePath => rendered,
            Self::Shared { wanted, per_pixel } => {
                wanted.unwrap_or((f64::from(pixels) * per_pixel).ceil() as u32)
            }
        }
    }

    pub fn are_shared(self) -> bool {
        matches!(self, Self::Shared { .. })
    }
}

impl Plan {
    /// Connects by what was learnt before.
    pub fn learns(&self) -> bool {
        self.weights == Weights::Subspaces
    }

    /// Vertices of narrow lobes make a part of their connections only. Where each is connected to all of a light path, all
    /// are made.
    pub fn thins(&self) -> bool {
        self.shares_cache() && self.connections.thinning
    }

    /// Weights know of the resampling by records.
    pub fn resamples(&self) -> bool {
        matches!(self.weights, Weights::Resampling | Weights::AtRecords)
    }

    /// Finds paths in more than one way, each of which can be shown alone.
    pub fn has_strategies(&self) -> bool {
        self.selector.is_some()
    }

    /// Eye and light vertices are connected, and weights take the density of a connection as the same for all pairs.
    pub fn connects_by_ratio(&self) -> bool {
        self.selector.is_some() && self.weights == Weights::Ratio
    }

    /// That density follows from the mean number of vertices on a light path.
    pub fn needs_mean_length(&self) -> bool {
        self.selector == Some(Selector::Uniform) && self.connects_by_ratio()
    }

    /// Share of the pixels that have an eye path which leaves records, where connections go by records.
    pub fn record_share(&self) -> Option<f64> {
        match self.selector {
            Some(Selector::Records { share }) => Some(share),
            Some(Selector::OwnPath | Selector::Uniform | Selector::Subspaces) | None => None,
        }
    }

    /// What the densities of connections are times in weights, by the number of the eye vertex: 1, 2, 3 and beyond; then the
    /// same of light that is hit. `light_vertices`: on a light path, on average.
    pub fn density_scales(&self, light_vertices: f32) -> [f32; 4] {
        let unit = match (self.selector, self.weights) {
            (Some(Selector::Uniform), Weights::Ratio) => 1.0 / light_vertices,
            // Each pair of vertices is connected once.
            (Some(Selector::OwnPath), Weights::Ratio) => 1.0 / self.connections.counts[0] as f32,
            (_, Weights::Subspaces | Weights::Resampling | Weights::AtRecords) => 1.0,
            (_, Weights::Ratio) => 0.0,
        };
        let [first, second, deep] = match self.record_share().filter(|_| self.weights == Weights::Ratio) {
            // However many the connections are, they stand for one of each pair of an eye and a light path.
            Some(_) => self.connections.connection_shares(),
            None => self.connections.scales().map(|scale| scale * unit),
        };
        // A light path's vertex that is connected to the camera knows one sum for all vertices beyond it, unless beside its
        // ratio goes what weights by subspaces need.
        let knows_second = !self.to_camera || self.weights == Weights::Subspaces;
        let second = if knows_second { second } else { deep };
        [first, second, deep, self.connections.hit_scale()]
    }

    /// In weights, light paths that are connected to the camera count as so many each.
    pub fn camera_share(&self) -> f32 {
        if self.shares_cache() && self.record_share().is_none() { CAMERA_SHARE } else { 1.0 }
    }

    /// Eye vertices are connected to a cache that light paths of all pixels are in.
    pub fn shares_cache(&self) -> bool {
        self.selector.is_some() && self.light_paths.are_shared()
    }
}
