//! The kernels of bidirectional methods, and the stages that they make.

use super::Bidirectional;
use crate::device::{Bound, Context, DeviceError, Feature, Kernel};
use crate::integrator::kernels::{light_features, nominal_features};
use crate::integrator::wavefront::{Bounces, Size, Stage, Wavefront};
use crate::integrator::{Plan, Weights};

/// Compiled once.
pub(super) struct Kernels {
    /// `None` where there is nothing to sample as a light.
    pub light: Option<LightKernels>,
    /// Shading of eye paths; none in light tracing.
    pub eye_shade: Option<Kernel>,
}

pub(super) struct LightKernels {
    pub rays: Kernel,
    pub shade: Kernel,
    /// Where a traversal draws numbers, those of light paths are others.
    pub closest_hit: Option<Kernel>,
    /// Where weights know what light vertices bring to records.
    pub edges: Option<Kernel>,
    /// Connects to the camera, and tests these connections; adds them to the pages of the film where it has several.
    pub camera: Option<[Kernel; 2]>,
    pub splat_page: Option<Kernel>,
    pub cache: Option<CacheKernels>,
}

pub(super) struct CacheKernels {
    pub scan: Kernel,
    pub order: Kernel,
    pub connections: Kernel,
}

/// The kernels with their buffers: bound again when the cache grows or another model comes.
#[derive(Default)]
pub(super) struct Stages {
    pub light_rays: Option<Bound>,
    /// Of light paths, with connections to the camera and without.
    pub light_bounce: Bounces,
    pub quiet_light_bounce: Bounces,
    pub camera_tests: Vec<Stage>,
    pub sort: Vec<Stage>,
    pub connect: Option<[Bound; 2]>,
    pub eye_shade: Option<[Bound; 2]>,
}

impl Kernels {
    /// Light paths only where there is `lights` to start them from; `guide`: they are guided.
    pub fn new(
        context: &Context,
        wavefront: &mut Wavefront,
        plan: &Plan,
        lights: bool,
        guide: bool,
    ) -> Result<Self, DeviceError> {
        Ok(Self {
            light: if lights { Some(LightKernels::new(context, wavefront, plan, guide)?) } else { None },
            eye_shade: match plan.selector {
                Some(_) => Some(wavefront.compile(context, "eye_shade", wavefront.sky_features())?),
                None => None,
            },
        })
    }
}

impl LightKernels {
    fn new(
        context: &Context,
        wavefront: &mut Wavefront,
        plan: &Plan,
        guide: bool,
    ) -> Result<Self, DeviceError> {
        let features = light_features(plan);
        let nominal = if guide { nominal_features(plan) } else { &[] };
        let mut guided = features.clone();
        guided.extend(guide.then_some(Feature::LightGuide));
        guided.extend(nominal);
        let closest_hit = match wavefront.has_alpha() {
            true => Some(wavefront.compile(context, "closest_hit", &features)?),
            false => None,
        };
        let edges = match plan.weights == Weights::AtRecords {
            true => Some(wavefront.compile(context, "light_edges", &[Feature::AnyHit])?),
            false => None,
        };
        let mut splat_features = features.clone();
        splat_features.extend([Feature::AnyHit, Feature::SplatsAtomic]);
        splat_features.extend(wavefront.page_features());
        let camera = match plan.to_camera {
            true => Some([
                wavefront.compile(context, "camera_connections", &features)?,
                wavefront.compile(context, "occlusion", &splat_features)?,
            ]),
            false => None,
        };
        let splat_page = match plan.to_camera && !wavefront.page_features().is_empty() {
            true => Some(wavefront.compile(context, "splat_page", &splat_features)?),
            false => None,
        };
        let cache = match plan.selector {
            None => None,
            Some(selector) => Some(CacheKernels {
                scan: wavefront.compile(context, "light_scan", &[])?,
                order: wavefront.compile(context, "light_order", &[])?,
                connections: wavefront.compile(
                    context,
                    "light_connections",
                    &[selector.features(), nominal].concat(),
                )?,
            }),
        };
        Ok(Self {
            rays: wavefront.compile(context, "light_rays", &guided)?,
            shade: wavefront.compile(context, "light_shade", &guided)?,
            closest_hit,
            edges,
            camera,
            splat_page,
            cache,
        })
    }
}

impl Bidirectional {
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
        let edges = match &kernels.edges {
            Some(kernel) => Some(wavefront.bind_pair(context, kernel)?),
            None => None,
        };
        let mut camera = None;
        if let Some([connections, occlusion]) = &kernels.camera {
            camera = Some(wavefront.bind_pair(context, connections)?);
            stages.camera_tests = vec![
                wavefront.test_connections[0].clone(),
                Stage::new(&occlusion.bind(context, &wavefront.buffers)?, Size::Shadow),
            ];
        }
        if let Some(kernel) = &kernels.splat_page {
            let pages = wavefront.bind_pages(context, kernel)?;
            stages.camera_tests.extend(pages.iter().map(|page| Stage::new(page, Size::Shadow)));
        }
        let bounce = |connects: bool, parity: usize| {
            let mut bounce = vec![Stage::new(&closest_hit[parity], Size::Paths)];
            bounce.extend(edges.iter().map(|edges| Stage::new(&edges[parity], Size::Paths)));
            if let (true, Some(camera)) = (connects, &camera) {
                bounce.push(Stage::new(&camera[parity], Size::Paths));
                bounce.extend(stages.camera_tests.iter().cloned());
            }
            bounce.push(Stage::new(&shade[parity], Size::Paths));
            bounce.push(Stage::new(&wavefront.advance, Size::Count(1)));
            bounce
        };
        stages.light_bounce = [0, 1].map(|parity| bounce(true, parity)).into();
        stages.quiet_light_bounce = [0, 1].map(|parity| bounce(false, parity)).into();
        if let Some(cache) = &kernels.cache {
            stages.sort = vec![
                Stage::new(&cache.scan.bind(context, &wavefront.buffers)?, Size::Count(1)),
                Stage::new(&cache.order.bind(context, &wavefront.buffers)?, Size::Count(self.capacity)),
            ];
            stages.connect = Some(wavefront.bind_pair(context, &cache.connections)?);
        }
        if let (Some(records), Some(eye_shade)) = (&mut self.records, &stages.eye_shade) {
            records.bind(context, wavefront, eye_shade)?;
        }
        if let Some(subspaces) = &self.subspaces {
            stages.sort.extend(subspaces.sort.iter().cloned());
        }
        self.stages = stages;
        Ok(())
    }
}
