//! The queues between kernels, and the loop over the surfaces of a batch of paths. An integrator says which stages a
//! bounce has.

mod first_hits;
pub mod submission;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::device::layout::{
    Batch, Camera, Counts, EVERY_STRATEGY, FilmPixel, FirstHitPixel, Hit, LambertVertex, LightVertex,
    PathRay, SAMPLES_A_GROUP, ShadowRay, SubPath, TrainingEnd, TrainingVertex,
};
use crate::device::scene::DeviceScene;
use crate::device::shader::Features;
use crate::device::timing::Timing;
use crate::device::{Bound, BufferTable, Context, DeviceError, Kernel};
use crate::film::Region;
use crate::math::rng::seed_key;

use super::{Settings, Strategy};
use submission::SubmissionLimit;

/// Surfaces between two looks at how many paths are left.
const BOUNCES_A_SUBMISSION: u32 = 8;
/// Depth is stored in 16 bits.
const LARGEST_DEPTH: u32 = 0xffff;
/// Paths in flight on a software device: enough to hide the tail of a batch, few enough to stay in its caches and
/// to keep a dispatch near 100 ms.
const CPU_CAPACITY: u32 = 1 << 16;
/// Paths in flight on a GPU.
const GPU_CAPACITY: u32 = 1 << 20;

/// What was done so far, exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct RayCounts {
    pub closest_hit: u64,
    /// Connections tested: those that would carry light.
    pub occlusion: u64,
    /// Of the rays above, those of light paths.
    pub light_closest_hit: u64,
    /// Of the connections above, those of light paths to the camera.
    pub light_occlusion: u64,
    /// Vertices that light paths left in the cache.
    pub light_vertices: u64,
    /// Iterations whose light vertices found no room in the cache, and were traced once more with enough of it.
    pub cache_overflows: u64,
    /// Light vertices of infinite or undefined weight, which connections by subspaces leave out.
    pub non_finite_vertices: u64,
}

/// How many invocations a stage has: known here, or read by the device from `arguments`.
#[derive(Clone, Copy)]
pub(crate) enum Size {
    Count(u32),
    /// Paths in the queue.
    Paths,
    /// Connections in the queue.
    Shadow,
    /// Cells of the paths in the queue.
    Cells,
}

/// A kernel of a bounce.
#[derive(Clone)]
pub(crate) struct Stage {
    pub kernel: Bound,
    pub size: Size,
}

impl Stage {
    pub fn new(kernel: &Bound, size: Size) -> Self {
        Self { kernel: kernel.clone(), size }
    }
}

/// The stages of a bounce. Paths change places between two buffers, hence two of each.
pub(crate) type Bounce = [Vec<Stage>; 2];

/// What a wavefront is made for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Form {
    /// Connections that a path may have in flight.
    pub cells: u32,
    /// Rays carry what bidirectional weights need.
    pub bidirectional: bool,
    /// Light paths add to the film.
    pub splats: bool,
    /// Vertices are classified into subspaces.
    pub subspaces: bool,
    /// Directions count in the classification.
    pub subspace_directions: bool,
    /// Paths are written down, for the host to learn from.
    pub learns: bool,
    /// Light vertices are those of `LambertVertex`.
    pub lambert_vertices: bool,
}

