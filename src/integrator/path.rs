//! The unidirectional path tracer: next-event estimation and BSDF sampling, combined by the balance heuristic.
//! Plain on purpose; it judges the others.

use crate::device::Context;
use crate::device::layout::Camera;
use crate::device::scene::DeviceScene;
use crate::error::DeviceError;

use super::Settings;
use super::wavefront::Wavefront;

/// Paths in flight on a software device: enough to hide the tail of a batch, few enough to stay in its caches and
/// to keep a dispatch near 100 ms.
const CPU_CAPACITY: u32 = 1 << 16;
/// Paths in flight on a GPU.
const GPU_CAPACITY: u32 = 1 << 20;

/// See the module.
pub struct PathIntegrator {
    pub wavefront: Wavefront,
}

impl PathIntegrator {
    /// Compiles the kernels for the scene and takes over its buffers.
    ///
    /// # Errors
    /// A kernel that does not compile, a buffer that does not fit.
    pub fn new(
        context: &Context,
        mut scene: DeviceScene,
        camera: &Camera,
        settings: Settings,
    ) -> Result<Self, DeviceError> {
        let capacity = if context.is_cpu() { CPU_CAPACITY } else { GPU_CAPACITY };
        let wavefront = Wavefront::new(context, &mut scene, camera, settings, capacity, "path_shade")?;
        Ok(Self { wavefront })
    }
}
