//! Bidirectional path tracing, its variant with a light vertex cache, and light tracing: one light stage and one eye
//! stage for all of them. They differ in how many light paths there are and in which vertices are connected.
//!
//! An iteration is a sample of every pixel, or a few that share their light paths. First its light paths: each vertex is
//! connected to the camera (t = 1), where that is wanted, and stored in the light cache. Then the eye paths: at every
//! vertex first the connections to the cache, then the light that is met by chance, then the next ray.

pub mod settings;
mod subspaces;

use crate::device::layout::{Batch, Camera, Counts};
use crate::device::scene::DeviceScene;
use crate::device::{Bound, Context, DeviceError, Kernel};
use crate::film::Region;
use crate::subspace::Model;

use super::wavefront::{Bounce, Form, Size, Stage, Wavefront, total};
use super::{Choice, FirstSubspaces, Integrator, LightPaths, Plan, Selector, Settings};
use subspaces::Subspaces;

/// Room in the cache for each light path at first; it grows where that is too little.
const FIRST_VERTICES_A_PATH: u64 = 6;
/// Light paths whose mean number of vertices is the cache's L in all weights.
const PILOT_PATHS: u32 = 4096;
/// The iteration whose light paths the pilot traces: one that no render comes to.
const PILOT_SAMPLE: u32 = u32::MAX;

/// See the module.
pub(crate) struct Bidirectional {
    pub wavefront: Wavefront,
    plan: Plan,
    /// Light paths for each sample of all pixels.
    light_paths: u32,
    /// Samples of an iteration.
    iteration: u32,
    connection_density: f32,
    kernels: Kernels,
    /// Connections are chosen by subspaces.
    subspaces: Option<Subspaces>,
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

/// Compiled once.
struct Kernels {
    /// `None` where there is nothing to sample as a light.
    light: Option<LightKernels>,
    /// Shading of eye paths; none in light tracing.
    eye_shade: Option<Kernel>,
}

struct LightKernels {
    rays: Kernel,
    shade: Kernel,
    /// Where a traversal draws numbers, those of light paths are others.
    closest_hit: Option<Kernel>,
    /// Connects to the camera, and tests these connections.
    camera: Option<[Kernel; 2]>,
    cache: Option<CacheKernels>,
}

struct CacheKernels {
    scan: Kernel,
    order: Kernel,
    connections: Kernel,
}

/// The kernels with their buffers: bound anew when the cache grows or another model comes.
#[derive(Default)]
struct Stages {
    light_rays: Option<Bound>,
    /// Of light paths, with connections to the camera and without.
    light_bounce: Bounce,
    quiet_light_bounce: Bounce,
    camera_tests: Vec<Stage>,
    sort: Vec<Stage>,
    connect: Option<[Bound; 2]>,
    eye_shade: Option<[Bound; 2]>,
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
        let subspace_directions = model.is_some_and(|model| model.settings.direction_weight > 0.0);
        let form = Form {
            cells: plan.connections,
            bidirectional: true,
            splats: plan.to_camera,
            subspaces: model.is_some(),
            subspace_directions,
            learns,
            // Who learns wants vertices whole, and labels by direction wait for the direction of a connection.
            lambert_vertices: purpose == Purpose::Picture
                && !subspace_directions
                && scene.features.lambert_only,
        };
        let mut wavefront = Wavefront::new(context, scene, camera, settings, form)?;
        let lights = wavefront.has_lights();
        let subspaces = match model {
            Some(model) if lights => Some(Subspaces::new(context, &mut wavefront, model)?),
            _ => None,
        };
        if learns {
            // Something to bind; more room comes with the first batch.
            wavefront.make_room_for_records(context, 1)?;
        }
        let kernels = Kernels {
            light: if lights { Some(LightKernels::new(context, &mut wavefront, &plan)?) } else { None },
            eye_shade: match plan.selector {
                Some(_) => Some(wavefront.compile(context, "eye_shade", &[])?),
                None => None,
            },
        };
        let mut integrator = Self {
            wavefront,
            plan,
            light_paths: 1,
            iteration: 1,
            connection_density: 1.0,
            kernels,
            subspaces,
            capacity: 0,
            cached_paths: 0,
            stages: Stages::default(),
        };
        integrator.divide();
        integrator.make_cache(context, u64::from(integrator.cached_paths()) * FIRST_VERTICES_A_PATH)?;
        if lights && plan.selector == Some(Selector::Uniform) {
            let vertices_per_path = integrator.vertices_per_path(context)?;
            integrator.connection_density = plan.connections as f32 / vertices_per_path as f32;
        }
        Ok(integrator)
    }