/// Kernels and queues of a path-space wavefront.
pub struct Wavefront {
    pub buffers: BufferTable,
    pub(crate) settings: Settings,
    pub(crate) capacity: u32,
    pub(crate) courtesy: Option<SubmissionLimit>,
    /// Paths in flight at once, the capacity at most.
    pub(crate) slice: u32,
    /// Paths of the batch that is under way.
    pub(crate) started: u32,
    features: Features,
    constants: Vec<(&'static str, f64)>,
    swapped: Vec<(&'static str, [wgpu::Buffer; 2])>,
    pub(crate) camera_rays: Bound,
    pub(crate) closest_hit: [Bound; 2],
    pub(crate) advance: Bound,
    tests: Option<[Kernel; 2]>,
    /// Tests the connections in the queue; none where nothing connects.
    pub(crate) test_connections: Vec<Stage>,
    accumulate: Bound,
    pub(crate) first_hit: Option<Bound>,
    pub timing: Option<Timing>,
    pub compile_time: Duration,
    /// What the device does not count apart.
    pub(crate) light_counts: RayCounts,
    /// Rays of the device's counts that no picture is made of.
    pub(crate) aside: u64,
    /// K, subspaces a side.
    pub(crate) subspaces: u32,
}

impl Wavefront {
    /// Compiles the kernels that all integrators share, takes over the scene's buffers and makes the queues.
    ///
    /// # Errors
    /// A kernel that does not compile, a queue that does not fit.
    pub(crate) fn new(
        context: &Context,
        mut scene: DeviceScene,
        camera: &Camera,
        settings: Settings,
        form: Form,
    ) -> Result<Self, DeviceError> {
        let mut features = scene.kernel_features();
        let connects = features.contains("lights");
        if form.bidirectional {
            features.insert("bidirectional");
        }
        if form.splats {
            features.insert("splats");
        }
        if form.subspaces {
            features.insert("subspaces");
        }
        if form.subspace_directions {
            features.insert("subspace_directions");
        }
        if form.learns {
            features.insert("learns");
        }
        if form.lambert_vertices {
            features.insert("lambert_vertices");
        }
        if context.is_cpu() {
            features.insert("one_lane");
        }
        let mut constants = std::mem::take(&mut scene.constants);
        constants.push(("CELLS", f64::from(form.cells)));
        constants.push(("ROULETTE_CAP", f64::from(settings.view.roulette_cap)));

        let mut compile_time = Duration::ZERO;
        let mut compile = |name: &str, extra: &[&'static str]| {
            let features = features.iter().chain(extra).copied().collect();
            let kernel = Kernel::new(context, name, &features, &constants)?;
            compile_time += kernel.compile_time;
            Ok::<Kernel, DeviceError>(kernel)
        };
        let camera_rays = compile("camera_rays", &[])?;
        let closest_hit = compile("closest_hit", &[])?;
        let advance = compile("queue_advance", &[])?;
        let tests = match connects {
            true => Some([compile("shadow_advance", &[])?, compile("occlusion", &["any_hit"])?]),
            false => None,
        };
        let accumulate = compile("film_accumulate", &[])?;
        let first_hit = if settings.first_hit { Some(compile("first_hit", &[])?) } else { None };

        let capacity = if context.is_cpu() { CPU_CAPACITY } else { GPU_CAPACITY };
        let mut buffers = std::mem::take(&mut scene.buffers);
        let bytes = |size: usize| u64::from(capacity) * size as u64;
        let mut pair = |names: [&str; 2], size: usize| {
            let first = buffers.create(context, names[0], bytes(size))?.clone();
            Ok::<_, DeviceError>([first, buffers.create(context, names[1], bytes(size))?.clone()])
        };
        let mut swapped = vec![("paths", pair(["paths a", "paths b"], size_of::<PathRay>())?)];
        if form.bidirectional {
            swapped.push(("sub_paths", pair(["sub_paths a", "sub_paths b"], size_of::<SubPath>())?));
        }
        if form.subspaces {
            swapped.push(("shares", pair(["shares a", "shares b"], 16)?));
            buffers.create(context, "eye_labels", bytes(8))?;
        }
        let cells = u64::from(form.cells);
        buffers.create(context, "hits", bytes(size_of::<Hit>()))?;
        buffers.create(context, "radiance", cells * bytes(16))?;
        if connects {
            buffers.create(context, "shadow_rays", cells * bytes(size_of::<ShadowRay>()))?;
        }
        buffers.create(context, "counts", size_of::<Counts>() as u64)?;
        buffers.create_with(
            context,
            "arguments",
            48,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
        )?;
        let pixels = u64::from(settings.view.region().pixels());
        buffers.create(context, "film", pixels * size_of::<FilmPixel>() as u64)?;
        if form.splats {
            buffers.create(context, "splats", pixels * SPLAT_BYTES)?;
        }
        if first_hit.is_some() {
            buffers.create(context, "first_hits", pixels * size_of::<FirstHitPixel>() as u64)?;
        }
        buffers.upload_uniform(context, "camera", &[*camera])?;
        buffers.upload_uniform(context, "batch", &[Batch::default()])?;

        let [camera_rays, _] = bind_pair(context, &mut buffers, &swapped, &camera_rays)?;
        let closest_hit = bind_pair(context, &mut buffers, &swapped, &closest_hit)?;
        let advance = advance.bind(context, &buffers)?;
        let accumulate = accumulate.bind(context, &buffers)?;
        let first_hit = match first_hit {
            Some(kernel) => Some(bind_pair(context, &mut buffers, &swapped, &kernel)?[0].clone()),
            None => None,
        };
        let mut wavefront = Self {
            buffers,
            settings,
            capacity,
            courtesy: None,
            slice: capacity,
            started: 0,
            features,
            constants,
            swapped,
            camera_rays,
            closest_hit,
            advance,
            tests,
            test_connections: Vec::new(),
            accumulate,
            first_hit,
            timing: if settings.timing { Timing::new(context) } else { None },
            compile_time,
            light_counts: RayCounts::default(),
            aside: 0,
            subspaces: 0,
        };
        wavefront.bind_tests(context)?;
        Ok(wavefront)
    }

    /// Binds the tests of connections to the buffers of now.
    ///
    /// # Errors
    /// A buffer that is missing.
    pub(crate) fn bind_tests(&mut self, context: &Context) -> Result<(), DeviceError> {
        if let Some([advance, occlusion]) = &self.tests {
            self.test_connections = vec![
                Stage::new(&advance.bind(context, &self.buffers)?, Size::Count(1)),
                Stage::new(&occlusion.bind(context, &self.buffers)?, Size::Shadow),
            ];
        }
        Ok(())
    }

    /// Samples of the whole picture that the queues hold at once, each with so many light paths; but no more than a group.
    pub(crate) fn samples_at_once(&self, light_paths: u32) -> u32 {
        let pixels = self.settings.view.width * self.settings.view.height;
        let most = (self.capacity / pixels.max(light_paths)).clamp(1, SAMPLES_A_GROUP);
        // Groups are made of whole iterations.
        1 << most.ilog2()
    }

    /// Something in the scene can be sampled as a light.
    pub(crate) fn has_lights(&self) -> bool {
        self.features.contains("lights")
    }

    /// Kernels write down the paths that they find.
    pub(crate) fn learns(&self) -> bool {
        self.features.contains("learns")
    }

    /// Bytes of a vertex of the light cache.
    pub(crate) fn light_vertex_bytes(&self) -> u64 {
        match self.features.contains("lambert_vertices") {
            true => size_of::<LambertVertex>() as u64,
            false => size_of::<LightVertex>() as u64,
        }
    }

    /// Masked or blended surfaces make every traversal draw numbers of its path.
    pub(crate) fn has_alpha(&self) -> bool {
        self.features.contains("alpha")
    }

    /// Compiles a kernel of an integrator, with features beside those of the scene.
    ///
    /// # Errors
    /// A kernel that does not compile.
    pub(crate) fn compile(
        &mut self,
        context: &Context,
        name: &str,
        extra: &[&'static str],
    ) -> Result<Kernel, DeviceError> {
        let features = self.features.iter().chain(extra).copied().collect();
        let kernel = Kernel::new(context, name, &features, &self.constants)?;
        self.compile_time += kernel.compile_time;
        Ok(kernel)
    }

    /// Binds a kernel that reads `*_in` and writes `*_out`: for even and for odd bounces.
    ///
    /// # Errors
    /// A buffer that is missing.
    pub(crate) fn bind_pair(
        &mut self,
        context: &Context,
        kernel: &Kernel,
    ) -> Result<[Bound; 2], DeviceError> {
        bind_pair(context, &mut self.buffers, &self.swapped, kernel)
    }

    /// Makes buffers for so many records of each kind of kernels that write down the paths that they find. What writes them
    /// has to be bound again.
    ///
    /// # Errors
    /// A buffer that does not fit.
    pub(crate) fn make_room_for_records(
        &mut self,
        context: &Context,
        capacity: u32,
    ) -> Result<(), DeviceError> {
        for (name, size) in [
            ("training_vertices", size_of::<TrainingVertex>()),
            ("training_ends", size_of::<TrainingEnd>()),
            // The connection slots are those of ends here.
            ("radiance", 16),
        ] {
            self.buffers.create(context, name, u64::from(capacity) * size as u64)?;
        }
        if self.buffers.get("training_counts").is_err() {
            self.buffers.create(context, "training_counts", 8)?;
        }
        Ok(())
    }

    /// Another view, of no more pixels than the first; what there is of the last has to be [`reset`](Self::reset).
    ///
    /// # Errors
    /// A lost device.
    pub(crate) fn aim(
        &mut self,
        context: &Context,
        camera: &Camera,
        region: Region,
    ) -> Result<(), DeviceError> {
        self.settings.view = self.settings.view.of_region(region);
        self.buffers.write(context, "camera", bytemuck::bytes_of(camera))
    }

    /// From now on renders with this seed, and of all strategies this one only.
    pub fn choose(&mut self, seed: u64, strategy: Option<Strategy>) {
        self.settings.view.seed = seed;
        self.settings.strategy = strategy;
    }

    /// Forgets all that was rendered and counted.
    ///
    /// # Errors
    /// A lost device.
    pub fn reset(&mut self, context: &Context) -> Result<(), DeviceError> {
        let mut encoder = context.device.create_command_encoder(&Default::default());
        for name in ["film", "counts", "splats"] {
            if let Ok(buffer) = self.buffers.get(name) {
                encoder.clear_buffer(buffer, 0, None);
            }
        }
        context.queue.submit([encoder.finish()]);
        self.light_counts = RayCounts::default();
        self.aside = 0;
        if let Some(timing) = &mut self.timing {
            timing.clear();
        }
        context.wait()
    }

    /// A batch of one path of the first pixel, to make drivers compile: they do so at the first dispatch.
    pub(crate) fn tiny_batch(&self) -> Batch {
        Batch { pixel_count: 1, sample_count: 1, max_depth: 2, ..self.batches(0, 1)[0] }
    }

    /// Cuts samples into batches that the queues hold: whole rounds over small pictures, parts of large ones. Where only
    /// slices of the queues are used, there are fewer pixels in a batch, not fewer samples.
    pub(crate) fn batches(&self, first_sample: u32, samples: u32) -> Vec<Batch> {
        let pixels = self.settings.view.region().pixels();
        let samples_a_batch = (self.capacity / pixels).max(1);
        let pixels_a_batch = pixels.min((self.slice / samples_a_batch.min(samples.max(1))).max(1));
        let strategy = self.settings.strategy;
        let template = Batch {
            width: self.settings.view.width,
            height: self.settings.view.height,
            crop_x: self.settings.view.region().x,
            crop_y: self.settings.view.region().y,
            crop_width: self.settings.view.region().width,
            crop_height: self.settings.view.region().height,
            crop_stride: self.settings.view.region().stride,
            seed: seed_key(self.settings.view.seed),
            // Another stream than any user's seed gives the eye paths.
            light_seed: seed_key(!self.settings.view.seed).wrapping_add(LIGHT_STREAM),
            max_depth: self.settings.view.max_depth.unwrap_or(LARGEST_DEPTH).min(LARGEST_DEPTH),
            only_s: strategy.map_or(EVERY_STRATEGY, |strategy| strategy.s),
            only_t: strategy.map_or(EVERY_STRATEGY, |strategy| strategy.t),
            weighted: u32::from(strategy.is_none_or(|strategy| strategy.weighted)),
            subspaces: self.subspaces,
            ..Batch::default()
        };
        let mut batches = Vec::new();
        for sample in (0..samples).step_by(samples_a_batch as usize) {
            for pixel in (0..pixels).step_by(pixels_a_batch as usize) {
                batches.push(Batch {
                    first_pixel: pixel,
                    pixel_count: pixels_a_batch.min(pixels - pixel),
                    first_sample: first_sample + sample,
                    sample_count: samples_a_batch.min(samples - sample),
                    ..template
                });
            }
        }
        batches
    }

    /// Fills the queue with the first rays of a batch.
    pub(crate) fn start(
        &mut self,
        context: &Context,
        batch: &Batch,
        first_rays: &Bound,
    ) -> Result<wgpu::CommandEncoder, DeviceError> {
        self.buffers.write(context, "batch", bytemuck::bytes_of(batch))?;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let paths = batch.pixel_count * batch.sample_count;
        self.started = paths;
        record(&mut encoder, &mut self.timing, first_rays, Extent::Count(paths));
        record(&mut encoder, &mut self.timing, &self.advance, Extent::Count(1));
        Ok(encoder)
    }

    /// Records stages one after the other.
    pub(crate) fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stages: &[Stage],
    ) -> Result<(), DeviceError> {
        let arguments = self.buffers.get("arguments")?;
        for stage in stages {
            let extent = match stage.size {
                Size::Count(count) => Extent::Count(count),
                Size::Paths => Extent::Indirect(arguments, 0),
                Size::Shadow => Extent::Indirect(arguments, 16),
                Size::Cells => Extent::Indirect(arguments, 32),
            };
            record(encoder, &mut self.timing, &stage.kernel, extent);
        }
        Ok(())
    }

    /// Bounces until no path is left, but `max_bounces` at most. What `encoder` holds goes before.
    pub(crate) fn bounce(
        &mut self,
        context: &Context,
        mut encoder: wgpu::CommandEncoder,
        stages: &Bounce,
        max_bounces: u32,
    ) -> Result<(), DeviceError> {
        let mut depth = 0;
        loop {
            let start = Instant::now();
            for _ in 0..BOUNCES_A_SUBMISSION.min(max_bounces - depth) {
                self.record(&mut encoder, &stages[depth as usize % 2])?;
                depth += 1;
            }
            context.queue.submit([encoder.finish()]);
            encoder = context.device.create_command_encoder(&Default::default());
            if let Some(timing) = self.timing.as_mut().filter(|timing| timing.is_filling()) {
                timing.collect(context)?;
            }
            let counts = self.counts(context)?;
            if depth <= BOUNCES_A_SUBMISSION {
                self.pace(start.elapsed())?;
            }
            if depth >= max_bounces || counts.paths_in == 0 {
                return Ok(());
            }
        }
    }

    /// Adds a batch to the film.
    pub(crate) fn accumulate(&mut self, context: &Context, batch: &Batch) -> Result<(), DeviceError> {
        let stage = Stage::new(&self.accumulate, Size::Count(batch.pixel_count));
        self.submit(context, &[stage])
    }

    /// Submits stages on their own.
    pub(crate) fn submit(&mut self, context: &Context, stages: &[Stage]) -> Result<(), DeviceError> {
        let mut encoder = context.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, stages)?;
        context.queue.submit([encoder.finish()]);
        Ok(())
    }

    pub(crate) fn counts(&self, context: &Context) -> Result<Counts, DeviceError> {
        let bytes = self.buffers.read(context, "counts", size_of::<Counts>() as u64)?;
        Ok(bytemuck::pod_read_unaligned(&bytes))
    }

    /// What was done so far; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn ray_counts(&self, context: &Context) -> Result<RayCounts, DeviceError> {
        let counts = self.counts(context)?;
        Ok(RayCounts {
            closest_hit: total(counts.closest_total) - self.aside,
            occlusion: total(counts.shadow_total),
            non_finite_vertices: counts.non_finite_vertices.into(),
            ..self.light_counts
        })
    }

