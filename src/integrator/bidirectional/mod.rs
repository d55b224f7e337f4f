//! Bidirectional path tracing, its variant with a light vertex cache, and light tracing: one light stage and one eye
//! stage for all of them. They differ in how many light paths there are and in which vertices are connected.
//!
//! An iteration is a set of light paths and the samples of all pixels that share it: a group of them where that is better
//! than one. First its light paths: each vertex is connected to the camera (t = 1), where that is wanted, and stored in the
//! light cache. Then the eye paths: at every vertex first the connections to the cache, then the light that is met by
//! chance, then the next ray. The light paths stay as long as samples of the iteration follow, so that pictures do not
//! depend on how many samples are rendered at once.

mod iterate;
mod kernels;
mod records;
pub mod settings;
mod splats;
mod subspaces;

use crate::device::layout::{Camera, SAMPLES_A_GROUP};
use crate::device::scene::DeviceScene;
use crate::device::{Context, DeviceError};
use crate::film::Region;
use crate::subspace::{Connections, FirstConnections, Model};

use super::wavefront::{Form, Wavefront};
use super::{Choice, FirstSubspaces, Integrator, LightPaths, Plan, Settings, Weights};
use kernels::{Kernels, Stages};
use records::Records;
use settings::RecordCost;
use subspaces::Subspaces;

/// Room in the cache for each light path at first; it grows where that is too little.
const FIRST_VERTICES_A_PATH: u64 = 6;
/// Light paths that a group of samples needs no more of, unless its picture is so large that a sample has more; and the same
/// where they are connected to the camera, which is also the most that samples share where so many are asked for each:
/// docs/measurements.md, Groups of samples.
const ENOUGH_LIGHT_PATHS: u32 = 1 << 16;
const ENOUGH_TO_CAMERA: u32 = 1 << 18;
/// Room that the cache has for each vertex that is there on average, or was last time.
const RESERVE: f64 = 1.25;
/// Light paths whose mean number of vertices is the cache's L in all weights.
const PILOT_PATHS: u32 = 4096;
/// The iteration whose light paths the pilot traces: one that no render comes to.
const PILOT_SAMPLE: u32 = u32::MAX;

/// See the module.
pub(crate) struct Bidirectional {
    pub wavefront: Wavefront,
    plan: Plan,
    /// Light paths of an iteration.
    light_paths: u32,
    /// Samples of an iteration, which share them.
    iteration: u32,
    /// There may be several of them.
    samples_share: bool,
    /// Of first vertices' connections, what the model wants.
    first_connections: Option<FirstConnections>,
    /// Of connections by depth, then of light that is hit: [`Plan::density_scales`].
    density_scales: [f32; 4],
    /// In the cache, on average; 0 where it is not known.
    vertices_per_path: f64,
    /// Fewer light paths than usual, for lack of room.
    is_capped: bool,
    /// Light paths of the pilot reached the camera, where they are connected to it.
    sees_light: bool,
    kernels: Kernels,
    /// Connections are chosen by subspaces.
    subspaces: Option<Subspaces>,
    /// Connections are chosen by records.
    records: Option<Records>,
    /// How many of them the pilot found.
    pilot_records: u32,
    /// The seed of the iterations that told weights of records; `None`: they know nothing of this view's.
    learnt_by: Option<u64>,
    /// Vertices that the cache holds, and light paths.
    capacity: u32,
    cached_paths: u32,
    stages: Stages,
}

/// What becomes of the paths that the kernels find.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    Picture,
    /// Light paths are read from the cache: its vertices are whole.
    LightVertices,
    /// Paths are written down in place of being shown.
    Records,
}

