//! How many of a scene's rays a device traces per second.

use std::time::Instant;

use serde::Serialize;

use crate::accel::{Accel, arranged};
use crate::device::layout::Camera;
use crate::device::scene::DeviceScene;
use crate::device::{Context, Feature, Traversal};
use crate::render::RenderError;
use crate::render::rays::{RaySet, RayTracer, further_rays, primary_rays};
use crate::render::tracing::settle;
use crate::scene::{Scene, SceneFeatures};

/// A measured rate.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rate {
    pub hits: u64,
    pub mrays_per_second: f64,
    /// `None` where the driver traces, which does not tell.
    pub work: Option<Work>,
}

/// What the traversal of a set of rays looks at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Work {
    pub nodes_per_ray: f64,
    pub triangles_per_ray: f64,
    /// Of the lanes of a subgroup that go along while its longest ray looks at nodes, those with a ray of their own that does.
    pub live_lanes: f64,
    pub lanes: u32,
}

impl Work {
    /// Of rays that looked at so many nodes and triangles each; subgroups have so many `lanes`, which take neighbours.
    pub fn of(counts: &[[u32; 2]], lanes: u32) -> Self {
        let sum = |which: usize| counts.iter().map(|count| f64::from(count[which])).sum::<f64>();
        let longest = |group: &[[u32; 2]]| f64::from(group.iter().map(|count| count[0]).max().unwrap_or(0));
        let steps: f64 = counts.chunks(lanes as usize).map(longest).sum();
        let rays = counts.len().max(1) as f64;
        Self {
            nodes_per_ray: sum(0) / rays,
            triangles_per_ray: sum(1) / rays,
            live_lanes: if steps > 0.0 { sum(0) / steps } else { 0.0 },
            lanes,
        }
    }
}

/// The rays of a scene and the kernels that trace them.
pub struct RayBench {
    pub sets: Vec<RaySet>,
    /// What traces them.
    pub traversal: Traversal,
    accel: Accel,
    tracer: RayTracer,
    /// Traces by kernels that count.
    counter: Option<RayTracer>,
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
        let counter = match traversal {
            Traversal::Hardware => None,
            _ => {
                Some(RayTracer::new(context, &device_scene, &[Feature::Counted], primary.rays.len() as u64)?)
            }
        };
        Ok(Self { sets: vec![primary, bounce, shadow], traversal, accel, tracer, counter })
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
        let counts = self.counter.as_ref().map(|counter| counter.counts(context, set)).transpose()?;
        let work = counts.map(|counts| Work::of(&counts, context.subgroup_lanes()));
        let start = Instant::now();
        let mut rounds = 0u32;
        while rounds == 0 || start.elapsed().as_secs_f64() < seconds {
            self.tracer.dispatch(context, set)?;
            rounds += 1;
        }
        let traced = f64::from(rounds) * set.rays.len() as f64;
        Ok(Rate { hits: hits as u64, mrays_per_second: traced / start.elapsed().as_secs_f64() * 1e-6, work })
    }
}
