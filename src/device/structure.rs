//! The driver's own acceleration structure, for ray queries.

use wgpu::{
    AccelerationStructureFlags, AccelerationStructureGeometryFlags, AccelerationStructureUpdateMode,
    BlasBuildEntry, BlasGeometries, BlasGeometrySizeDescriptors, BlasTriangleGeometry,
    BlasTriangleGeometrySizeDescriptor, CommandEncoder, CreateBlasDescriptor, CreateTlasDescriptor,
    TlasInstance, VertexFormat,
};

use super::context::Context;
use crate::device::DeviceError;

/// Bytes from one vertex to the next: those of `layout::Triangle` lie as evenly as vertices alone would.
const VERTEX_STRIDE: u64 = 16;
const IDENTITY: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// All rays meet all instances.
const EVERY: u8 = 0xff;

/// Triangles in one buffer of `layout::Triangle`, from its first on.
pub struct Geometry<'a> {
    pub triangles: &'a wgpu::Buffer,
    pub count: u32,
    /// Rays that meet a triangle meet a surface: kernels have nothing to decide.
    pub is_opaque: bool,
}

/// Builds a structure over triangles, and waits until it is there. A hit tells its triangle by the place of the geometry
/// and the place in it.
///
/// # Errors
/// What the driver said; out of memory.
pub fn build(context: &Context, geometries: &[Geometry]) -> Result<wgpu::Tlas, DeviceError> {
    let device = &context.device;
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let mut encoder = device.create_command_encoder(&Default::default());
    let structure = record(context, geometries, &mut encoder);
    context.queue.submit([encoder.finish()]);
    let faults = [pollster::block_on(memory.pop()), pollster::block_on(validation.pop())];
    if let Some(fault) = faults.into_iter().flatten().next() {
        return Err(DeviceError::AccelerationStructure { message: fault.to_string() });
    }
    context.wait()?;
    Ok(structure)
}

/// Records the building of a structure.
pub fn record(context: &Context, geometries: &[Geometry], encoder: &mut CommandEncoder) -> wgpu::Tlas {
    let device = &context.device;
    let flags = AccelerationStructureFlags::PREFER_FAST_TRACE;
    let update_mode = AccelerationStructureUpdateMode::Build;
    let mut structure = device.create_tlas(&CreateTlasDescriptor {
        label: Some("scene"),
        max_instances: 1,
        flags,
        update_mode,
    });
    let sizes: Vec<BlasTriangleGeometrySizeDescriptor> = geometries
        .iter()
        .map(|geometry| BlasTriangleGeometrySizeDescriptor {
            vertex_format: VertexFormat::Float32x3,
            vertex_count: 3 * geometry.count,
            index_format: None,
            index_count: None,
            flags: match geometry.is_opaque {
                true => AccelerationStructureGeometryFlags::OPAQUE,
                false => AccelerationStructureGeometryFlags::empty(),
            },
        })
        .collect();
    if geometries.is_empty() {
        encoder.build_acceleration_structures([], [&structure]);
        return structure;
    }
    let triangles = device.create_blas(
        &CreateBlasDescriptor { label: Some("triangles"), flags, update_mode },
        BlasGeometrySizeDescriptors::Triangles { descriptors: sizes.clone() },
    );
    structure[0] = Some(TlasInstance::new(&triangles, IDENTITY, 0, EVERY));
    let geometries = geometries.iter().zip(&sizes).map(|(geometry, size)| BlasTriangleGeometry {
        size,
        vertex_buffer: geometry.triangles,
        first_vertex: 0,
        vertex_stride: VERTEX_STRIDE,
        index_buffer: None,
        first_index: None,
        transform_buffer: None,
        transform_buffer_offset: None,
    });
    let entry = BlasBuildEntry {
        blas: &triangles,
        geometry: BlasGeometries::TriangleGeometries(geometries.collect()),
    };
    encoder.build_acceleration_structures([&entry], [&structure]);
    structure
}
