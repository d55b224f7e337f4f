//! The unidirectional path tracer: next-event estimation and BSDF sampling, combined by the balance heuristic.
//! Plain on purpose; it judges the others.

use crate::device::layout::{Batch, Camera};
use crate::device::scene::DeviceScene;
use crate::device::{Context, DeviceError};

use super::wavefront::{Bounces, Form, Size, Stage, Wavefront};
use super::{Integrator, Settings};

/// See the module.
pub struct PathIntegrator {
    wavefront: Wavefront,
    bounces: Bounces,
}

impl PathIntegrator {
    /// Compiles the kernels for the scene and takes over its buffers.
    ///
    /// # Errors
    /// A kernel that does not compile, a buffer that does not fit.
    pub fn new(
        context: &Context,
        scene: DeviceScene,
        camera: &Camera,
        settings: Settings,
    ) -> Result<Self, DeviceError> {
        let form = Form { connections: 1, ..Form::default() };
        let mut wavefront = Wavefront::new(context, scene, camera, settings, form)?;
        let kernel = wavefront.compile(context, "path_shade", wavefront.sky_features())?;
        let shade = wavefront.bind_pair(context, &kernel)?;
        let bounce = |parity: usize| {
            let mut stages = vec![
                Stage::new(&wavefront.closest_hit[parity], Size::Paths),
                Stage::new(&shade[parity], Size::Paths),
                Stage::new(&wavefront.advance, Size::Count(1)),
            ];
            stages.extend(wavefront.test_connections.iter().cloned());
            stages
        };
        let bounces = [bounce(0), bounce(1)].into();
        Ok(Self { wavefront, bounces })
    }

    fn trace(&mut self, context: &Context, batch: &Batch) -> Result<(), DeviceError> {
        let first_rays = self.wavefront.camera_rays.clone();
        let encoder = self.wavefront.start(context, batch, &first_rays)?;
        self.wavefront.bounce(context, encoder, &self.bounces, batch.max_depth)?;
        self.wavefront.accumulate(context, batch)
    }
}

impl Integrator for PathIntegrator {
    fn render(&mut self, context: &Context, first_sample: u32, samples: u32) -> Result<(), DeviceError> {
        for batch in self.wavefront.batches(first_sample, samples) {
            self.trace(context, &batch)?;
        }
        Ok(())
    }

    fn warm_up(&mut self, context: &Context) -> Result<(), DeviceError> {
        self.trace(context, &self.wavefront.tiny_batch())
    }

    fn wavefront(&self) -> &Wavefront {
        &self.wavefront
    }

    fn wavefront_mut(&mut self) -> &mut Wavefront {
        &mut self.wavefront
    }
}
