//! What a scene takes of memory, foretold from the scene alone: before anything is built from it.

use std::collections::BTreeSet;

use super::vertices;
use crate::accel::block_bits;
use crate::device::layout::{Light, Material};
use crate::device::pages::{PagedBuffer, Pages};
use crate::device::{Context, DeviceError, Feature, Features};
use crate::scene::{EqualAreaMap, Mesh, Scene, SceneFeatures};

/// Bytes of the BVH's nodes for each triangle; measured (docs/measurements.md).
const NODE_BYTES: f64 = 8.3;
/// Bytes of the host for each triangle while the BVH is built, and of what is left of it until the scene is on the device;
/// measured (docs/measurements.md).
const BUILD_BYTES: u64 = 280;
const BUILT_BYTES: u64 = 64;
/// Of the host for each instance while the BVH is built; measured (docs/measurements.md).
const INSTANCE_BYTES: u64 = 530;
/// Of the host for each texel while an environment's map and table are made, beside what the device gets; measured.
const ENVIRONMENT_BUILD_BYTES: u64 = 40;

/// What a scene will take.
#[derive(Clone, Debug)]
pub struct SceneMemory {
    /// Bytes of the device by buffer, the largest first.
    pub buffers: Vec<(PagedBuffer, u64)>,
    /// Of its other buffers.
    pub others: u64,
    /// Bytes of the host at the peak, beside the scene itself and the device's.
    pub host_peak: u64,
}

impl SceneMemory {
    /// `features`: those of the scene.
    pub fn of(scene: &Scene, features: &SceneFeatures) -> Self {
        let triangles = stored_triangles(scene);
        let mut buffers = vec![
            (PagedBuffer::Nodes, ((triangles as f64 * NODE_BYTES) as u64).max(PagedBuffer::Nodes.element())),
            (PagedBuffer::Triangles, triangles * PagedBuffer::Triangles.element()),
        ];
        if Features::from(*features).contains(Feature::Attributes) {
            let vertices: u64 =
                scene.meshes.iter().map(|mesh| vertices::vertex_count(mesh, features) as u64).sum();
            let stride = u64::from(vertices::stride(features));
            buffers
                .push((PagedBuffer::CornerVertices, triangles * 3 * PagedBuffer::CornerVertices.element()));
            buffers.push((
                PagedBuffer::VertexAttributes,
                vertices * stride * PagedBuffer::VertexAttributes.element(),
            ));
        }
        if features.textures {
            let slots = scene.materials.iter().flat_map(|material| material.textures());
            let images: BTreeSet<u32> =
                slots.map(|slot| scene.textures[slot.texture as usize].image).collect();
            let texels = images.into_iter().map(|image| scene.images[image as usize].texels.len() as u64);
            buffers.push((PagedBuffer::Texels, texels.sum::<u64>() * PagedBuffer::Texels.element()));
        }
        let instances: u64 = scene.meshes.iter().map(|mesh| mesh.instances.len() as u64).sum();
        if instances > 0 {
            buffers.push((PagedBuffer::Instances, instances * PagedBuffer::Instances.element()));
            buffers
                .push((PagedBuffer::InstanceBlocks, blocks(scene) * PagedBuffer::InstanceBlocks.element()));
        }
        let mut host_peak = (triangles - instances) * BUILD_BYTES + instances * INSTANCE_BYTES;
        if features.environment
            && let Some(environment) = &scene.environment
        {
            let texels = u64::from(EqualAreaMap::size_for(environment)).pow(2);
            for buffer in [PagedBuffer::EnvironmentTexels, PagedBuffer::EnvironmentAlias] {
                buffers.push((buffer, texels * buffer.element()));
            }
            host_peak = host_peak.max(triangles * BUILT_BYTES + texels * ENVIRONMENT_BUILD_BYTES);
        }
        buffers.sort_by_key(|&(_, bytes)| std::cmp::Reverse(bytes));
        let emitting = scene.meshes.iter().filter(|mesh| {
            let material = &scene.materials[mesh.material as usize];
            features.area_lights && (material.unlit || material.emission.max_element() > 0.0)
        });
        let lights = emitting.map(|mesh| mesh.triangles.len()).sum::<usize>() + scene.lights.len();
        let others = lights * size_of::<Light>() + scene.materials.len() * size_of::<Material>();
        Self { buffers, others: others as u64, host_peak }
    }

    /// Bytes of the device.
    pub fn device(&self) -> u64 {
        self.buffers.iter().map(|(_, bytes)| bytes).sum::<u64>() + self.others
    }

    /// Pages of each buffer, of at most so many bytes each.
    pub fn pages(&self, page_bytes: u64) -> Pages {
        let mut pages = Pages::default();
        for &(buffer, bytes) in &self.buffers {
            pages.set(buffer, buffer.pages(bytes / buffer.element(), page_bytes));
        }
        pages
    }

    /// What a software device takes of the machine beside the scene itself, at the peak.
    pub fn together(&self) -> u64 {
        self.host_peak.max(self.device())
    }

    /// Says so where the scene does not fit the device.
    ///
    /// # Errors
    /// [`DeviceError::SceneTooLarge`], [`DeviceError::TooManyPages`].
    pub fn check(&self, context: &Context) -> Result<(), DeviceError> {
        let limit = context.device.limits().max_storage_buffers_per_shader_stage;
        self.check_for(context.page_bytes, limit, context.memory)
    }

    /// As [`check`](Self::check), for a device that binds `bindings` buffers of `page_bytes` bytes in a kernel, with so many
    /// bytes free where that is known.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_for(&self, page_bytes: u64, bindings: u32, free: Option<u64>) -> Result<(), DeviceError> {
        super::check_bindings(self.pages(page_bytes), page_bytes, bindings)?;
        let needed = self.together();
        match free {
            Some(free) if needed > free => {
                let largest: Vec<String> = self
                    .buffers
                    .iter()
                    .take(3)
                    .map(|&(buffer, bytes)| format!("{} {}", buffer.name(), readable_bytes(bytes)))
                    .collect();
                Err(DeviceError::SceneTooLarge {
                    needed: readable_bytes(needed),
                    free: readable_bytes(free),
                    largest: largest.join(", "),
                    advice: self.advice(),
                })
            }
            _ => Ok(()),
        }
    }

    /// What to change, by what is largest.
    fn advice(&self) -> &'static str {
        match self.buffers.first() {
            Some((PagedBuffer::Texels, _)) => "use smaller or fewer textures",
            Some((PagedBuffer::EnvironmentTexels | PagedBuffer::EnvironmentAlias, _)) => {
                "use a smaller environment"
            }
            _ => "decimate the meshes or split the scene",
        }
    }
}

/// Triangles that the device has: those of meshes with instances once, and one for each instance.
fn stored_triangles(scene: &Scene) -> u64 {
    scene.meshes.iter().map(|mesh| (mesh.triangles.len() + mesh.instances.len()) as u64).sum()
}

/// Blocks of numbers of instances' triangles.
fn blocks(scene: &Scene) -> u64 {
    let shared = || scene.meshes.iter().filter(|mesh| !mesh.instances.is_empty());
    let triangles = |mesh: &Mesh| mesh.triangles.len() as u32;
    let block = 1 << block_bits(shared().map(triangles));
    shared().map(|mesh| u64::from(triangles(mesh).div_ceil(block)) * mesh.instances.len() as u64).sum()
}

/// For people.
pub fn readable_bytes(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    match mebibytes < 4096.0 {
        true => format!("{mebibytes:.1} MiB"),
        false => format!("{:.1} GiB", mebibytes / 1024.0),
    }
}