    /// How many light paths there are, and how many samples share them.
    fn divide(&mut self) {
        let settings = &self.wavefront.settings;
        let pixels = settings.view.width * settings.view.height;
        self.light_paths = self.plan.light_paths.count(pixels, settings.view.region().pixels());
        self.iteration = match self.plan.shares_cache() && !self.wavefront.learns() {
            true => self.wavefront.samples_at_once(self.light_paths),
            false => 1,
        };
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
            if self.subspaces.is_some() {
                Subspaces::make_room(context, &mut self.wavefront, vertices)?;
            }
            self.capacity = vertices as u32;
        }
        self.bind(context)
    }

    /// Binds all kernels to the buffers of now.
    ///
    /// # Errors
    /// A buffer that is missing.
    pub fn bind(&mut self, context: &Context) -> Result<(), DeviceError> {
        let wavefront = &mut self.wavefront;
        wavefront.bind_tests(context)?;
        let mut stages = Stages::default();
        if let Some(kernel) = &self.kernels.eye_shade {
            stages.eye_shade = Some(wavefront.bind_pair(context, kernel)?);
        }
        if let Some(subspaces) = &mut self.subspaces {
            subspaces.bind(context, wavefront)?;
        }
        let Some(kernels) = &self.kernels.light else {
            self.stages = stages;
            return Ok(());
        };
        let [rays, _] = wavefront.bind_pair(context, &kernels.rays)?;
        stages.light_rays = Some(rays);
        let closest_hit = match &kernels.closest_hit {
            Some(kernel) => wavefront.bind_pair(context, kernel)?,
            None => wavefront.closest_hit.clone(),
        };
        let shade = wavefront.bind_pair(context, &kernels.shade)?;
        let mut camera = None;
        if let Some([connections, occlusion]) = &kernels.camera {
            camera = Some(wavefront.bind_pair(context, connections)?);
            stages.camera_tests = vec![
                wavefront.test_connections[0].clone(),
                Stage::new(&occlusion.bind(context, &wavefront.buffers)?, Size::Shadow),
            ];
        }
        let bounce = |connects: bool, parity: usize| {
            let mut bounce = vec![Stage::new(&closest_hit[parity], Size::Paths)];
            if let (true, Some(camera)) = (connects, &camera) {
                bounce.push(Stage::new(&camera[parity], Size::Paths));
                bounce.extend(stages.camera_tests.iter().cloned());
            }
            bounce.push(Stage::new(&shade[parity], Size::Paths));
            bounce.push(Stage::new(&wavefront.advance, Size::Count(1)));
            bounce
        };
        stages.light_bounce = [bounce(true, 0), bounce(true, 1)];
        stages.quiet_light_bounce = [bounce(false, 0), bounce(false, 1)];
        if let Some(cache) = &kernels.cache {
            stages.sort = vec![
                Stage::new(&cache.scan.bind(context, &wavefront.buffers)?, Size::Count(1)),
                Stage::new(&cache.order.bind(context, &wavefront.buffers)?, Size::Count(self.capacity)),
            ];
            stages.connect = Some(wavefront.bind_pair(context, &cache.connections)?);
        }
        if let Some(subspaces) = &self.subspaces {
            stages.sort.extend(subspaces.sort.iter().cloned());
        }
        self.stages = stages;
        Ok(())
    }

    /// Light paths that the cache must hold at a time.
    fn cached_paths(&self) -> u32 {
        match self.plan.selector {
            Some(Selector::Uniform | Selector::Subspaces) => {
                self.light_paths.saturating_mul(self.iteration).max(PILOT_PATHS)
            }
            Some(Selector::OwnPath) => self.light_paths.min(self.wavefront.capacity),
            None => 0,
        }
    }

    /// Mean number of vertices that a light path leaves in the cache, from paths that no picture is made of: a
    /// number that depends on the samples it weighs would bias them.
    fn vertices_per_path(&mut self, context: &Context) -> Result<f64, DeviceError> {
        let batch = self.wavefront.batches(PILOT_SAMPLE, 1)[0];
        let counts = self.fill_cache(context, &batch, PILOT_PATHS)?;
        Ok(f64::from(counts.light_vertices) / f64::from(PILOT_PATHS))
    }

    /// Traces `paths` light paths into the cache that all eye paths share, and nothing else; `batch` says of which sample.
    ///
    /// # Errors
    /// A lost device.
    pub fn fill_cache(
        &mut self,
        context: &Context,
        batch: &Batch,
        paths: u32,
    ) -> Result<Counts, DeviceError> {
        let template = Batch { light_path_count: paths, ..*batch };
        self.trace_light(context, &self.shared_batches(&template), Light::Cache)
    }

    /// The light paths of an iteration, as many at a time as the queues hold.
    fn shared_batches(&self, template: &Batch) -> Vec<Batch> {
        let paths = template.light_path_count;
        let most = self.wavefront.slice;
        (0..paths)
            .step_by(most as usize)
            .map(|first| Batch {
                first_light_path: first,
                pixel_count: most.min(paths - first),
                sample_count: 1,
                ..*template
            })
            .collect()
    }

    /// Traces batches of light paths into the empty cache and sorts it.
    fn trace_light(
        &mut self,
        context: &Context,
        batches: &[Batch],
        purpose: Light,
    ) -> Result<Counts, DeviceError> {
        let before = self.wavefront.counts(context)?;
        let mut purpose = purpose;
        let counts = loop {
            let mut encoder = context.device.create_command_encoder(&Default::default());
            let offset = std::mem::offset_of!(Counts, light_vertices) as u64;
            encoder.clear_buffer(self.wavefront.buffers.get("counts")?, offset, Some(8));
            context.queue.submit([encoder.finish()]);
            for batch in batches {
                self.trace_light_batch(context, batch, purpose)?;
            }
            let counts = self.wavefront.counts(context)?;
            if self.capacity == 0 || counts.light_vertices <= self.capacity {
                break counts;
            }
            self.wavefront.light_counts.cache_overflows += 1;
            // Once more with room for all; what went to the camera has arrived there.
            self.make_cache(context, u64::from(counts.light_vertices) * 5 / 4)?;
            purpose = Light::Cache;
        };
        let totals = &mut self.wavefront.light_counts;
        totals.light_closest_hit += total(counts.closest_total) - total(before.closest_total);
        totals.light_occlusion += total(counts.shadow_total) - total(before.shadow_total);
        totals.light_vertices += u64::from(counts.light_vertices);
        self.wavefront.submit(context, &self.stages.sort)?;
        Ok(counts)
    }

    fn trace_light_batch(
        &mut self,
        context: &Context,
        batch: &Batch,
        purpose: Light,
    ) -> Result<(), DeviceError> {
        let Some(rays) = &self.stages.light_rays else { return Ok(()) };
        let bounce = match purpose {
            Light::CameraAndCache => &self.stages.light_bounce,
            Light::Cache => &self.stages.quiet_light_bounce,
        };
        let mut encoder = self.wavefront.start(context, batch, rays)?;
        if self.plan.selector.is_none() {
            self.wavefront.record(&mut encoder, &self.stages.camera_tests)?;
        }
        self.wavefront.bounce(context, encoder, bounce, batch.max_depth)
    }

    /// Each eye path has a light path of its own.
    fn connects_own_path(&self) -> bool {
        self.plan.selector == Some(Selector::OwnPath)
    }

    /// The stages of a bounce of eye paths.
    fn eye_bounce(&self, counts: &Counts) -> Bounce {
        let rounds = match self.connects_own_path() {
            true => counts.longest_light_path.max(1).div_ceil(self.plan.connections),
            false => 1,
        };
        [0, 1].map(|parity: usize| {
            let mut stages = vec![Stage::new(&self.wavefront.closest_hit[parity], Size::Paths)];
            if let Some(labels) = self.subspaces.as_ref().and_then(|subspaces| subspaces.labels.as_ref()) {
                stages.push(Stage::new(&labels[parity], Size::Paths));
            }
            if let Some(connect) = &self.stages.connect {
                for _ in 0..rounds {
                    stages.push(Stage::new(&connect[parity], Size::Cells));
                    stages.extend(self.wavefront.test_connections.iter().cloned());
                }
            }
            if let Some(shade) = &self.stages.eye_shade {
                stages.push(Stage::new(&shade[parity], Size::Paths));
            }
            stages.push(Stage::new(&self.wavefront.advance, Size::Count(1)));
            stages
        })
    }

    /// Traces eye paths against the cache.
    fn trace_eye(&mut self, context: &Context, batch: &Batch, counts: &Counts) -> Result<(), DeviceError> {
        let first_rays = self.wavefront.camera_rays.clone();
        let encoder = self.wavefront.start(context, batch, &first_rays)?;
        if self.stages.eye_shade.is_some() {
            let bounce = self.eye_bounce(counts);
            return self.wavefront.bounce(context, encoder, &bounce, batch.max_depth);
        }
        context.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// A batch as the method's kernels want it.
    fn complete(&self, batch: Batch, light_paths: u32) -> Batch {
        let to_camera = self.stages.light_rays.is_some() && self.plan.to_camera;
        Batch {
            light_path_count: light_paths,
            connection_density: match self.plan.selector {
                Some(Selector::OwnPath | Selector::Uniform) => self.connection_density,
                Some(Selector::Subspaces) | None => 0.0,
            },
            camera_paths: if to_camera { light_paths as f32 } else { 0.0 },
            ..batch
        }
    }

    /// Traces the eye paths of a batch against `light_paths` light paths, for kernels that write down what they find.
    ///
    /// # Errors
    /// A lost device.
    pub fn find_paths(
        &mut self,
        context: &Context,
        batch: &Batch,
        light_paths: u32,
    ) -> Result<Counts, DeviceError> {
        let batch = self.complete(*batch, light_paths);
        let counts = self.trace_light(context, &self.shared_batches(&batch), Light::Cache)?;
        self.trace_eye(context, &batch, &counts)?;
        Ok(counts)
    }

    /// An iteration of the batches' samples.
    fn iterate(&mut self, context: &Context, batches: &[Batch], light_paths: u32) -> Result<(), DeviceError> {
        let lit = self.stages.light_rays.is_some();
        let batches: Vec<Batch> = batches.iter().map(|&batch| self.complete(batch, light_paths)).collect();
        let own_paths = self.connects_own_path();
        let mut purpose = Light::CameraAndCache;
        let mut counts = Counts::default();
        if lit && !own_paths {
            counts = self.trace_light(context, &self.shared_batches(&batches[0]), purpose)?;
        } else if lit && batches.len() > 1 && self.plan.to_camera {
            // All that light paths bring to the camera has to be there before the first pixel is summed.
            for batch in &batches {
                self.trace_light(context, &[*batch], purpose)?;
            }
            purpose = Light::Cache;
        }
        for batch in &batches {
            if lit && own_paths {
                counts = self.trace_light(context, &[*batch], purpose)?;
            }
            self.trace_eye(context, batch, &counts)?;
            self.wavefront.accumulate(context, batch)?;
        }
        Ok(())
    }
}

