//! The driver's own acceleration structure, for ray queries.

use wgpu::{
    AccelerationStructureFlags, AccelerationStructureGeometryFlags, AccelerationStructureUpdateMode, Blas,
    BlasBuildEntry, BlasGeometries, BlasGeometrySizeDescriptors, BlasTriangleGeometry,
    BlasTriangleGeometrySizeDescriptor, CommandEncoder, CreateBlasDescriptor, CreateTlasDescriptor,
    TlasInstance, VertexFormat,
};

use super::context::Context;
use crate::device::DeviceError;

/// Bytes from one vertex to the next: those of `layout::Triangle` lie as evenly as vertices alone would.
const VERTEX_STRIDE: u64 = 16;
const FLAGS: AccelerationStructureFlags = AccelerationStructureFlags::PREFER_FAST_TRACE;
const UPDATE: AccelerationStructureUpdateMode = AccelerationStructureUpdateMode::Build;
/// All rays meet all places.
const EVERY: u8 = 0xff;

/// Triangles in a row in a buffer of `layout::Triangle`.
#[derive(Clone, Copy)]
pub struct Geometry<'a> {
    pub triangles: &'a wgpu::Buffer,
    pub first: u32,
    pub count: u32,
    /// Rays that meet a triangle meet a surface: kernels have nothing to decide.
    pub is_opaque: bool,
}

/// Triangles that are moved as one.
pub struct Part<'a> {
    pub geometries: Vec<Geometry<'a>>,
    pub places: Vec<Place>,
}

/// Where a part is.
#[derive(Clone, Copy)]
pub struct Place {
    /// From the part's space to that of rays, three rows of four.
    pub transform: [f32; 12],
    /// What a hit says of it; below 2^24.
    pub number: u32,
}

impl Place {
    /// Of a part that is where its vertices are.
    pub fn own(number: u32) -> Self {
        Self { transform: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0], number }
    }
}

/// Builds a structure over triangles, and waits until it is there. A hit tells its place, the index of the geometry in the part
/// and that of the triangle in the geometry.
///
/// # Errors
/// What the driver said; out of memory.
pub fn build(context: &Context, parts: &[Part]) -> Result<wgpu::Tlas, DeviceError> {
    let device = &context.device;
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let mut encoder = device.create_command_encoder(&Default::default());
    let structure = record(context, parts, &mut encoder);
    context.queue.submit([encoder.finish()]);
    let faults = [pollster::block_on(memory.pop()), pollster::block_on(validation.pop())];
    if let Some(fault) = faults.into_iter().flatten().next() {
        return Err(DeviceError::AccelerationStructure { message: fault.to_string() });
    }
    context.wait()?;
    Ok(structure)
}

/// Records the building of a structure.
pub fn record(context: &Context, parts: &[Part], encoder: &mut CommandEncoder) -> wgpu::Tlas {
    let device = &context.device;
    let places = parts.iter().map(|part| part.places.len()).sum::<usize>();
    let mut structure = device.create_tlas(&CreateTlasDescriptor {
        label: Some("scene"),
        max_instances: places.max(1) as u32,
        flags: FLAGS,
        update_mode: UPDATE,
    });
    let sizes: Vec<Vec<BlasTriangleGeometrySizeDescriptor>> =
        parts.iter().map(|part| part.geometries.iter().map(size).collect()).collect();
    let built: Vec<Blas> = sizes
        .iter()
        .map(|sizes| {
            device.create_blas(
                &CreateBlasDescriptor { label: Some("triangles"), flags: FLAGS, update_mode: UPDATE },
                BlasGeometrySizeDescriptors::Triangles { descriptors: sizes.clone() },
            )
        })
        .collect();
    let placed = parts.iter().zip(&built).flat_map(|(part, blas)| {
        part.places.iter().map(move |place| TlasInstance::new(blas, place.transform, place.number, EVERY))
    });
    placed.enumerate().for_each(|(index, place)| structure[index] = Some(place));
    let entries: Vec<BlasBuildEntry> = parts
        .iter()
        .zip(&built)
        .zip(&sizes)
        .map(|((part, blas), sizes)| {
            let geometries = part.geometries.iter().zip(sizes);
            BlasBuildEntry {
                blas,
                geometry: BlasGeometries::TriangleGeometries(
                    geometries.map(|(geometry, size)| described(geometry, size)).collect(),
                ),
            }
        })
        .collect();
    encoder.build_acceleration_structures(&entries, [&structure]);
    structure
}

fn size(geometry: &Geometry) -> BlasTriangleGeometrySizeDescriptor {
    BlasTriangleGeometrySizeDescriptor {
        vertex_format: VertexFormat::Float32x3,
        vertex_count: 3 * geometry.count,
        index_format: None,
        index_count: None,
        flags: match geometry.is_opaque {
            true => AccelerationStructureGeometryFlags::OPAQUE,
            false => AccelerationStructureGeometryFlags::empty(),
        },
    }
}

fn described<'a>(
    geometry: &Geometry<'a>,
    size: &'a BlasTriangleGeometrySizeDescriptor,
) -> BlasTriangleGeometry<'a> {
    BlasTriangleGeometry {
        size,
        vertex_buffer: geometry.triangles,
        first_vertex: 3 * geometry.first,
        vertex_stride: VERTEX_STRIDE,
        index_buffer: None,
        first_index: None,
        transform_buffer: None,
        transform_buffer_offset: None,
    }
}