impl Bidirectional {
    /// Compiles the kernels for the scene and takes over its buffers.
    ///
    /// # Errors
    /// A kernel that does not compile, a buffer that does not fit.
    pub fn new(
        context: &Context,
        scene: DeviceScene,
        camera: &Camera,
        settings: Settings,
        model: Option<&Model>,
        purpose: Purpose,
    ) -> Result<Self, DeviceError> {
        let plan = settings.method.plan();
        let learns = purpose == Purpose::Records;
        // Without a light there is nothing to connect to.
        let model = model.filter(|_| scene.features.lights());
        let subspace_directions = model.is_some_and(|model| model.settings.direction_weight > 0.0);
        let form = Form {
            connections: plan.connections.in_flight(),
            bidirectional: true,
            splats: plan.to_camera,
            subspaces: model.is_some(),
            subspace_directions,
            resampling: plan.resamples() && scene.features.lights(),
            at_records: plan.weights == Weights::AtRecords && scene.features.lights(),
            thinning: plan.thins() && scene.thins,
            independent: plan.shares_cache() && settings.view.independent,
            learns,
            // Learning needs vertices whole, and labels by direction wait for the direction of a connection.
            lambert_vertices: purpose == Purpose::Picture
                && !subspace_directions
                && scene.features.lambert_only,
        };
        let mut wavefront = Wavefront::new(context, scene, camera, settings, form)?;
        let lights = wavefront.has_lights();
        let subspaces = match model {
            Some(model) => Some(Subspaces::new(context, &mut wavefront, model)?),
            None => None,
        };
        let records = match plan.record_share().filter(|_| lights) {
            Some(share) => Some(Records::new(context, &mut wavefront, share, plan.weights)?),
            None => None,
        };
        if learns {
            // Something to bind; more room comes with the first batch.
            wavefront.make_room_for_records(context, 1)?;
        }
        let guide = subspaces.as_ref().is_some_and(|subspaces: &Subspaces| subspaces.guided);
        let kernels = Kernels::new(context, &mut wavefront, &plan, lights, guide)?;
        let mut integrator = Self {
            wavefront,
            plan,
            light_paths: 1,
            iteration: 1,
            // Records are those of a sample, and training asks for so many light paths as it wants.
            samples_share: plan.shares_cache()
                && plan.record_share().is_none()
                && !settings.view.independent
                && purpose == Purpose::Picture,
            first_connections: None,
            // Unless the pilot knows better.
            density_scales: plan.density_scales(1.0),
            vertices_per_path: 0.0,
            is_capped: false,
            sees_light: true,
            kernels,
            subspaces,
            records,
            pilot_records: 0,
            learnt_by: None,
            capacity: 0,
            cached_paths: 0,
            stages: Stages::default(),
        };
        if let Some(model) = model {
            integrator.adapt_to(model);
        }
        integrator.divide(context);
        integrator.make_cache(context, integrator.first_vertices(context))?;
        if lights && plan.shares_cache() && purpose == Purpose::Picture {
            integrator.vertices_per_path = integrator.count_vertices(context)?;
            if plan.needs_mean_length() {
                integrator.density_scales = plan.density_scales(integrator.vertices_per_path as f32);
            }
            integrator.divide(context);
            integrator.make_room(context)?;
            integrator.make_room_for_tables(context)?;
        }
        if lights && plan.to_camera && purpose == Purpose::Picture {
            integrator.choose_splat_scale(context)?;
        }
        Ok(integrator)
    }

    /// Connections as the settings have them, whatever a model wants.
    fn set_connections(&self) -> Connections {
        self.wavefront.settings.method.plan().connections
    }

    /// First vertices have as many connections as this model wants, if that is left to it.
    fn adapt_to(&mut self, model: &Model) {
        let set = self.set_connections();
        if !set.adapts {
            return;
        }
        self.first_connections = model.first_connections;
        self.plan.connections.counts[0] = model.first_connections.map_or(set.counts[0], |first| first.count);
        self.density_scales = self.plan.density_scales(1.0);
    }

    /// How many light paths there are, and how many samples share them.
    fn divide(&mut self, context: &Context) {
        let settings = &self.wavefront.settings;
        let pixels = settings.view.width * settings.view.height;
        let a_sample = self.plan.light_paths.count(pixels, settings.view.region().pixels());
        let is_default = matches!(self.plan.light_paths, LightPaths::Shared { wanted: None, .. });
        self.iteration = if self.samples_share { SAMPLES_A_GROUP } else { 1 };
        self.light_paths = a_sample.saturating_mul(self.iteration);
        if self.samples_share && is_default {
            self.light_paths = self.light_paths.min(self.enough().max(a_sample));
        }
        // One buffer holds few of the light paths of a large picture, or between surfaces that absorb next to nothing.
        let most = self.most_vertices(context) as f64 / RESERVE;
        let vertices_per_path = match (self.plan.shares_cache(), self.vertices_per_path) {
            (true, 0.0) => FIRST_VERTICES_A_PATH as f64,
            (_, known) => known,
        };
        let vertices = |paths: u32| f64::from(paths) * vertices_per_path;
        self.is_capped = is_default && vertices(self.light_paths) > most;
        if self.is_capped {
            self.light_paths = ((most / vertices_per_path) as u32).max(1);
        }
        // Those that are asked for are for each sample: groups are made of whole iterations.
        let are_too_many = |paths: u32| vertices(paths) > most || paths > ENOUGH_TO_CAMERA;
        while self.iteration > 1 && !is_default && are_too_many(self.light_paths) {
            self.iteration /= 2;
            self.light_paths = a_sample.saturating_mul(self.iteration);
        }
    }