impl LightKernels {
    fn new(context: &Context, wavefront: &mut Wavefront, plan: &Plan) -> Result<Self, DeviceError> {
        let features = light_features(plan);
        let closest_hit = match wavefront.has_alpha() {
            true => Some(wavefront.compile(context, "closest_hit", &features)?),
            false => None,
        };
        let camera = match plan.to_camera {
            true => {
                let mut splat_features = features.clone();
                splat_features.extend(["any_hit", "splats_atomic"]);
                Some([
                    wavefront.compile(context, "camera_connections", &features)?,
                    wavefront.compile(context, "occlusion", &splat_features)?,
                ])
            }
            false => None,
        };
        let cache = match plan.selector {
            None => None,
            Some(selector) => {
                let own: &[&str] = if selector == Selector::OwnPath { &["own_light_path"] } else { &[] };
                Some(CacheKernels {
                    scan: wavefront.compile(context, "light_scan", &[])?,
                    order: wavefront.compile(context, "light_order", &[])?,
                    connections: wavefront.compile(context, "light_connections", own)?,
                })
            }
        };
        Ok(Self {
            rays: wavefront.compile(context, "light_rays", &features)?,
            shade: wavefront.compile(context, "light_shade", &features)?,
            closest_hit,
            camera,
            cache,
        })
    }
}

