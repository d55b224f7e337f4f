//! The queues between kernels, and the loop over the surfaces of a batch of paths. An integrator says which stages a
//! bounce has.

mod bounces;
mod film_pages;
mod first_hits;
mod kernels;
mod queues;
pub mod submission;

use std::collections::BTreeMap;

use super::kernels::forms;
use super::{LightPaths, Settings, Strategy};
use crate::device::layout::{Camera, Counts, FilmPixel};
use crate::device::scene::DeviceScene;
use crate::device::timing::Timing;
use crate::device::{Bound, BufferTable, Context, DeviceError, Kernel};
use crate::film::Region;
use film_pages::{FILM, FilmPages};
use kernels::{Compiler, SharedKernels, bind_pair};
use queues::Swapped;
use submission::Pace;

pub(crate) use bounces::{Bounces, Extent, Size, Stage, record};
pub(crate) use film_pages::SPLAT_WORDS;
pub(crate) use kernels::Form;
pub use queues::RayCounts;
pub(crate) use queues::total;

/// Kernels and queues of a path-space wavefront.
pub struct Wavefront {
    pub buffers: BufferTable,
    pub(crate) settings: Settings,
    pub(crate) capacity: u32,
    pace: Pace,
    /// Paths in flight at once, the capacity at most.
    pub(crate) slice: u32,
    /// Paths of the batch that is under way.
    pub(crate) started: u32,
    /// Eye and light paths so far.
    paths: u64,
    /// Samples of pixels that have reached the film, since the caller last set this to zero.
    pub(crate) accumulated: u64,
    compiler: Compiler,
    swapped: Swapped,
    pub(crate) camera_rays: Bound,
    pub(crate) closest_hit: [Bound; 2],
    pub(crate) advance: Bound,
    tests: Option<[Kernel; 2]>,
    /// Tests the connections in the queue; none where nothing connects.
    pub(crate) test_connections: Vec<Stage>,
    pages: FilmPages,
    /// For each page.
    accumulate: Vec<Bound>,
    pub(crate) first_hit: Vec<Bound>,
    mirror_follow: Option<Bound>,
    pub timing: Option<Timing>,
    /// What the device does not count apart.
    pub(crate) light_counts: RayCounts,
    /// Rays of the device's counts that no picture is made of.
    pub(crate) aside: u64,
    /// K, subspaces a side.
    pub(crate) subspaces: u32,
    /// See `shaders/bind/batch.wgsl`.
    pub(crate) splat_scale: f32,
    /// The first sample of the iteration whose light paths are in the cache, and have reached the camera, with what was
    /// counted then; `None`: they are none's.
    pub(crate) light_at_hand: Option<(u32, Counts)>,
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
        let scene_features = scene.kernel_features();
        let plan = settings.method.plan();
        let mut features = scene_features;
        features.extend(form.features());
        debug_assert!(forms(&plan, scene_features).contains(&features), "{features:?}");
        let mut constants = std::mem::take(&mut scene.constants);
        constants.push(("CONNECTIONS_IN_FLIGHT", f64::from(form.connections)));
        constants.push(("ROULETTE_CAP", f64::from(settings.view.roulette_cap)));
        let mut buffers = std::mem::take(&mut scene.buffers);
        let pixels = settings.view.region().pixels();
        let pages = FilmPages::create(context, &mut buffers, pixels, form.splats, settings.first_hit)?;
        let mut compiler = Compiler { plan, features, constants, names: Vec::new() };
        let kernels = SharedKernels::new(context, &mut compiler, &settings, &pages)?;

        let connects = kernels.tests.is_some();
        let shared = match plan.light_paths {
            // Their vertices fill the cache before there is room for more paths.
            LightPaths::OnePerEyePath => 0,
            _ => settings.view.width.saturating_mul(settings.view.height),
        };
        let capacity = queues::capacity(context, form.connections, shared);
        let swapped = queues::create(context, &mut buffers, camera, &form, capacity, connects)?;
        let [camera_rays, _] = bind_pair(context, &mut buffers, &swapped, &kernels.camera_rays)?;
        let closest_hit = bind_pair(context, &mut buffers, &swapped, &kernels.closest_hit)?;
        let advance = kernels.advance.bind(context, &buffers)?;
        let accumulate = pages.bind(&mut buffers, |buffers| kernels.accumulate.bind(context, buffers))?;
        let bind_first = |kernel: &Kernel, buffers: &mut BufferTable| {
            bind_pair(context, buffers, &swapped, kernel).map(|[first, _]| first)
        };
        let first_hit = match &kernels.first_hit {
            Some(kernel) => pages.bind(&mut buffers, |buffers| bind_first(kernel, buffers))?,
            None => Vec::new(),
        };
        let mirror_follow =
            kernels.mirror_follow.map(|kernel| bind_first(&kernel, &mut buffers)).transpose()?;
        let mut wavefront = Self {
            buffers,
            settings,
            capacity,
            pace: Pace::default(),
            slice: capacity,
            started: 0,
            paths: 0,
            accumulated: 0,
            compiler,
            swapped,
            camera_rays,
            closest_hit,
            advance,
            tests: kernels.tests,
            test_connections: Vec::new(),
            pages,
            accumulate,
            first_hit,
            mirror_follow,
            timing: if settings.timing { Timing::new(context) } else { None },
            light_counts: RayCounts::default(),
            aside: 0,
            subspaces: 0,
            splat_scale: 1.0,
            light_at_hand: None,
        };
        wavefront.bind_tests(context)?;
        Ok(wavefront)
    }

    /// The kernels that were compiled so far, in order.
    pub fn compiled(&self) -> &[String] {
        &self.compiler.names
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
        self.light_at_hand = None;
        self.buffers.write(context, "camera", bytemuck::bytes_of(camera))
    }

    /// From now on renders with this seed, and of all strategies this one only.
    pub fn choose(&mut self, seed: u64, strategy: Option<Strategy>) {
        self.light_at_hand = None;
        self.settings.view.seed = seed;
        self.settings.strategy = strategy;
    }

    /// Forgets all that was rendered and counted.
    ///
    /// # Errors
    /// A lost device.
    pub fn reset(&mut self, context: &Context) -> Result<(), DeviceError> {
        let mut encoder = context.device.create_command_encoder(&Default::default());
        self.clear(FILM, &mut encoder);
        self.light_at_hand = None;
        encoder.clear_buffer(self.buffers.get("counts")?, 0, None);
        context.queue.submit([encoder.finish()]);
        self.light_counts = RayCounts::default();
        self.aside = 0;
        self.paths = 0;
        if let Some(timing) = &mut self.timing {
            timing.clear();
        }
        context.wait()
    }

    /// After [`DeviceError::Abandoned`]: forgets the paths under way, so that the next batch begins as any other. `film`: the
    /// sums before the samples that were abandoned (empty: none), where parts of those may have reached it.
    ///
    /// # Errors
    /// A lost device.
    pub(crate) fn drop_unfinished(
        &mut self,
        context: &Context,
        film: Option<&[FilmPixel]>,
    ) -> Result<(), DeviceError> {
        let mut encoder = context.device.create_command_encoder(&Default::default());
        match film {
            Some([]) => self.clear(FILM, &mut encoder),
            Some(film) => self.write_film(context, film)?,
            None => {}
        }
        self.light_at_hand = None;
        // The lengths of queues, not the totals.
        let lengths = std::mem::offset_of!(Counts, closest_total) as u64;
        encoder.clear_buffer(self.buffers.get("counts")?, 0, Some(lengths));
        context.queue.submit([encoder.finish()]);
        context.wait()
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
