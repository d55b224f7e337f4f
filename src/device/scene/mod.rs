//! The scene in device memory: exactly the buffers that its features name.

mod hardware;
mod instances;
mod lights;
mod materials;
mod memory;
pub mod microfacet;
mod thinning;
mod units;
mod vertices;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;

pub use lights::{LightSourceInfo, SourceKind};
pub use memory::{SceneMemory, readable_bytes};

use super::buffer::BufferTable;
use super::context::Context;
use super::features::{Feature, Features};
use super::layout::{self, Camera};
use super::pages::{PageWriter, PagedBuffer, Pages};
use super::traversal::Traversal;
use crate::accel::{Accel, AccelTriangle, UnitSpace};
use crate::device::DeviceError;
use crate::math::scale::normalising_exponent;
use crate::scene::{self, Projection, Scene, SceneFeatures};
use units::punctual_intensity;

/// Sizes of the traversal's stack in `shaders/lib/traverse.wgsl`.
const STACK: u32 = 16;
const DEEP_STACK: u32 = 64;
/// The most storage buffers that a kernel binds, each buffer of the scene in one page; a test knows them all.
pub const MOST_OTHER_BUFFERS: u32 = 32;
/// Items that the host converts at a time while it uploads.
const ITEMS_AT_ONCE: usize = 1 << 16;

/// A scene on a device, with what its kernels must be compiled with. Clones share the device's memory.
#[derive(Clone)]
pub struct DeviceScene {
    pub buffers: BufferTable,
    pub features: SceneFeatures,
    /// Values of the kernels' `override` constants that follow from the layout of its buffers.
    pub constants: Vec<(&'static str, f64)>,
    pub unit: UnitSpace,
    /// Device radiance times 2^this is the scene's radiance.
    pub radiance_exponent: i32,
    /// What can be sampled as a light, in the order of the device's list.
    pub lights: Arc<[LightSourceInfo]>,
    /// The BVH is deeper than the traversal's ordinary stack.
    deep_tree: bool,
    /// Surfaces lie in one another.
    coincident: bool,
    /// Some surface has narrow lobes, and all light can be found without connecting to them.
    pub thins: bool,
    /// Surfaces all but touch.
    thin_gaps: bool,
    /// Meshes are shown by instances.
    instances: bool,
    /// It is on a software device.
    software: bool,
    /// What its rays are traced by, as far as that is settled.
    pub tracing: Tracing,
    /// Of its buffers.
    pub pages: Pages,
    /// Of the upload's time, what the environment's map and table took.
    pub environment_time: Duration,
    pub upload_time: Duration,
}

/// What a scene's rays are traced by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tracing {
    /// By kernels; `reason` where that was not asked for.
    Compute { reason: Option<String> },
    /// By ray queries; `reason` likewise.
    Hardware { reason: Option<String> },
    /// There is what both need: [`DeviceScene::settle`].
    Open,
}

impl DeviceScene {
    /// Lays the scene out for `features` (those of the scene; tests force some) and uploads it.
    ///
    /// # Errors
    /// A part that does not fit the device.
    pub fn new(
        context: &Context,
        scene: &Scene,
        accel: &Accel,
        mut features: SceneFeatures,
    ) -> Result<Self, DeviceError> {
        let start = Instant::now();
        let buffers = BufferTable::default();
        if accel.depth > DEEP_STACK {
            return Err(DeviceError::TreeTooDeep { depth: accel.depth, limit: DEEP_STACK });
        }
        let radiance_exponent = radiance_exponent(scene, &accel.unit);
        let environment_start = Instant::now();
        let environment = lights::environment(scene, &features, radiance_exponent)?;
        let environment_time = environment_start.elapsed();
        let lights = lights::collect(scene, accel, &features, radiance_exponent, environment)?;
        lights.restrict(&mut features);

        let mut target = Target { context, buffers, pages: Pages::default(), constants: Vec::new() };
        let obstacle = match context.traversal {
            Traversal::Compute => None,
            Traversal::Auto | Traversal::Hardware => hardware::obstacle(context, accel),
        };
        let mut tracing = match (context.traversal, obstacle) {
            (Traversal::Hardware, Some(reason)) => return Err(DeviceError::NoHardwareTraversal { reason }),
            (Traversal::Compute, reason) | (Traversal::Auto, reason @ Some(_)) => Tracing::Compute { reason },
            (Traversal::Hardware, None) => Tracing::Hardware { reason: None },
            (Traversal::Auto, None) => Tracing::Open,
        };
        if !matches!(tracing, Tracing::Hardware { .. }) {
            target.upload(PagedBuffer::Nodes, &accel.nodes)?;
        }
        let count = accel.triangles.len();
        target.upload_by(PagedBuffer::Triangles, count, 1, |range, words| {
            words.extend(range.map(|index| match &accel.triangles[index] {
                entry if entry.is_entry() => instances::entry(&accel.instances, index),
                stored => triangle(scene, stored, lights.of_triangle[index]),
            }));
        })?;
        if !matches!(tracing, Tracing::Compute { .. }) {
            match hardware::build(&mut target, accel, &features) {
                Err(DeviceError::AccelerationStructure { message }) if tracing == Tracing::Open => {
                    let reason = format!("the driver builds no acceleration structure: {message}");
                    tracing = Tracing::Compute { reason: Some(reason) };
                }
                built => built?,
            }
        }
        if !accel.covers.is_empty() {
            target.upload(PagedBuffer::Covers, &accel.covers)?;
        }
        instances::upload(&mut target, &accel.instances)?;
        let thins = materials::upload(&mut target, scene, &accel.unit, &features, radiance_exponent)?;
        if Features::from(features).contains(Feature::Attributes) {
            vertices::upload(&mut target, scene, accel, &features)?;
        }
        lights.upload(&mut target)?;
        let Target { buffers, pages, constants, .. } = target;
        check_bindings(
            pages,
            context.page_bytes,
            context.device.limits().max_storage_buffers_per_shader_stage,
        )?;
        Ok(Self {
            buffers,
            features,
            constants,
            unit: accel.unit,
            radiance_exponent,
            lights: lights.describe(accel).into(),
            deep_tree: accel.depth > STACK,
            coincident: !accel.covers.is_empty(),
            thins: thins && !features.punctual_lights,
            thin_gaps: accel.thin_gaps,
            instances: !accel.instances.list.is_empty(),
            software: context.is_cpu(),
            tracing,
            pages,
            environment_time,
            upload_time: start.elapsed(),
        })
    }

