//! Rays of the three kinds that renderers trace, and how many of them a device traces per second.

use std::time::Instant;

use glam::Vec3;
use serde::Serialize;

use crate::accel::{Accel, AccelTriangle, arranged};
use crate::device::layout::{Camera, Counts, Hit, PathRay, ShadowRay};
use crate::device::scene::DeviceScene;
use crate::device::{Bound, BufferTable, Context, Feature, Kernel};
use crate::math::frame::Frame;
use crate::math::rng::{RandomKey, uniform4};
use crate::math::sampling::sample_cosine_hemisphere;
use crate::render::RenderError;
use crate::scene::{Scene, SceneFeatures};

/// A ray in unit space; it ends at `t_max` times its direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BenchRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub t_max: f32,
}

/// Rays of one kind: `primary`, `bounce` or `shadow`. Shadow rays ask for any hit, the others for the closest.
pub struct RaySet {
    pub name: &'static str,
    pub rays: Vec<BenchRay>,
}

/// A measured rate.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rate {
    pub hits: u64,
    pub mrays_per_second: f64,
}

/// The rays of a scene and the kernels that trace them.
pub struct RayBench {
    pub sets: Vec<RaySet>,
    accel: Accel,
    buffers: BufferTable,
    closest_hit: Bound,
    occlusion: Bound,
}

impl RayBench {
    /// One primary ray through each pixel's centre, a diffuse bounce where it hits, and from there a shadow ray to
    /// where another one hit.
    ///
    /// # Errors
    /// What the layers below report.
    pub fn new(
        context: &Context,
        scene: &Scene,
        camera: usize,
        [width, height]: [u32; 2],
    ) -> Result<Self, RenderError> {
        let scene = &*arranged(scene);
        let accel = Accel::build(scene)?;
        // Materials and lights do not matter to rays; alpha would.
        let features = SceneFeatures { alpha: false, ..SceneFeatures::of(scene) };
        let mut device_scene = DeviceScene::new(context, scene, &accel, features)?;
        let camera = Camera::new(&device_scene.unit, &scene.cameras[camera], width, height);
        let kernel_features = device_scene.kernel_features();
        let closest_hit = Kernel::new(context, "closest_hit", kernel_features, &device_scene.constants)?;
        let any_hit = kernel_features.with(&[Feature::AnyHit]);
        let occlusion = Kernel::new(context, "occlusion", any_hit, &device_scene.constants)?;
        let mut buffers = std::mem::take(&mut device_scene.buffers);
        let count = u64::from(width) * u64::from(height);
        buffers.create(context, "paths_in", count * size_of::<PathRay>() as u64)?;
        buffers.create(context, "hits", count * size_of::<Hit>() as u64)?;
        buffers.create(context, "shadow_rays", count * size_of::<ShadowRay>() as u64)?;
        buffers.create(context, "radiance", count * 16)?;
        buffers.create(context, "counts", size_of::<Counts>() as u64)?;
        let closest_hit = closest_hit.bind(context, &buffers)?;
        let occlusion = occlusion.bind(context, &buffers)?;
        let mut bench = Self { sets: Vec::new(), accel, buffers, closest_hit, occlusion };

        let v = |x: [f32; 3]| Vec3::from(x);
        let primary: Vec<BenchRay> = (0..width * height)
            .map(|pixel| {
                let x = (pixel % width) as f32 + 0.5;
                let y = (pixel / width) as f32 + 0.5;
                let (x, y) = (x / width as f32, y / height as f32);
                let origin = v(camera.origin) + x * v(camera.origin_dx) + y * v(camera.origin_dy);
                let direction = v(camera.direction) + x * v(camera.direction_dx) + y * v(camera.direction_dy);
                ray(origin, direction.normalize(), f32::MAX)
            })
            .collect();
        bench.sets.push(RaySet { name: "primary", rays: primary });
        let hits = bench.trace(context, 0)?;
        let points: Vec<(Vec3, Vec3)> = hits
            .iter()
            .zip(&bench.sets[0].rays)
            .filter(|(hit, _)| hit.triangle != u32::MAX)
            .map(|(hit, ray)| surface(&bench.accel.triangle_at(hit.triangle), hit, v(ray.direction)))
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
        let (bounce, shadow) = (bounce.collect(), shadow.collect());
        bench.sets.push(RaySet { name: "bounce", rays: bounce });
        bench.sets.push(RaySet { name: "shadow", rays: shadow });
        Ok(bench)
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
        let any_hit = self.sets[set].name == "shadow";
        let hits = if any_hit {
            self.upload_shadow(context, set)?;
            self.dispatch(context, set)?;
            let bytes = self.sets[set].rays.len() as u64 * 16;
            let radiance: Vec<[f32; 4]> =
                bytemuck::pod_collect_to_vec(&self.buffers.read(context, "radiance", bytes)?);
            radiance.iter().filter(|cell| cell[0] == 0.0).count()
        } else {
            self.trace(context, set)?.iter().filter(|hit| hit.triangle != u32::MAX).count()
        };
        let start = Instant::now();
        let mut rounds = 0u32;
        while rounds == 0 || start.elapsed().as_secs_f64() < seconds {
            self.dispatch(context, set)?;
            rounds += 1;
        }
        let traced = f64::from(rounds) * self.sets[set].rays.len() as f64;
        Ok(Rate { hits: hits as u64, mrays_per_second: traced / start.elapsed().as_secs_f64() * 1e-6 })
    }

    fn dispatch(&self, context: &Context, set: usize) -> Result<(), RenderError> {
        let set = &self.sets[set];
        let kernel = if set.name == "shadow" { &self.occlusion } else { &self.closest_hit };
        let mut encoder = context.device.create_command_encoder(&Default::default());
        kernel.dispatch(&mut encoder.begin_compute_pass(&Default::default()), set.rays.len() as u32);
        context.queue.submit([encoder.finish()]);
        Ok(context.wait()?)
    }

    /// Uploads a set of closest-hit rays, traces them once and returns the hits.
    fn trace(&self, context: &Context, set: usize) -> Result<Vec<Hit>, RenderError> {
        let rays = &self.sets[set].rays;
        let paths: Vec<PathRay> = rays
            .iter()
            .map(|ray| PathRay { origin: ray.origin, direction: ray.direction, ..PathRay::default() })
            .collect();
        self.buffers.write(context, "paths_in", bytemuck::cast_slice(&paths))?;
        let counts = Counts { paths_in: rays.len() as u32, ..Counts::default() };
        self.buffers.write(context, "counts", bytemuck::bytes_of(&counts))?;
        self.dispatch(context, set)?;
        let bytes = self.buffers.read(context, "hits", (rays.len() * size_of::<Hit>()) as u64)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    fn upload_shadow(&self, context: &Context, set: usize) -> Result<(), RenderError> {
        let rays = &self.sets[set].rays;
        let shadow: Vec<ShadowRay> = rays
            .iter()
            .enumerate()
            .map(|(index, ray)| ShadowRay {
                origin: ray.origin,
                slot: index as u32,
                direction: ray.direction,
                t_max: ray.t_max,
                contribution: [1.0; 3],
                depth: 0,
            })
            .collect();
        self.buffers.write(context, "shadow_rays", bytemuck::cast_slice(&shadow))?;
        let counts = Counts { shadow_in: rays.len() as u32, ..Counts::default() };
        self.buffers.write(context, "counts", bytemuck::bytes_of(&counts))?;
        Ok(())
    }
}

fn ray(origin: Vec3, direction: Vec3, t_max: f32) -> BenchRay {
    BenchRay { origin: origin.to_array(), direction: direction.to_array(), t_max }
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
