//! The kernels that all integrators share, and what they and those of an integrator are compiled with.

use super::film_pages::FilmPages;
use super::{Size, Stage, Wavefront};
use crate::device::layout::{EyeLink, LambertVertex, LightVertex, RecordLink};
use crate::device::{Bound, BufferTable, Context, DeviceError, Feature, Features, Kernel};
use crate::integrator::kernels::kernels;
use crate::integrator::{Plan, Settings};

/// What a wavefront is made for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Form {
    /// Connections that a path may have in flight.
    pub connections: u32,
    /// Rays carry what bidirectional weights need.
    pub bidirectional: bool,
    /// Light paths add to the film.
    pub splats: bool,
    /// Vertices are classified into subspaces.
    pub subspaces: bool,
    /// Directions count in the classification.
    pub subspace_directions: bool,
    /// Weights know of records.
    pub resampling: bool,
    /// They know what light vertices bring to each.
    pub at_records: bool,
    /// Narrow lobes are connected less often.
    pub thinning: bool,
    /// Samples are independent of each other.
    pub independent: bool,
    /// Paths are written down, for the host to learn from.
    pub learns: bool,
    /// Light vertices are those of `LambertVertex`.
    pub lambert_vertices: bool,
}

impl Form {
    /// What all kernels of the wavefront are compiled with, beside what the scene and the device want.
    pub(super) fn features(&self) -> impl Iterator<Item = Feature> {
        [
            (Feature::Bidirectional, self.bidirectional),
            (Feature::Splats, self.splats),
            (Feature::Subspaces, self.subspaces),
            (Feature::SubspaceDirections, self.subspace_directions),
            (Feature::Resampling, self.resampling),
            (Feature::AtRecords, self.at_records),
            (Feature::Thinning, self.thinning),
            (Feature::Independent, self.independent),
            (Feature::Learns, self.learns),
            (Feature::LambertVertices, self.lambert_vertices),
        ]
        .into_iter()
        .filter_map(|(feature, on)| on.then_some(feature))
    }
}

/// What kernels are compiled with.
pub(super) struct Compiler {
    pub plan: Plan,
    pub features: Features,
    pub constants: Vec<(&'static str, f64)>,
    /// Of all kernels so far.
    pub names: Vec<String>,
}

impl Compiler {
    /// With features beside those of the scene.
    pub fn compile(
        &mut self,
        context: &Context,
        name: &str,
        extra: &[Feature],
    ) -> Result<Kernel, DeviceError> {
        let features = self.features.with(extra);
        debug_assert!(
            kernels(&self.plan, self.features).contains(&(name, features)),
            "{name} with {features:?} is not among the kernels that tests look at"
        );
        let kernel = Kernel::new(context, name, features, &self.constants)?;
        self.names.push(name.to_string());
        Ok(kernel)
    }
}

/// Compiled once, before there are buffers.
pub(super) struct SharedKernels {
    pub camera_rays: Kernel,
    pub closest_hit: Kernel,
    pub advance: Kernel,
    /// Tests of connections; none where nothing connects.
    pub tests: Option<[Kernel; 2]>,
    pub accumulate: Kernel,
    pub first_hit: Option<Kernel>,
    pub mirror_follow: Option<Kernel>,
}

impl SharedKernels {
    pub fn new(
        context: &Context,
        compiler: &mut Compiler,
        settings: &Settings,
        pages: &FilmPages,
    ) -> Result<Self, DeviceError> {
        let connects = compiler.features.contains(Feature::Lights);
        let follows = settings.first_hit && settings.through_mirrors;
        let mut compile = |name: &str, extra: &[Feature]| compiler.compile(context, name, extra);
        Ok(Self {
            camera_rays: compile("camera_rays", &[])?,
            closest_hit: compile("closest_hit", &[])?,
            advance: compile("queue_advance", &[])?,
            tests: match connects {
                true => Some([compile("shadow_advance", &[])?, compile("occlusion", &[Feature::AnyHit])?]),
                false => None,
            },
            accumulate: compile("film_accumulate", pages.features())?,
            first_hit: match settings.first_hit {
                true => {
                    let mut features = pages.features().to_vec();
                    features.extend(follows.then_some(Feature::ThroughMirrors));
                    Some(compile("first_hit", &features)?)
                }
                false => None,
            },
            mirror_follow: if follows { Some(compile("mirror_follow", &[])?) } else { None },
        })
    }
}

impl Wavefront {
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

    /// Something in the scene can be sampled as a light.
    pub(crate) fn has_lights(&self) -> bool {
        self.compiler.features.contains(Feature::Lights)
    }

    /// The device runs the invocations of a workgroup one after the other.
    pub(crate) fn is_software(&self) -> bool {
        self.compiler.features.contains(Feature::Software)
    }

    /// What kernels that meet the environment are compiled with.
    pub(crate) fn sky_features(&self) -> &'static [Feature] {
        let unseen = self.settings.transparent && self.compiler.features.contains(Feature::Environment);
        if unseen { &[Feature::Transparent] } else { &[] }
    }

    /// Kernels write down the paths that they find.
    pub(crate) fn learns(&self) -> bool {
        self.compiler.features.contains(Feature::Learns)
    }

    /// Bytes of a vertex of the light cache.
    pub(crate) fn light_vertex_bytes(&self) -> u64 {
        match self.compiler.features.contains(Feature::LambertVertices) {
            true => size_of::<LambertVertex>() as u64,
            false => size_of::<LightVertex>() as u64,
        }
    }

    /// Bytes of a vertex in the lists of eye paths.
    pub(super) fn eye_link_bytes(&self) -> u64 {
        match self.compiler.features.contains(Feature::AtRecords) {
            true => size_of::<RecordLink>() as u64,
            false => size_of::<EyeLink>() as u64,
        }
    }

    /// Masked or blended surfaces make every traversal draw numbers of its path.
    pub(crate) fn has_alpha(&self) -> bool {
        self.compiler.features.contains(Feature::Alpha)
    }

    /// Compiles a kernel of an integrator, with features beside those of the scene.
    ///
    /// # Errors
    /// A kernel that does not compile.
    pub(crate) fn compile(
        &mut self,
        context: &Context,
        name: &str,
        extra: &[Feature],
    ) -> Result<Kernel, DeviceError> {
        self.compiler.compile(context, name, extra)
    }

    /// What kernels that see a page of the film are compiled with.
    pub(crate) fn page_features(&self) -> &'static [Feature] {
        self.pages.features()
    }

    /// Binds a kernel to each page of the film in turn.
    ///
    /// # Errors
    /// A buffer that is missing.
    pub(crate) fn bind_pages(
        &mut self,
        context: &Context,
        kernel: &Kernel,
    ) -> Result<Vec<Bound>, DeviceError> {
        self.pages.bind(&mut self.buffers, |buffers| kernel.bind(context, buffers))
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
}

pub(super) fn bind_pair(
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
