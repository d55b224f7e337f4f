//! Device memory by name: a kernel finds its buffers by the names its WGSL gives them.

use std::collections::BTreeMap;

use wgpu::{BufferDescriptor, BufferUsages};

use super::context::Context;
use super::pipelines::Bindable;
use crate::device::DeviceError;

/// Named buffers. The names are those of the `var`s in the shaders.
#[derive(Clone, Default)]
pub struct BufferTable {
    buffers: BTreeMap<String, wgpu::Buffer>,
    /// What ray queries go through, under the name that shaders give it.
    structure: Option<(String, wgpu::Tlas)>,
}

impl BufferTable {
    /// A zeroed storage buffer of `bytes` bytes (rounded up to 16) under `name`, replacing an older one.
    ///
    /// # Errors
    /// [`DeviceError::BufferTooLarge`] past the device's limit for one binding, [`DeviceError::OutOfMemory`].
    pub fn create(
        &mut self,
        context: &Context,
        name: &str,
        bytes: u64,
    ) -> Result<&wgpu::Buffer, DeviceError> {
        self.create_with(context, name, bytes, BufferUsages::STORAGE)
    }

    /// As [`create`](Self::create), with the usage beside copying in and out.
    pub fn create_with(
        &mut self,
        context: &Context,
        name: &str,
        bytes: u64,
        usage: BufferUsages,
    ) -> Result<&wgpu::Buffer, DeviceError> {
        let bytes = bytes.max(16).next_multiple_of(16);
        let limit = if usage.contains(BufferUsages::UNIFORM) {
            context.device.limits().max_uniform_buffer_binding_size
        } else {
            context.binding
        };
        if bytes > limit {
            return Err(DeviceError::BufferTooLarge { name: name.into(), bytes, limit });
        }
        self.check_memory(context, name, bytes)?;
        let scope = context.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = context.device.create_buffer(&BufferDescriptor {
            label: Some(name),
            size: bytes,
            usage: usage | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        if pollster::block_on(scope.pop()).is_some() {
            let total = self.buffers.values().map(wgpu::Buffer::size).sum::<u64>() + bytes;
            let memory = context.memory.unwrap_or(total - bytes);
            return Err(DeviceError::OutOfMemory { name: name.into(), bytes, total, memory });
        }
        self.buffers.insert(name.to_string(), buffer);
        Ok(&self.buffers[name])
    }

    /// Software devices take memory that is not there, and end the process when it is used.
    fn check_memory(&self, context: &Context, name: &str, bytes: u64) -> Result<(), DeviceError> {
        let Some(memory) = context.memory else { return Ok(()) };
        let others = self.buffers.iter().filter(|(other, _)| *other != name);
        let total = others.map(|(_, buffer)| buffer.size()).sum::<u64>() + bytes;
        if total > memory {
            return Err(DeviceError::OutOfMemory { name: name.into(), bytes, total, memory });
        }
        Ok(())
    }

    /// A storage buffer that holds `data`.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn upload<T: bytemuck::Pod>(
        &mut self,
        context: &Context,
        name: &str,
        data: &[T],
    ) -> Result<(), DeviceError> {
        self.upload_with(context, name, data, BufferUsages::STORAGE)
    }

    /// A uniform buffer that holds `data`.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn upload_uniform<T: bytemuck::Pod>(
        &mut self,
        context: &Context,
        name: &str,
        data: &[T],
    ) -> Result<(), DeviceError> {
        self.upload_with(context, name, data, BufferUsages::UNIFORM)
    }