/// What light paths are traced for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Light {
    CameraAndCache,
    Cache,
}

/// What the kernels of light paths are compiled with.
fn light_features(plan: &Plan) -> Vec<&'static str> {
    let mut features = vec!["light_paths"];
    if plan.light_paths.are_shared() {
        features.push("shared_light_paths");
    }
    features.push(if plan.selector.is_some() { "light_cache" } else { "light_only" });
    features
}

impl Integrator for Bidirectional {
    fn render(&mut self, context: &Context, first_sample: u32, samples: u32) -> Result<(), DeviceError> {
        let end = first_sample + samples;
        let mut sample = first_sample;
        while sample < end {
            let count = (self.iteration - sample % self.iteration).min(end - sample);
            let batches = self.wavefront.batches(sample, count);
            self.iterate(context, &batches, self.light_paths.saturating_mul(count))?;
            sample += count;
        }
        Ok(())
    }

    fn samples_at_once(&self) -> u32 {
        self.iteration
    }

    fn aim(&mut self, context: &Context, camera: &Camera, region: Region) -> Result<(), DeviceError> {
        self.wavefront.aim(context, camera, region)?;
        self.divide();
        if self.cached_paths() > self.cached_paths {
            let vertices = u64::from(self.cached_paths()) * FIRST_VERTICES_A_PATH;
            self.make_cache(context, vertices.max(self.capacity.into()))?;
        }
        Ok(())
    }

    fn set_model(&mut self, context: &Context, model: &Model) -> Result<(), DeviceError> {
        if let Some(subspaces) = &mut self.subspaces {
            subspaces.upload(context, &mut self.wavefront, model)?;
            self.bind(context)?;
        }
        Ok(())
    }

    fn choices(&self) -> Vec<Choice> {
        let mut choices = Vec::new();
        if self.plan.shares_cache() {
            if let LightPaths::Shared { wanted: None, per_pixel } = self.plan.light_paths {
                let reason = format!("{per_pixel} for each pixel");
                choices.push(Choice::new("light paths per sample", self.light_paths, reason));
            }
            let reason = "all that the queues hold at once, up to a group";
            choices.push(Choice::new("samples that share light paths", self.iteration, reason));
        }
        choices
    }

    fn warm_up(&mut self, context: &Context) -> Result<(), DeviceError> {
        self.iterate(context, &[self.wavefront.tiny_batch()], 1)
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