    /// Traces by ray queries from now on, or by kernels; what the other would need goes.
    pub fn settle(&mut self, tracing: Tracing) {
        match tracing {
            Tracing::Compute { .. } => self.buffers.remove_structure(),
            Tracing::Hardware { .. } => PagedBuffer::Nodes.remove(&mut self.buffers),
            Tracing::Open => {}
        }
        self.tracing = tracing;
    }

    /// What traces its rays, once that is settled.
    pub fn traversal(&self) -> Traversal {
        match self.tracing {
            Tracing::Compute { .. } => Traversal::Compute,
            Tracing::Hardware { .. } => Traversal::Hardware,
            Tracing::Open => Traversal::Auto,
        }
    }

    /// What all kernels for the scene are compiled with.
    pub fn kernel_features(&self) -> Features {
        let mut features = Features::from(self.features);
        if self.deep_tree {
            features.insert(Feature::DeepTree);
        }
        if self.coincident {
            features.insert(Feature::Coincident);
        }
        if self.thin_gaps {
            features.insert(Feature::ThinGaps);
        }
        if self.instances {
            features.insert(Feature::Instances);
        }
        if self.software {
            features.insert(Feature::Software);
        }
        if matches!(self.tracing, Tracing::Hardware { .. }) {
            features.insert(Feature::RayQuery);
        }
        features.with_pages(self.pages)
    }
}

/// Where rays of a parallel camera start that stands for a far one: unit space ends at 1 before its middle.
const BEFORE_SCENE: f64 = 2.0;

/// `away`: distance, along its axis, of the camera from the middle of unit space. `tangent`: of half the field of view. What
/// a parallel camera shows is off by 1 / away of the picture, what directions in f32 show by 2^-24 / tangent; the angles that
/// are lost may be 2^-10.
fn is_as_good_as_parallel(away: f64, tangent: f64) -> bool {
    away > 2f64.powi(12) && tangent < away * 2f64.powi(-24) && tangent < 2f64.powi(-10)
}

impl Camera {
    /// A scene's camera in unit space, for a picture of `width` x `height` pixels. One that looks from very far at something
    /// small becomes a parallel one near the scene where that is nearer to the truth than the rounding of directions: rays
    /// that differ by less than their digits would be one ray.
    pub fn new(unit: &UnitSpace, camera: &scene::Camera, width: u32, height: u32) -> Self {
        let aspect = width as f32 / height as f32;
        let origin = unit.point(camera.position);
        let mut device = Self { origin: origin.to_array(), ..Self::default() };
        match camera.projection {
            Projection::Perspective { yfov } => {
                let tangent = (0.5 * yfov).tan();
                let forward = camera.forward.as_dvec3();
                let away = -unit.point_f64(camera.position).dot(forward);
                if is_as_good_as_parallel(away, f64::from(tangent)) {
                    let half = (away * f64::from(tangent)) as f32;
                    let before = away - BEFORE_SCENE;
                    let start = (unit.point_f64(camera.position) + before * forward).as_vec3();
                    return Self { before: before as f32, ..device.parallel(camera, start, half, aspect) };
                }
                let (right, up) = (camera.right * tangent * aspect, camera.up * tangent);
                device.direction = (camera.forward - right + up).to_array();
                device.direction_dx = (2.0 * right).to_array();
                device.direction_dy = (-2.0 * up).to_array();
            }
            Projection::Orthographic { ymag, .. } => {
                let half = unit.length(f64::from(ymag)) as f32;
                device = device.parallel(camera, origin, half, aspect);
            }
        }
        device
    }