    /// The film's sums since they were last taken; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn film(&self, context: &Context) -> Result<Vec<FilmPixel>, DeviceError> {
        let bytes = u64::from(self.settings.view.region().pixels()) * size_of::<FilmPixel>() as u64;
        Ok(bytemuck::pod_collect_to_vec(&self.buffers.read(context, "film", bytes)?))
    }

    /// Takes the film's sums and sets them to zero; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn take_film(&self, context: &Context) -> Result<Vec<FilmPixel>, DeviceError> {
        let film = self.film(context)?;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(self.buffers.get("film")?, 0, None);
        context.queue.submit([encoder.finish()]);
        Ok(film)
    }

    /// Reads what was timed and not read yet.
    ///
    /// # Errors
    /// A lost device.
    pub fn collect_times(&mut self, context: &Context) -> Result<(), DeviceError> {
        self.timing.as_mut().map_or(Ok(()), |timing| timing.collect(context))
    }

    /// Seconds and dispatches by kernel, where timed, as far as they are [collected](Self::collect_times).
    pub fn kernel_times(&self) -> BTreeMap<String, (f64, u64)> {
        self.timing.as_ref().map(|timing| timing.totals.clone()).unwrap_or_default()
    }
}

/// Seven words a pixel: `shaders/bind/splats.wgsl`.
const SPLAT_BYTES: u64 = 28;
/// Sets the numbers of light paths apart from those of eye paths.
const LIGHT_STREAM: u32 = 0x9e37_79b9;

