//! Kernels: a WGSL file with one entry point, compiled for a set of features, bound to buffers by name.

use std::collections::BTreeSet;

use super::buffer::BufferTable;
use super::context::Context;
use super::features::Features;
use super::pipelines::{Pipeline, Waiting};
use super::shader::{Stitched, stitch};
use crate::device::DeviceError;

/// A compiled kernel.
pub struct Kernel {
    pub name: String,
    pipeline: Pipeline,
}

/// A kernel with its buffers, ready to dispatch.
#[derive(Clone)]
pub struct Bound {
    pub name: String,
    pipeline: wgpu::ComputePipeline,
    groups: Vec<(u32, wgpu::BindGroup)>,
    workgroup: u32,
}

impl Kernel {
    /// Compiles the kernel file `name` (its entry point is called `main`).
    ///
    /// # Errors
    /// A shader error with file and line, or what the driver said.
    pub fn new(
        context: &Context,
        name: &str,
        features: Features,
        constants: &[(&str, f64)],
    ) -> Result<Self, DeviceError> {
        Self::from_stitched(context, name, &stitch(name, features)?, constants)
    }

    /// Compiles a stitched text.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_stitched(
        context: &Context,
        name: &str,
        stitched: &Stitched,
        constants: &[(&str, f64)],
    ) -> Result<Self, DeviceError> {
        // Constants that it does not name are those of its siblings.
        let named = constants.iter().filter(|(name, _)| stitched.code.contains(name));
        let bits = named.map(|&(name, value)| (name.to_string(), value.to_bits())).collect();
        let key = (stitched.code.clone(), bits);
        let pipeline = match context.pipelines.get(&key) {
            Some(pipeline) => pipeline,
            None => {
                let (pipeline, constants) = create(context, name, stitched, constants)?;
                let made = Waiting { name: name.into(), key, constants, pipeline: pipeline.clone() };
                context.pipelines.keep(made, context.is_cpu());
                pipeline
            }
        };
        Ok(Self { name: name.into(), pipeline })
    }

    /// Invocations a workgroup.
    pub fn workgroup(&self) -> u32 {
        self.pipeline.workgroup
    }

    /// Binds the buffers that the kernel names. A software driver compiles first all that was created so far.
    ///
    /// # Errors
    /// [`DeviceError::MissingBuffer`] when `buffers` lacks one; a lost device.
    pub fn bind(&self, context: &Context, buffers: &BufferTable) -> Result<Bound, DeviceError> {
        context.finish_compiling()?;
        let groups = self.pipeline.bind(&context.device, &self.name, |name| buffers.bindable(name))?;
        Ok(Bound {
            name: self.name.clone(),
            pipeline: self.pipeline.compute.clone(),
            groups,
            workgroup: self.pipeline.workgroup,
        })
    }
}

/// Creates what the device does not have yet, and tells the constants that it declares. Software drivers compile it later.
fn create(
    context: &Context,
    name: &str,
    stitched: &Stitched,
    constants: &[(&str, f64)],
) -> Result<(Pipeline, Vec<(String, f64)>), DeviceError> {
    let (module, info) = stitched.validate()?;
    let entry = module.entry_points.first().ok_or_else(|| DeviceError::Shader {
        location: format!("shaders/{name}.wgsl"),
        message: "no entry point".into(),
    })?;
    let uses = info.get_entry_point(0);
    let slots: Vec<(u32, u32, String)> = module
        .global_variables
        .iter()
        .filter(|(handle, _)| !uses[*handle].is_empty())
        .filter_map(|(_, variable)| {
            let binding = variable.binding?;
            Some((binding.group, binding.binding, variable.name.clone().unwrap_or_default()))
        })
        .collect();
    let is_structure = |variable: &naga::GlobalVariable| {
        matches!(module.types[variable.ty].inner, naga::TypeInner::AccelerationStructure { .. })
    };
    let structure = module.global_variables.iter().find(|(_, variable)| is_structure(variable));
    let structure = structure.and_then(|(_, variable)| variable.name.clone());
    // Constants a kernel does not declare are those of its siblings.
    let declared: BTreeSet<&str> =
        module.overrides.iter().filter_map(|(_, constant)| constant.name.as_deref()).collect();
    let declares = |(name, _): &&(&str, f64)| declared.contains(name);
    let constants: Vec<(String, f64)> =
        constants.iter().filter(declares).map(|&(name, value)| (name.to_string(), value)).collect();
    let compute = context.create_pipeline(name, &stitched.code, &constants)?;
    let pipeline = Pipeline { compute, slots, structure, workgroup: entry.workgroup_size[0] };
    Ok((pipeline, constants))
}

impl Bound {
    /// Records one dispatch with at least `invocations` invocations (the kernel guards its end itself).
    /// Large counts run over two dimensions; a kernel's index is `id.x + id.y * 65535 * workgroup`.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass, invocations: u32) {
        let workgroups = invocations.div_ceil(self.workgroup);
        if workgroups == 0 {
            return;
        }
        self.set(pass);
        pass.dispatch_workgroups(workgroups.min(65535), workgroups.div_ceil(65535), 1);
    }

    /// Records one dispatch whose workgroup counts lie in `arguments` at `offset` bytes.
    pub fn dispatch_indirect(&self, pass: &mut wgpu::ComputePass, arguments: &wgpu::Buffer, offset: u64) {
        self.set(pass);
        pass.dispatch_workgroups_indirect(arguments, offset);
    }

    fn set(&self, pass: &mut wgpu::ComputePass) {
        pass.set_pipeline(&self.pipeline);
        for (index, group) in &self.groups {
            pass.set_bind_group(*index, group, &[]);
        }
    }
}