    /// Looks along `camera` from the plane through `start`, at `half` to either side.
    fn parallel(self, camera: &scene::Camera, start: Vec3, half: f32, aspect: f32) -> Self {
        let (right, up) = (camera.right * half * aspect, camera.up * half);
        Self {
            origin: (start - right + up).to_array(),
            origin_dx: (2.0 * right).to_array(),
            origin_dy: (-2.0 * up).to_array(),
            direction: camera.forward.to_array(),
            ..self
        }
    }

    /// True where all of the camera's rays are parallel.
    pub fn is_parallel(&self) -> bool {
        self.direction_dx == [0.0; 3]
    }
}

/// The power of two that brings the scene's strongest light to about one, so that radiances of 1e-30 and 1e30 are
/// the same to the kernels but for this exponent.
fn radiance_exponent(scene: &Scene, unit: &UnitSpace) -> i32 {
    let surfaces = scene.materials.iter().map(|material| {
        let unlit = if material.unlit { material.base_color.max_element() } else { 0.0 };
        f64::from(material.emission.max_element().max(unlit))
    });
    let punctual = scene.lights.iter().map(|light| punctual_intensity(light, unit).max_element());
    let environment =
        scene.environment.iter().map(|environment| f64::from(environment.brightest() * environment.scale));
    let strongest = surfaces.chain(punctual).chain(environment).fold(0.0, f64::max);
    normalising_exponent(strongest).map_or(0, |exponent| -exponent)
}

fn triangle(scene: &Scene, triangle: &AccelTriangle, light: u32) -> layout::Triangle {
    let material = scene.meshes[triangle.mesh as usize].material;
    let mut flags = if triangle.flipped { layout::TRIANGLE_FLIPPED } else { 0 };
    if scene.materials[material as usize].alpha_mode != scene::AlphaMode::Opaque {
        flags |= layout::TRIANGLE_ALPHA;
    }
    if scene.materials[material as usize].culled {
        flags |= layout::TRIANGLE_CULLED;
    }
    layout::Triangle {
        v0: triangle.vertices[0].to_array(),
        material_flags: material | flags,
        v1: triangle.vertices[1].to_array(),
        light,
        v2: triangle.vertices[2].to_array(),
        cover: triangle.cover,
    }
}

/// Where the scene's buffers go.
struct Target<'a> {
    context: &'a Context,
    buffers: BufferTable,
    pages: Pages,
    constants: Vec<(&'static str, f64)>,
}

impl Target<'_> {
    /// A buffer that the host has as a whole.
    fn upload<T: bytemuck::Pod>(&mut self, buffer: PagedBuffer, data: &[T]) -> Result<(), DeviceError> {
        let elements = size_of_val(data) as u64 / buffer.element();
        let mut writer = PageWriter::new(self.context, &mut self.buffers, buffer, elements)?;
        writer.push(data)?;
        writer.finish(&mut self.pages, &mut self.constants);
        Ok(())
    }

    /// A buffer of `count` items of `size` elements each that `make` makes for ranges of them: the host never has all of it.
    fn upload_by<T: bytemuck::Pod>(
        &mut self,
        buffer: PagedBuffer,
        count: usize,
        size: usize,
        mut make: impl FnMut(std::ops::Range<usize>, &mut Vec<T>),
    ) -> Result<(), DeviceError> {
        let mut writer = PageWriter::new(self.context, &mut self.buffers, buffer, (count * size) as u64)?;
        let mut items = Vec::new();
        for first in (0..count).step_by(ITEMS_AT_ONCE) {
            items.clear();
            make(first..count.min(first + ITEMS_AT_ONCE), &mut items);
            writer.push(&items)?;
        }
        writer.finish(&mut self.pages, &mut self.constants);
        Ok(())
    }
}

/// A kernel binds a buffer for each page.
fn check_bindings(pages: Pages, page_bytes: u64, limit: u32) -> Result<(), DeviceError> {
    let needed = pages.extra() + MOST_OTHER_BUFFERS;
    if pages.extra() > 0 && needed > limit {
        return Err(DeviceError::TooManyPages { pages: pages.extra(), page_bytes, needed, limit });
    }
    Ok(())
}