/// A total of the device.
pub(crate) fn total(words: [u32; 2]) -> u64 {
    u64::from(words[0]) | u64::from(words[1]) << 32
}

fn bind_pair(
    context: &Context,
    buffers: &mut BufferTable,
    swapped: &[(&'static str, [wgpu::Buffer; 2])],
    kernel: &Kernel,
) -> Result<[Bound; 2], DeviceError> {
    let mut bind = |read: usize| {
        for (name, pair) in swapped {
            buffers.share(&format!("{name}_in"), pair[read].clone());
            buffers.share(&format!("{name}_out"), pair[1 - read].clone());
        }
        let bound = kernel.bind(context, buffers);
        for (name, _) in swapped {
            buffers.unshare(&format!("{name}_in"));
            buffers.unshare(&format!("{name}_out"));
        }
        bound
    };
    Ok([bind(0)?, bind(1)?])
}

/// A [`Size`] as the encoder wants it: an offset in bytes where the device decides.
pub(crate) enum Extent<'a> {
    Count(u32),
    Indirect(&'a wgpu::Buffer, u64),
}

pub(crate) fn record(
    encoder: &mut wgpu::CommandEncoder,
    timing: &mut Option<Timing>,
    kernel: &Bound,
    extent: Extent,
) {
    let timestamp_writes = timing.as_mut().and_then(|timing| timing.writes(&kernel.name));
    let mut pass = encoder
        .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(&kernel.name), timestamp_writes });
    match extent {
        Extent::Count(invocations) => kernel.dispatch(&mut pass, invocations),
        Extent::Indirect(arguments, offset) => kernel.dispatch_indirect(&mut pass, arguments, offset),
    }
}
