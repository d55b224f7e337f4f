//! Pipelines of a device, each compiled once: renderers of one scene, and of scenes that require the same, share them.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use crate::device::DeviceError;

/// What a pipeline is made of: text of the shader, and its constants by name with the bits of their values.
pub type PipelineKey = (String, Vec<(String, u64)>);

/// A compiled shader.
#[derive(Clone)]
pub struct Pipeline {
    pub compute: wgpu::ComputePipeline,
    /// Group, binding and name of every buffer the entry point uses.
    pub slots: Vec<(u32, u32, String)>,
    /// Which of the names is that of an acceleration structure.
    pub structure: Option<String>,
    /// Invocations a workgroup.
    pub workgroup: u32,
}

/// What a kernel binds under a name.
#[derive(Clone)]
pub enum Bindable {
    Buffer(wgpu::Buffer),
    AccelerationStructure(wgpu::Tlas),
}

impl Bindable {
    /// As bind groups take it.
    pub fn as_binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::AccelerationStructure(structure) => structure.as_binding(),
        }
    }
}

impl Pipeline {
    /// Its bind groups with their indices; `resource_of`: the resource of a name.
    ///
    /// # Errors
    /// Those of `resource_of`.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        label: &str,
        mut resource_of: impl FnMut(&str) -> Result<Bindable, DeviceError>,
    ) -> Result<Vec<(u32, wgpu::BindGroup)>, DeviceError> {
        let indices: BTreeSet<u32> = self.slots.iter().map(|slot| slot.0).collect();
        let mut groups = Vec::new();
        for group in indices {
            let mut resources = Vec::new();
            for (_, binding, name) in self.slots.iter().filter(|slot| slot.0 == group) {
                resources.push((*binding, resource_of(name)?));
            }
            let entries: Vec<wgpu::BindGroupEntry> = resources
                .iter()
                .map(|(binding, resource)| wgpu::BindGroupEntry {
                    binding: *binding,
                    resource: resource.as_binding(),
                })
                .collect();
            let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout: &self.compute.get_bind_group_layout(group),
                entries: &entries,
            });
            groups.push((group, bind_group));
        }
        Ok(groups)
    }
}

/// A pipeline that the driver has not compiled yet, and what it is made of.
pub struct Waiting {
    pub name: String,
    pub key: PipelineKey,
    /// Those that the shader declares.
    pub constants: Vec<(String, f64)>,
    pub pipeline: Pipeline,
}

/// How far compiling is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compiling<'a> {
    pub kernel: &'a str,
    /// How many kernels are done, this one included, of those that wait.
    pub done: usize,
    pub of: usize,
    /// What this one took.
    pub seconds: f64,
}

/// The pipelines of one device; a clone is the same collection. They are kept as long as the device.
#[derive(Clone, Default)]
pub struct Pipelines(Arc<Mutex<Known>>);

#[derive(Default)]
struct Known {
    all: HashMap<PipelineKey, Pipeline>,
    /// Those that the driver has not compiled yet.
    waiting: Vec<Waiting>,
}

impl Pipelines {
    /// The pipeline of `key`, where it was created before.
    pub fn get(&self, key: &PipelineKey) -> Option<Pipeline> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).all.get(key).cloned()
    }

    /// Keeps a pipeline for the next that asks. Creating takes time, so nothing is locked meanwhile: two threads may create
    /// the same one. `waits`: the driver compiles it later.
    pub fn keep(&self, made: Waiting, waits: bool) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.all.insert(made.key.clone(), made.pipeline.clone());
        if waits {
            known.waiting.push(made);
        }
    }

    /// What the driver has to compile; from now on it is the caller's to see to.
    pub fn take_waiting(&self) -> Vec<Waiting> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner).waiting)
    }
}
