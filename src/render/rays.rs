//! Rays of the three kinds that renderers trace, apart from any picture: to measure what traces them.

use std::time::Instant;

use glam::Vec3;

use super::RenderError;
use crate::accel::{Accel, AccelTriangle};
use crate::device::layout::{Camera, Counts, Hit, PathRay, ShadowRay};
use crate::device::scene::DeviceScene;
use crate::device::{Bound, BufferTable, Context, Feature, Features, Kernel};
use crate::math::frame::Frame;
use crate::math::rng::{RandomKey, uniform4};
use crate::math::sampling::sample_cosine_hemisphere;

/// A ray in unit space; it ends at `t_max` times its direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TestRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub t_max: f32,
}

/// Rays of one kind, `primary`, `bounce` or `shadow`. Shadow rays ask for any hit, the others for the closest.
pub struct RaySet {
    pub name: &'static str,
    pub rays: Vec<TestRay>,
    pub any_hit: bool,
}

/// The kernels that trace rays of a scene, and their queues.
pub struct RayTracer {
    buffers: BufferTable,
    closest_hit: Bound,
    occlusion: Bound,
}

impl RayTracer {
    /// For sets of so many rays at most, which meet all surfaces, masked ones as well.
    ///
    /// # Errors
    /// A kernel that does not compile, a buffer that does not fit.
    pub fn new(
        context: &Context,
        scene: &DeviceScene,
        more: &[Feature],
        most_rays: u64,
    ) -> Result<Self, RenderError> {
        // Paths have numbers for alpha, these rays have not.
        let features = scene.kernel_features().with(more).without(Feature::Alpha);
        let compile = |name: &str, features: Features| Kernel::new(context, name, features, &scene.constants);
        let closest_hit = compile("closest_hit", features)?;
        let occlusion = compile("occlusion", features.with(&[Feature::AnyHit]))?;
        let mut buffers = scene.buffers.clone();
        buffers.create(context, "paths_in", most_rays * size_of::<PathRay>() as u64)?;
        buffers.create(context, "hits", most_rays * size_of::<Hit>() as u64)?;
        buffers.create(context, "shadow_rays", most_rays * size_of::<ShadowRay>() as u64)?;
        buffers.create(context, "radiance", most_rays * 16)?;
        buffers.create(context, "counts", size_of::<Counts>() as u64)?;
        if more.contains(&Feature::Counted) {
            buffers.create(context, "ray_counts", most_rays * 8)?;
        }
        let closest_hit = closest_hit.bind(context, &buffers)?;
        let occlusion = occlusion.bind(context, &buffers)?;
        Ok(Self { buffers, closest_hit, occlusion })
    }

    /// Puts a set into the queues.
    ///
    /// # Errors
    /// A lost device.
    pub fn load(&self, context: &Context, set: &RaySet) -> Result<(), RenderError> {
        let count = set.rays.len() as u32;
        let counts = match set.any_hit {
            true => {
                let ray = |(slot, ray): (usize, &TestRay)| ShadowRay {
                    origin: ray.origin,
                    slot: slot as u32,
                    direction: ray.direction,
                    t_max: ray.t_max,
                    contribution: [1.0; 3],
                    depth: 0,
                };
                let rays: Vec<ShadowRay> = set.rays.iter().enumerate().map(ray).collect();
                self.buffers.write(context, "shadow_rays", bytemuck::cast_slice(&rays))?;
                Counts { shadow_in: count, ..Counts::default() }
            }
            false => {
                let ray = |ray: &TestRay| PathRay {
                    origin: ray.origin,
                    direction: ray.direction,
                    ..PathRay::default()
                };
                let rays: Vec<PathRay> = set.rays.iter().map(ray).collect();
                self.buffers.write(context, "paths_in", bytemuck::cast_slice(&rays))?;
                Counts { paths_in: count, ..Counts::default() }
            }
        };
        Ok(self.buffers.write(context, "counts", bytemuck::bytes_of(&counts))?)
    }

    /// Traces the set that is in the queues; in seconds.
    ///
    /// # Errors
    /// A lost device.
    pub fn dispatch(&self, context: &Context, set: &RaySet) -> Result<f64, RenderError> {
        let start = Instant::now();
        let kernel = if set.any_hit { &self.occlusion } else { &self.closest_hit };
        let mut encoder = context.device.create_command_encoder(&Default::default());
        kernel.dispatch(&mut encoder.begin_compute_pass(&Default::default()), set.rays.len() as u32);
        context.queue.submit([encoder.finish()]);
        context.wait()?;
        Ok(start.elapsed().as_secs_f64())
    }

