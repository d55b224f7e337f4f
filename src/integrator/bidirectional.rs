//! Bidirectional path tracing, its variant with a light vertex cache, and light tracing: one light stage and one eye
//! stage for all of them. They differ in how many light paths there are and in which vertices are connected.
//!
//! An iteration is one sample of every pixel. First its light paths: each vertex is connected to the camera (t = 1),
//! where that is wanted, and stored in the light cache. Then the eye paths: at every vertex first the connections to
//! the cache, then the light that is met by chance, then the next ray.

use crate::device::layout::{Batch, Camera, Counts, LightVertex};
use crate::device::scene::DeviceScene;
use crate::device::{Bound, Context, Kernel};
use crate::error::DeviceError;
use crate::subspace::Model;

use super::subspaces::Subspaces;
use super::wavefront::{Bounce, Form, Size, Stage, Wavefront, total};
use super::{DEFAULT_LIGHT_PATHS, FirstSubspaces, Integrator, Method, Settings};

/// Connections in flight for each eye vertex when all vertices of a light path are connected; longer paths take
/// several rounds.
const OWN_PATH_CELLS: u32 = 4;
/// Room in the cache for each light path at first; it grows where that is too little.
const FIRST_VERTICES_A_PATH: u64 = 6;
/// Light paths whose mean number of vertices is the cache's L in all weights.
const PILOT_PATHS: u32 = 4096;
/// The iteration whose light paths the pilot traces: one that no render comes to.
const PILOT_SAMPLE: u32 = u32::MAX;

/// See the module.
pub(super) struct Bidirectional {
    pub wavefront: Wavefront,
    method: Method,
    /// Light paths of an iteration.
    light_paths: u32,
    connection_density: f32,
    kernels: Kernels,
    /// Connections are chosen by subspaces.
    subspaces: Option<Subspaces>,
    /// `None` where there is nothing to sample as a light.
    light: Option<LightStage>,
    /// Shading of eye paths; none in light tracing.
    eye_shade: Option<[Bound; 2]>,
    connect: Option<[Bound; 2]>,
}

/// What is bound anew when the cache grows.
struct Kernels {
    light_rays: Option<Kernel>,
    light_shade: Option<Kernel>,
    light_order: Option<Kernel>,
    light_connections: Option<Kernel>,
}

