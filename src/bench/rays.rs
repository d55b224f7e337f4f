//! How many of a scene's rays a device traces per second.

use std::time::Instant;

use serde::Serialize;

use crate::accel::{Accel, arranged};
use crate::device::layout::Camera;
use crate::device::scene::DeviceScene;
use crate::device::{Context, Traversal};
use crate::render::RenderError;
use crate::render::rays::{RaySet, RayTracer, further_rays, primary_rays};
use crate::render::tracing::settle;
use crate::scene::{Scene, SceneFeatures};

/// A measured rate.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rate {
    pub hits: u64,
    pub mrays_per_second: f64,
}

/// The rays of a scene and the kernels that trace them.
pub struct RayBench {
    pub sets: Vec<RaySet>,
    /// What traces them.
    pub traversal: Traversal,
    accel: Accel,
    tracer: RayTracer,
}

impl RayBench {
    /// One primary ray through each pixel's centre, a diffuse bounce where it hits, and from there a shadow ray to
    /// where another one hit.
    ///
    /// # Errors
    /// What the layers below report.
    pub fn new(context: &Context, scene: &Scene, camera: usize, size: [u32; 2]) -> Result<Self, RenderError> {
        let scene = &*arranged(scene);
        let accel = Accel::build(scene)?;
        // Materials and lights do not matter to rays; alpha would.
        let features = SceneFeatures { alpha: false, ..SceneFeatures::of(scene) };
        let mut device_scene = DeviceScene::new(context, scene, &accel, features)?;
        settle(context, &mut device_scene, scene, &accel)?;
        let [width, height] = size;
        let primary =
            primary_rays(&Camera::new(&device_scene.unit, &scene.cameras[camera], width, height), size);
        let tracer = RayTracer::new(context, &device_scene, &[], primary.rays.len() as u64)?;
        let [bounce, shadow] = further_rays(&accel, &primary, &tracer.hits(context, &primary)?);
        let traversal = device_scene.traversal();
        Ok(Self { sets: vec![primary, bounce, shadow], traversal, accel, tracer })
    }

    /// Nine numbers per triangle: its vertices.
    pub fn triangles(&self) -> Vec<f32> {
        self.accel
            .numbers()
            .flat_map(|number| self.accel.triangle_at(number).vertices)
            .flat_map(|v| v.to_array())
            .collect()
    }

    /// Traces a set over and over for about `seconds`, after one round that does not count.
    ///
    /// # Errors
    /// A lost device.
    pub fn measure(&mut self, context: &Context, set: usize, seconds: f64) -> Result<Rate, RenderError> {
        let set = &self.sets[set];
        let hits = match set.any_hit {
            true => self.tracer.occluded(context, set)?.into_iter().filter(|&hit| hit).count(),
            false => self.tracer.hits(context, set)?.iter().filter(|hit| hit.triangle != u32::MAX).count(),
        };
        let start = Instant::now();
        let mut rounds = 0u32;
        while rounds == 0 || start.elapsed().as_secs_f64() < seconds {
            self.tracer.dispatch(context, set)?;
            rounds += 1;
        }
        let traced = f64::from(rounds) * set.rays.len() as f64;
        Ok(Rate { hits: hits as u64, mrays_per_second: traced / start.elapsed().as_secs_f64() * 1e-6 })
    }
}