    /// Traces a set for the closest hits.
    ///
    /// # Errors
    /// A lost device.
    pub fn hits(&self, context: &Context, set: &RaySet) -> Result<Vec<Hit>, RenderError> {
        debug_assert!(!set.any_hit);
        self.found(context, set, "hits")
    }

    /// Traces a set: how many nodes and triangles each ray looks at. The tracer's kernels have [`Feature::Counted`].
    ///
    /// # Errors
    /// A lost device.
    pub fn counts(&self, context: &Context, set: &RaySet) -> Result<Vec<[u32; 2]>, RenderError> {
        self.found(context, set, "ray_counts")
    }

    /// Traces a set of shadow rays: whether each meets anything. The tracer's first.
    ///
    /// # Errors
    /// A lost device.
    pub fn occluded(&self, context: &Context, set: &RaySet) -> Result<Vec<bool>, RenderError> {
        debug_assert!(set.any_hit);
        self.buffers.write(context, "radiance", &vec![0; set.rays.len() * 16])?;
        let radiance: Vec<[f32; 4]> = self.found(context, set, "radiance")?;
        Ok(radiance.iter().map(|cell| cell[0] == 0.0).collect())
    }

    /// Traces a set, and reads what the kernel says of each of its rays.
    fn found<T: bytemuck::Pod>(
        &self,
        context: &Context,
        set: &RaySet,
        buffer: &str,
    ) -> Result<Vec<T>, RenderError> {
        self.load(context, set)?;
        self.dispatch(context, set)?;
        Ok(self.buffers.read_elements(context, buffer, set.rays.len() as u32)?)
    }
}

/// One ray through each pixel's centre of a camera's picture.
pub fn primary_rays(camera: &Camera, [width, height]: [u32; 2]) -> RaySet {
    let v = |x: [f32; 3]| Vec3::from(x);
    let rays = (0..width * height).map(|pixel| {
        let x = (pixel % width) as f32 + 0.5;
        let y = (pixel / width) as f32 + 0.5;
        let (x, y) = (x / width as f32, y / height as f32);
        let origin = v(camera.origin) + x * v(camera.origin_dx) + y * v(camera.origin_dy);
        let direction = v(camera.direction) + x * v(camera.direction_dx) + y * v(camera.direction_dy);
        ray(origin, direction.normalize(), f32::MAX)
    });
    RaySet { name: "primary", rays: rays.collect(), any_hit: false }
}

/// A diffuse bounce where each primary ray hit, and from there a shadow ray to where another one hit.
pub fn further_rays(accel: &Accel, primary: &RaySet, hits: &[Hit]) -> [RaySet; 2] {
    let points: Vec<(Vec3, Vec3)> = hits
        .iter()
        .zip(&primary.rays)
        .filter(|(hit, _)| hit.triangle != u32::MAX)
        .map(|(hit, ray)| surface(&accel.triangle_at(hit.triangle), hit, ray.direction.into()))
        .collect();
    let random = |index: usize, dimension: u32| {
        uniform4(RandomKey { pixel: index as u32, sample: 0, seed: 1 }, dimension)
    };
    let bounce = points.iter().enumerate().map(|(index, (origin, normal))| {
        let u = random(index, 0);
        let local = sample_cosine_hemisphere(glam::Vec2::new(u.x, u.y));
        ray(*origin, Frame::from_normal(*normal).to_world(local), f32::MAX)
    });
    let shadow = points.iter().enumerate().map(|(index, (origin, _))| {
        let other = (random(index, 1).x * points.len() as f32) as usize;
        ray(*origin, points[other].0 - *origin, 1.0 - 2f32.powi(-20))
    });
    [
        RaySet { name: "bounce", rays: bounce.collect(), any_hit: false },
        RaySet { name: "shadow", rays: shadow.collect(), any_hit: true },
    ]
}

fn ray(origin: Vec3, direction: Vec3, t_max: f32) -> TestRay {
    TestRay { origin: origin.to_array(), direction: direction.to_array(), t_max }
}

/// A point just off the surface on the side the ray came from, and the normal of that side.
fn surface(triangle: &AccelTriangle, hit: &Hit, direction: Vec3) -> (Vec3, Vec3) {
    let [v0, v1, v2] = triangle.vertices;
    let normal = (v1 - v0).as_dvec3().cross((v2 - v0).as_dvec3()).normalize().as_vec3();
    let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
    let reach = v0.abs().max(v1.abs()).max(v2.abs()).max_element();
    let point = (1.0 - hit.b1 - hit.b2) * v0 + hit.b1 * v1 + hit.b2 * v2;
    (point + normal * reach * 2f32.powi(-20), normal)
}