    /// Light paths that a group needs no more of.
    fn enough(&self) -> u32 {
        if self.plan.to_camera { ENOUGH_TO_CAMERA } else { ENOUGH_LIGHT_PATHS }
    }

    /// Vertices that the cache has room for as long as nothing is known of light paths.
    fn first_vertices(&self, context: &Context) -> u64 {
        (u64::from(self.cached_paths()) * FIRST_VERTICES_A_PATH).min(self.most_vertices(context))
    }

    /// Vertices that one buffer of the device holds.
    pub(super) fn most_vertices(&self, context: &Context) -> u64 {
        context.binding / self.wavefront.light_vertex_bytes()
    }

    /// Makes room for the vertices that an iteration has on average, and some more, so that none is traced twice.
    fn make_room(&mut self, context: &Context) -> Result<(), DeviceError> {
        let vertices = (f64::from(self.light_paths) * self.vertices_per_path * RESERVE) as u64;
        if vertices > self.capacity.into() || self.cached_paths() > self.cached_paths {
            let wanted = vertices.min(self.most_vertices(context));
            self.make_cache(context, wanted.max(self.capacity.into()))?;
        }
        Ok(())
    }

    /// Makes a cache of `vertices`, and binds all that use it.
    fn make_cache(&mut self, context: &Context, vertices: u64) -> Result<(), DeviceError> {
        self.cached_paths = self.cached_paths();
        let cached = u64::from(self.cached_paths);
        if cached > 0 && self.wavefront.has_lights() {
            let vertex_bytes = self.wavefront.light_vertex_bytes();
            let buffers = &mut self.wavefront.buffers;
            buffers.create(context, "light_path_lengths", cached * 4)?;
            buffers.create(context, "light_path_offsets", cached * 4 + 4)?;
            buffers.create(context, "light_vertices", vertices * vertex_bytes)?;
            buffers.create(context, "light_order", vertices * 4)?;
            if self.wavefront.learns() {
                self.wavefront.buffers.create(context, "light_backs", vertices * 4)?;
            }
            if let Some(subspaces) = &self.subspaces {
                if subspaces.guided && self.plan.to_camera {
                    self.wavefront.buffers.create(context, "light_nominals", vertices * 4)?;
                }
                Subspaces::make_room(context, &mut self.wavefront, vertices)?;
            }
            self.capacity = vertices as u32;
        }
        self.bind(context)
    }

    /// Light paths that the cache must hold at a time.
    fn cached_paths(&self) -> u32 {
        if self.plan.shares_cache() {
            self.light_paths.max(PILOT_PATHS)
        } else if self.plan.selector.is_some() {
            self.light_paths.min(self.wavefront.capacity)
        } else {
            0
        }
    }

    /// Makes room for the tables of records, of which there are about as many as a pilot finds.
    fn make_room_for_tables(&mut self, context: &Context) -> Result<(), DeviceError> {
        let template = self.wavefront.batches(PILOT_SAMPLE, 1)[0];
        let vertices = (f64::from(self.light_paths) * self.vertices_per_path).ceil() as u32;
        self.with_records(context, |records, wavefront| {
            records.prepare(context, wavefront, &template)?;
            records.make_room_for_tables(context, wavefront, vertices)
        })?;
        self.pilot_records = self.records.as_ref().map_or(0, |records| records.count);
        Ok(())
    }

    /// Mean number of vertices that a light path leaves in the cache, from paths that no picture is made of: a
    /// number that depends on the samples it weighs would bias them.
    fn count_vertices(&mut self, context: &Context) -> Result<f64, DeviceError> {
        let batch = self.wavefront.batches(PILOT_SAMPLE, 1)[0];
        let counts = self.count_light_vertices(context, &batch, PILOT_PATHS)?;
        Ok(f64::from(counts.light_vertices) / f64::from(PILOT_PATHS))
    }
}

