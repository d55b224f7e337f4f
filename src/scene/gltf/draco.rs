//! Primitives compressed by `KHR_draco_mesh_compression`.

use std::collections::BTreeMap;
use std::panic::catch_unwind;

use draco_core::decode_limits::DecodeLimits;
use draco_core::draco_types::DataType;
use draco_core::geometry_attribute::PointAttribute;
use draco_core::geometry_indices::PointIndex;
use draco_core::{DecoderBuffer, Mesh, MeshDecoder};
use gltf::json::Index;
use gltf::json::buffer::View;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use serde::Deserialize;

use super::accessor::Values;
use super::mesh::Decompressed;
use super::options::Limits;

/// The extension object of a primitive.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Compressed {
    /// Where the compressed bytes lie.
    pub buffer_view: Index<View>,
    /// The attributes that are compressed, each with its number in there.
    pub attributes: BTreeMap<Checked<Semantic>, u32>,
}

/// Decompresses a primitive.
///
/// # Errors
/// What is wrong with the bytes, or with the attributes asked for; more vertices or triangles than the limits allow.
pub fn decode(what: &Compressed, bytes: &[u8], limits: &Limits) -> Result<Decompressed, String> {
    let allowed = DecodeLimits::default().with_max_points(limits.vertices).with_max_faces(limits.triangles);
    // The decoder meets hostile files here; should it panic, that is damaged data.
    let mesh = catch_unwind(|| {
        let mut mesh = Mesh::new();
        MeshDecoder::new()
            .decode(&mut DecoderBuffer::new(bytes).with_limits(allowed), &mut mesh)
            .map(|()| mesh)
    });
    let mesh = mesh
        .map_err(|_| "the decoder failed".to_string())?
        .map_err(|error| format!("the compressed bytes are damaged: {error}"))?;
    let points = mesh.num_points();
    if mesh.num_faces() == 0 || points as u64 > limits.vertices {
        return Err(format!("the compressed mesh has {} triangles and {points} vertices", mesh.num_faces()));
    }
    let indices: Vec<u32> = mesh.faces().iter().flatten().map(|point| point.0).collect();
    if let Some(index) = indices.iter().find(|index| **index as usize >= points) {
        return Err(format!("index {index}, but the compressed mesh has {points} vertices"));
    }
    let read = |(semantic, id): (&Checked<Semantic>, &u32)| {
        let found = mesh.attribute_by_unique_id(*id);
        let found = found.ok_or_else(|| format!("the compressed mesh has no attribute {id}"))?;
        let values = components(found, points).map_err(|what| format!("compressed attribute {id} {what}"))?;
        Ok::<_, String>((semantic.clone(), values))
    };
    Ok(Decompressed { attributes: what.attributes.iter().map(read).collect::<Result<_, _>>()?, indices })
}

/// The components of an attribute for each vertex.
fn components(attribute: &PointAttribute, points: usize) -> Result<Values, String> {
    let kind = attribute.data_type();
    let size = match kind {
        DataType::Int8 | DataType::Uint8 => 1,
        DataType::Int16 | DataType::Uint16 => 2,
        DataType::Int32 | DataType::Uint32 | DataType::Float32 => 4,
        other => return Err(format!("is of {other:?}, which glTF does not have")),
    };
    let lanes = usize::from(attribute.num_components());
    if lanes == 0 {
        return Err("has no components".into());
    }
    let mut values = Values { lanes, data: Vec::with_capacity(points * lanes) };
    for point in 0..points as u32 {
        let bytes = element(attribute, point, size * lanes)
            .ok_or_else(|| format!("has nothing for vertex {point}"))?;
        values.data.extend(bytes.chunks_exact(size).map(|bytes| component(kind, bytes)));
    }
    Ok(values)
}

/// The bytes of what a vertex has.
fn element(attribute: &PointAttribute, point: u32, size: usize) -> Option<&[u8]> {
    let index = u64::from(attribute.mapped_index(PointIndex(point)).0);
    let start = u64::try_from(attribute.byte_stride()).ok()?.checked_mul(index)?;
    attribute.buffer().data().get(usize::try_from(start).ok()?..)?.get(..size)
}

fn component(kind: DataType, bytes: &[u8]) -> f64 {
    match (kind, bytes) {
        (DataType::Int8, &[a]) => f64::from(a as i8),
        (DataType::Uint8, &[a]) => f64::from(a),
        (DataType::Int16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (DataType::Uint16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (DataType::Int32, &[a, b, c, d]) => f64::from(i32::from_le_bytes([a, b, c, d])),
        (DataType::Uint32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (_, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => unreachable!("chunks have the component's size"),
    }
}