struct LightStage {
    rays: Bound,
    /// With connections to the camera, and without.
    bounce: Bounce,
    quiet_bounce: Bounce,
    camera_connections: Option<[Bound; 2]>,
    /// Tests the connections to the camera.
    camera_tests: Vec<Stage>,
    closest_hit: [Bound; 2],
    /// Sorts the cache: none without a cache.
    scan: Option<Bound>,
    order: Option<Bound>,
    /// Vertices that the cache holds.
    capacity: u32,
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
    ) -> Result<Self, DeviceError> {
        let method = settings.method;
        let cells = match method {
            Method::Bdpt { .. } => OWN_PATH_CELLS,
            Method::LvcBpt { connections, .. } | Method::SpcBpt { connections, .. } => connections,
            Method::Path | Method::Light { .. } => 1,
        };
        let form = Form {
            cells,
            bidirectional: true,
            splats: method.traces_light(),
            subspaces: model.map_or(0, |model| model.subspaces),
            subspace_directions: model.is_some_and(|model| model.settings.direction_weight > 0.0),
        };
        let mut wavefront = Wavefront::new(context, scene, camera, settings, form)?;
        let pixels = settings.region.pixels();
        let light_paths = match method {
            Method::LvcBpt { light_paths, .. } | Method::SpcBpt { light_paths, .. } => {
                let default = f64::from(settings.width) * f64::from(settings.height) * DEFAULT_LIGHT_PATHS;
                light_paths.unwrap_or(default.ceil() as u32)
            }
            Method::Light { light_paths } => light_paths.unwrap_or(settings.width * settings.height),
            Method::Path | Method::Bdpt { .. } => pixels,
        };
        let caches = !matches!(method, Method::Light { .. });
        let lights = wavefront.has_lights();
        let subspaces = match model {
            Some(model) if lights => Some(Subspaces::new(context, &mut wavefront, model)?),
            _ => None,
        };
        let mut kernels =
            Kernels { light_rays: None, light_shade: None, light_order: None, light_connections: None };
        if lights {
            let light = light_features(method);
            kernels.light_rays = Some(wavefront.compile(context, "light_rays", &light)?);
            kernels.light_shade = Some(wavefront.compile(context, "light_shade", &light)?);
            if caches {
                kernels.light_order = Some(wavefront.compile(context, "light_order", &[])?);
                let own: &[&str] = if let Method::Bdpt { .. } = method { &["own_light_path"] } else { &[] };
                kernels.light_connections = Some(wavefront.compile(context, "light_connections", own)?);
            }
        }
        let eye_shade = match caches {
            true => {
                let kernel = wavefront.compile(context, "eye_shade", &[])?;
                Some(wavefront.bind_pair(context, &kernel)?)
            }
            false => None,
        };
        let mut integrator = Self {
            wavefront,
            method,
            light_paths,
            connection_density: 1.0,
            kernels,
            subspaces,
            light: None,
            eye_shade,
            connect: None,
        };
        if lights {
            integrator.make_light_stage(context)?;
            if let Method::LvcBpt { connections, .. } = method {
                integrator.connection_density =
                    connections as f32 / integrator.vertices_a_path(context)? as f32;
            }
        }
        Ok(integrator)
    }

    /// Compiles and binds what only the light stage has, with a cache for a few vertices a path.
    fn make_light_stage(&mut self, context: &Context) -> Result<(), DeviceError> {
        let features = light_features(self.method);
        let cached = self.cached_paths();
        let wavefront = &mut self.wavefront;
        let closest_hit = match wavefront.has_alpha() {
            true => {
                let kernel = wavefront.compile(context, "closest_hit", &features)?;
                wavefront.bind_pair(context, &kernel)?
            }
            false => wavefront.closest_hit.clone(),
        };
        let mut camera_tests = Vec::new();
        let mut camera_connections = None;
        if self.method.traces_light() {
            let kernel = wavefront.compile(context, "camera_connections", &features)?;
            camera_connections = Some(wavefront.bind_pair(context, &kernel)?);
            let mut splat_features = features.clone();
            splat_features.extend(["any_hit", "splats_atomic"]);
            let occlusion = wavefront.compile(context, "occlusion", &splat_features)?;
            camera_tests.push(wavefront.test_connections[0].clone());
            camera_tests.push(Stage::new(&occlusion.bind(context, &wavefront.buffers)?, Size::Shadow));
        }
        let mut scan = None;
        if cached > 0 {
            let words = u64::from(cached) * 4;
            wavefront.buffers.create(context, "light_path_lengths", words)?;
            wavefront.buffers.create(context, "light_path_offsets", words + 4)?;
            let kernel = wavefront.compile(context, "light_scan", &[])?;
            scan = Some(kernel.bind(context, &wavefront.buffers)?);
        }
        let none = || [Vec::new(), Vec::new()];
        let stage = LightStage {
            rays: closest_hit[0].clone(),
            bounce: none(),
            quiet_bounce: none(),
            camera_connections,
            camera_tests,
            closest_hit,
            scan,
            order: None,
            capacity: 0,
        };
        self.light = Some(stage);
        self.bind_cache(context, u64::from(cached) * FIRST_VERTICES_A_PATH)
    }

    /// Makes a cache of `vertices` and binds all that use it.
    fn bind_cache(&mut self, context: &Context, vertices: u64) -> Result<(), DeviceError> {
        let (wavefront, kernels) = (&mut self.wavefront, &self.kernels);
        let (Some(light), Some(rays), Some(shade)) =
            (&mut self.light, &kernels.light_rays, &kernels.light_shade)
        else {
            return Ok(());
        };
        if vertices > 0 {
            wavefront.buffers.create(
                context,
                "light_vertices",
                vertices * size_of::<LightVertex>() as u64,
            )?;
            wavefront.buffers.create(context, "light_order", vertices * 4)?;
        }
        light.capacity = vertices as u32;
        light.rays = wavefront.bind_pair(context, rays)?[0].clone();
        let shade = wavefront.bind_pair(context, shade)?;
        let bounce = |connects: bool, parity: usize| {
            let mut stages = vec![Stage::new(&light.closest_hit[parity], Size::Paths)];
            if let (true, Some(camera)) = (connects, &light.camera_connections) {
                stages.push(Stage::new(&camera[parity], Size::Paths));
                stages.extend(light.camera_tests.iter().cloned());
            }
            stages.push(Stage::new(&shade[parity], Size::Paths));
            stages.push(Stage::new(&wavefront.advance, Size::Count(1)));
            stages
        };
        light.bounce = [bounce(true, 0), bounce(true, 1)];
        light.quiet_bounce = [bounce(false, 0), bounce(false, 1)];
        if let Some(order) = &kernels.light_order {
            light.order = Some(order.bind(context, &wavefront.buffers)?);
        }
        if let Some(subspaces) = &mut self.subspaces {
            subspaces.bind(context, wavefront, vertices)?;
        }
        if let Some(connections) = &kernels.light_connections {
            self.connect = Some(wavefront.bind_pair(context, connections)?);
        }
        Ok(())
    }

    /// Light paths that the cache must hold at a time.
    fn cached_paths(&self) -> u32 {
        match self.method {
            Method::LvcBpt { .. } | Method::SpcBpt { .. } => self.light_paths.max(PILOT_PATHS),
            Method::Bdpt { .. } => self.light_paths.min(self.wavefront.capacity),
            Method::Path | Method::Light { .. } => 0,
        }
    }

    /// Mean number of vertices that a light path leaves in the cache, from paths that no picture is made of: a
    /// number that depends on the samples it weighs would bias them.
    fn vertices_a_path(&mut self, context: &Context) -> Result<f64, DeviceError> {
        let mut batch = self.wavefront.tiny_batch();
        batch.max_depth = self.wavefront.batches(0, 1)[0].max_depth;
        batch.first_sample = PILOT_SAMPLE;
        let counts = self.trace_light(context, &batch, PILOT_PATHS, Light::Cache)?;
        Ok(f64::from(counts.light_vertices) / f64::from(PILOT_PATHS))
    }

    /// Traces `paths` light paths into the cache, and nothing else: for those who learn from it.
    ///
    /// # Errors
    /// A lost device.
    pub fn fill_cache(&mut self, context: &Context, sample: u32, paths: u32) -> Result<Counts, DeviceError> {
        let mut batch = self.wavefront.batches(sample, 1)[0];
        batch.light_path_count = paths;
        self.trace_light(context, &batch, paths, Light::Cache)
    }

    /// Traces `paths` light paths; `template` says of which iteration, or, for light paths of pixels, of which pixels.
    fn trace_light(
        &mut self,
        context: &Context,
        template: &Batch,
        paths: u32,
        purpose: Light,
    ) -> Result<Counts, DeviceError> {
        let before = self.wavefront.counts(context)?;
        let mut purpose = purpose;
        loop {
            let mut encoder = context.device.create_command_encoder(&Default::default());
            // The cache starts empty.
            let offset = std::mem::offset_of!(Counts, light_vertices) as u64;
            encoder.clear_buffer(self.wavefront.buffers.get("counts")?, offset, Some(8));
            context.queue.submit([encoder.finish()]);
            for first in (0..paths).step_by(self.wavefront.capacity as usize) {
                let mut batch = *template;
                if !matches!(self.method, Method::Bdpt { .. }) {
                    batch.first_light_path = first;
                    batch.pixel_count = self.wavefront.capacity.min(paths - first);
                    batch.sample_count = 1;
                }
                self.trace_light_batch(context, &batch, purpose)?;
            }
            let counts = self.wavefront.counts(context)?;
            let light = &self.light;
            let capacity = light.as_ref().map_or(0, |light| light.capacity);
            if capacity > 0 && counts.light_vertices > capacity {
                // Once more with room for all; what went to the camera has arrived there.
                self.bind_cache(context, u64::from(counts.light_vertices) * 5 / 4)?;
                purpose = Light::Cache;
                continue;
            }
            let totals = &mut self.wavefront.light_counts;
            totals.light_closest_hit += total(counts.closest_total) - total(before.closest_total);
            totals.light_occlusion += total(counts.shadow_total) - total(before.shadow_total);
            totals.light_vertices += u64::from(counts.light_vertices);
            return self.sort_cache(context).map(|()| counts);
        }
    }

    fn trace_light_batch(
        &mut self,
        context: &Context,
        batch: &Batch,
        purpose: Light,
    ) -> Result<(), DeviceError> {
        let Some(light) = &self.light else { return Ok(()) };
        let rays = light.rays.clone();
        let tests = light.camera_tests.clone();
        let bounce = match purpose {
            Light::CameraAndCache => light.bounce.clone(),
            Light::Cache => light.quiet_bounce.clone(),
        };
        let mut encoder = self.wavefront.start(context, batch, &rays)?;
        if matches!(self.method, Method::Light { .. }) {
            self.wavefront.record(&mut encoder, &tests)?;
        }
        self.wavefront.bounce(context, encoder, &bounce, batch.max_depth)
    }

    fn sort_cache(&mut self, context: &Context) -> Result<(), DeviceError> {
        let Some(light) = &self.light else { return Ok(()) };
        let (Some(scan), Some(order)) = (&light.scan, &light.order) else { return Ok(()) };
        let mut stages =
            vec![Stage::new(scan, Size::Count(1)), Stage::new(order, Size::Count(light.capacity))];
        if let Some(subspaces) = &self.subspaces {
            stages.extend(subspaces.sort.iter().cloned());
        }
        self.wavefront.submit(context, &stages)
    }

    /// The stages of a bounce of eye paths.
    fn eye_bounce(&self, counts: &Counts) -> Bounce {
        let rounds = match self.method {
            Method::Bdpt { .. } => counts.longest_light_path.max(1).div_ceil(OWN_PATH_CELLS),
            _ => 1,
        };
        [0, 1].map(|parity: usize| {
            let mut stages = vec![Stage::new(&self.wavefront.closest_hit[parity], Size::Paths)];
            if let Some(subspaces) = &self.subspaces {
                stages.push(Stage::new(&subspaces.labels[parity], Size::Paths));
            }
            if let Some(connect) = &self.connect {
                for _ in 0..rounds {
                    stages.push(Stage::new(&connect[parity], Size::Cells));
                    stages.extend(self.wavefront.test_connections.iter().cloned());
                }
            }
            if let Some(shade) = &self.eye_shade {
                stages.push(Stage::new(&shade[parity], Size::Paths));
            }
            stages.push(Stage::new(&self.wavefront.advance, Size::Count(1)));
            stages
        })
    }

    fn trace_eye(&mut self, context: &Context, batch: &Batch, counts: &Counts) -> Result<(), DeviceError> {
        let first_rays = self.wavefront.camera_rays.clone();
        let encoder = self.wavefront.start(context, batch, &first_rays)?;
        if self.eye_shade.is_some() {
            let bounce = self.eye_bounce(counts);
            self.wavefront.bounce(context, encoder, &bounce, batch.max_depth)?;
        } else {
            context.queue.submit([encoder.finish()]);
        }
        self.wavefront.accumulate(context, batch)
    }

    /// One sample of every pixel.
    fn iterate(&mut self, context: &Context, batches: &[Batch], light_paths: u32) -> Result<(), DeviceError> {
        let lit = self.light.is_some();
        let batches: Vec<Batch> = batches
            .iter()
            .map(|&batch| Batch {
                light_path_count: light_paths,
                connection_density: match self.method {
                    Method::Light { .. } | Method::SpcBpt { .. } => 0.0,
                    _ => self.connection_density,
                },
                camera_paths: if lit && self.method.traces_light() { light_paths as f32 } else { 0.0 },
                ..batch
            })
            .collect();
        let mut counts = Counts::default();
        if let Method::Bdpt { .. } = self.method {
            let alone = batches.len() == 1;
            if lit && !alone && self.method.traces_light() {
                // All that light paths bring to the camera has to be there before the first pixel is summed.
                for batch in &batches {
                    self.trace_light(context, batch, 1, Light::CameraAndCache)?;
                }
            }
            for batch in &batches {
                if lit {
                    let purpose = if alone { Light::CameraAndCache } else { Light::Cache };
                    counts = self.trace_light(context, batch, 1, purpose)?;
                }
                self.trace_eye(context, batch, &counts)?;
            }
            return Ok(());
        }
        if lit {
            counts = self.trace_light(context, &batches[0], light_paths, Light::CameraAndCache)?;
        }
        for batch in &batches {
            self.trace_eye(context, batch, &counts)?;
        }
        Ok(())
    }
}

/// What light paths are traced for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Light {
    CameraAndCache,
    Cache,
}

/// What the kernels of light paths are compiled with.
fn light_features(method: Method) -> Vec<&'static str> {
    let mut features = vec!["light_paths"];
    match method {
        Method::LvcBpt { .. } | Method::SpcBpt { .. } => {
            features.extend(["shared_light_paths", "light_cache"]);
        }
        Method::Light { .. } => features.extend(["shared_light_paths", "light_only"]),
        Method::Path | Method::Bdpt { .. } => features.push("light_cache"),
    }
    features
}

impl Integrator for Bidirectional {
    fn render(&mut self, context: &Context, first_sample: u32, samples: u32) -> Result<(), DeviceError> {
        for sample in first_sample..first_sample + samples {
            let batches = self.wavefront.batches(sample, 1);
            self.iterate(context, &batches, self.light_paths)?;
        }
        Ok(())
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
