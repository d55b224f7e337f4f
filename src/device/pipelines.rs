//! Pipelines of a device, each compiled once: renderers of one scene, and of scenes that require the same, share them.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// What a pipeline is made of: text of the shader, and its constants by name with the bits of their values.
pub type PipelineKey = (String, Vec<(String, u64)>);

/// A compiled shader.
#[derive(Clone)]
pub struct Pipeline {
    pub compute: wgpu::ComputePipeline,
    /// Group, binding and name of every buffer the entry point uses.
    pub slots: Vec<(u32, u32, String)>,
    /// Invocations a workgroup.
    pub workgroup: u32,
}

/// The pipelines of one device; a clone is the same collection. They are kept as long as the device.
#[derive(Clone, Default)]
pub struct Pipelines(Arc<Mutex<HashMap<PipelineKey, Pipeline>>>);

impl Pipelines {
    /// The pipeline of `key`, where it was compiled before.
    pub fn get(&self, key: &PipelineKey) -> Option<Pipeline> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(key).cloned()
    }

    /// Keeps a pipeline for the next that asks. Compilation takes seconds, so nothing is locked meanwhile: two threads
    /// may compile the same one.
    pub fn keep(&self, key: PipelineKey, pipeline: Pipeline) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(key, pipeline);
    }
}