impl Integrator for Bidirectional {
    fn render(&mut self, context: &Context, first_sample: u32, samples: u32) -> Result<(), DeviceError> {
        self.learn_from_records(context)?;
        let end = first_sample + samples;
        let mut sample = first_sample;
        while sample < end {
            let first = sample - sample % self.iteration;
            let count = (first + self.iteration).min(end) - sample;
            let batches = self.wavefront.batches(sample, count);
            self.iterate(context, &batches, first, self.light_paths)?;
            sample += count;
        }
        Ok(())
    }

    fn samples_at_once(&self) -> u32 {
        self.wavefront.samples_at_once().min(self.iteration)
    }

    fn aim(&mut self, context: &Context, camera: &Camera, region: Region) -> Result<(), DeviceError> {
        self.wavefront.aim(context, camera, region)?;
        self.learnt_by = None;
        self.divide(context);
        if self.cached_paths() > self.cached_paths {
            self.make_cache(context, self.first_vertices(context).max(self.capacity.into()))?;
        }
        Ok(())
    }

    fn set_model(&mut self, context: &Context, model: &Model) -> Result<(), DeviceError> {
        if let Some(subspaces) = &mut self.subspaces {
            subspaces.upload(context, &mut self.wavefront, model)?;
            self.wavefront.light_at_hand = None;
            self.adapt_to(model);
            self.bind(context)?;
        }
        Ok(())
    }

    fn choices(&self) -> Vec<Choice> {
        let mut choices = Vec::new();
        if self.plan.shares_cache() {
            if let LightPaths::Shared { wanted: None, per_pixel } = self.plan.light_paths {
                let enough = self.enough();
                let reason = match self.light_paths {
                    _ if self.is_capped => "as many as one buffer has room for".to_string(),
                    paths if self.iteration > 1 && paths == enough => {
                        "enough for the samples that share them".into()
                    }
                    paths if self.iteration > 1 && paths > enough => format!("{per_pixel} for each pixel"),
                    _ => format!("{per_pixel} for each sample of a pixel"),
                };
                choices.push(Choice::new("light paths at a time", self.light_paths, reason));
            }
            if self.plan.connections.adapts && self.subspaces.is_some() {
                let reason = match &self.first_connections {
                    Some(first) => first.reason(),
                    None => {
                        "the model does not say how many are worth it: it takes two rounds and paths that \
                             judge them"
                            .into()
                    }
                };
                choices.push(Choice::new("connections", self.plan.connections.counts_text(), reason));
            }
            if self.records.is_none() {
                let reason = match self.wavefront.settings.view.independent {
                    true => "samples are independent, as asked for",
                    false => "up to a group, by how many light paths there is room for",
                };
                choices.push(Choice::new("samples that share light paths", self.iteration, reason));
            }
        }
        if let Some(records) = &self.records {
            let cost = RecordCost {
                records: self.pilot_records.into(),
                vertices: (f64::from(self.light_paths) * self.vertices_per_path) as u64,
                eye_vertices: u64::from(self.pilot_records) * u64::from(records.stride).pow(2),
            };
            let mut reason = format!(
                "their tables of about {} light vertices take {:.2} M shadow rays a sample, and {:.1} MB",
                cost.vertices,
                cost.shadow_rays() as f64 * 1e-6,
                2.0 * cost.buffer_bytes() as f64 * 1e-6
            );
            if self.plan.weights == Weights::AtRecords {
                reason
                    .push_str(&format!("; weights take {:.2} M rays more", cost.weight_rays() as f64 * 1e-6));
            }
            choices.push(Choice::new("records", format!("about {}", self.pilot_records), reason));
        }
        choices
    }

    fn caveats(&self) -> Vec<String> {
        // Others have eye paths.
        if self.sees_light || self.plan.selector.is_some() {
            return Vec::new();
        }
        vec![format!(
            "of {PILOT_PATHS} light paths none reached the camera: the picture may stay black; look from elsewhere, or \
             take another integrator"
        )]
    }

    fn warm_up(&mut self, context: &Context) -> Result<(), DeviceError> {
        self.iterate(context, &[self.wavefront.tiny_batch()], PILOT_SAMPLE, 1)
    }

    fn first_subspaces(&mut self, context: &Context) -> Result<Option<Vec<FirstSubspaces>>, DeviceError> {
        match &self.subspaces {
            Some(subspaces) => subspaces.first(context, &mut self.wavefront).map(Some),
            None => Ok(None),
        }
    }

    fn wavefront(&self) -> &Wavefront {
        &self.wavefront
    }

    fn wavefront_mut(&mut self) -> &mut Wavefront {
        &mut self.wavefront
    }
}