    fn upload_with<T: bytemuck::Pod>(
        &mut self,
        context: &Context,
        name: &str,
        data: &[T],
        usage: BufferUsages,
    ) -> Result<(), DeviceError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        // WebGPU wants room for one element even where there is none.
        self.create_with(context, name, bytes.len().max(size_of::<T>()) as u64, usage)?;
        self.write(context, name, bytes)
    }

    /// Overwrites the beginning of a buffer.
    ///
    /// # Errors
    /// [`DeviceError::MissingBuffer`] for an unknown name.
    pub fn write(&self, context: &Context, name: &str, bytes: &[u8]) -> Result<(), DeviceError> {
        let buffer = self.get(name)?;
        let whole = bytes.len() / 4 * 4;
        context.queue.write_buffer(buffer, 0, &bytes[..whole]);
        if whole < bytes.len() {
            let mut last = [0u8; 4];
            last[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
            context.queue.write_buffer(buffer, whole as u64, &last);
        }
        Ok(())
    }

    /// # Errors
    /// [`DeviceError::MissingBuffer`] for an unknown name.
    pub fn get(&self, name: &str) -> Result<&wgpu::Buffer, DeviceError> {
        self.buffers.get(name).ok_or_else(|| DeviceError::MissingBuffer { name: name.into() })
    }

    /// What a kernel binds under this name.
    ///
    /// # Errors
    /// [`DeviceError::MissingBuffer`] for an unknown name.
    pub fn bindable(&self, name: &str) -> Result<Bindable, DeviceError> {
        match &self.structure {
            Some((own, structure)) if own == name => Ok(Bindable::AccelerationStructure(structure.clone())),
            _ => self.get(name).cloned().map(Bindable::Buffer),
        }
    }

    /// Puts what ray queries go through under this name.
    pub fn set_structure(&mut self, name: &str, structure: wgpu::Tlas) {
        self.structure = Some((name.into(), structure));
    }

    /// Takes it away again.
    pub fn remove_structure(&mut self) {
        self.structure = None;
    }

    /// Lets a second name stand for a buffer (`paths_in` and `paths_out` change places every bounce).
    pub fn share(&mut self, name: &str, buffer: wgpu::Buffer) {
        self.buffers.insert(name.to_string(), buffer);
    }

    /// Takes a name away again.
    pub fn unshare(&mut self, name: &str) {
        self.buffers.remove(name);
    }

    /// Copies the first `bytes` bytes of a buffer to the host, waiting for all work before.
    ///
    /// # Errors
    /// A lost device, or an unknown name.
    pub fn read(&self, context: &Context, name: &str, bytes: u64) -> Result<Vec<u8>, DeviceError> {
        read_back(context, self.get(name)?, bytes)
    }

    /// The first `count` elements of a buffer.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_elements<T: bytemuck::Pod>(
        &self,
        context: &Context,
        name: &str,
        count: u32,
    ) -> Result<Vec<T>, DeviceError> {
        let bytes = self.read(context, name, u64::from(count) * size_of::<T>() as u64)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// All elements of a buffer.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_all<T: bytemuck::Pod>(&self, context: &Context, name: &str) -> Result<Vec<T>, DeviceError> {
        let bytes = self.read(context, name, self.get(name)?.size())?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Name and buffer, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&String, &wgpu::Buffer)> {
        self.buffers.iter()
    }

    /// Name and size in bytes of every buffer.
    pub fn sizes(&self) -> Vec<(String, u64)> {
        self.buffers.iter().map(|(name, buffer)| (name.clone(), buffer.size())).collect()
    }
}

/// Copies the first `bytes` bytes (a multiple of 4) of `buffer` to the host.
///
/// # Errors
/// A lost device.
pub fn read_back(context: &Context, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, DeviceError> {
    if bytes == 0 {
        return Ok(Vec::new());
    }
    let staging = context.device.create_buffer(&BufferDescriptor {
        label: Some("read back"),
        size: bytes.next_multiple_of(4),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = context.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes.next_multiple_of(4));
    context.queue.submit([encoder.finish()]);
    let slice = staging.slice(..);
    let (sender, receiver) = std::sync::mpsc::channel();
    slice.map_async(wgpu::MapMode::Read, move |result| {
        // The receiver only goes when the device is lost, which `wait` reports.
        let _ = sender.send(result);
    });
    context.wait()?;
    receiver
        .recv()
        .map_err(|error| DeviceError::Lost { message: error.to_string() })?
        .map_err(|error| DeviceError::Lost { message: error.to_string() })?;
    let view = slice.get_mapped_range().map_err(|error| DeviceError::Lost { message: error.to_string() })?;
    Ok(view[..bytes as usize].to_vec())
}
