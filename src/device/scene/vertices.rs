//! What vertices carry beside positions, interleaved; only the parts some mesh of the scene needs.

use glam::DVec3;

use super::{ITEMS_AT_ONCE, Target};
use crate::accel::Accel;
use crate::device::pages::PageWriter;
use crate::device::{DeviceError, PagedBuffer};
use crate::scene::{Mesh, Scene, SceneFeatures};

/// Numbers of a vertex that a scene with these features has: names of their offsets, whether they are there, how many.
fn parts(features: &SceneFeatures) -> [(&'static str, bool, u32); 5] {
    [
        ("NORMAL_OFFSET", has_normals(features), 3),
        ("UV0_OFFSET", features.uv0, 2),
        ("UV1_OFFSET", features.uv1, 2),
        ("TANGENT_OFFSET", features.normal_map, 4),
        ("COLOR_OFFSET", features.vertex_colors, 4),
    ]
}

fn has_normals(features: &SceneFeatures) -> bool {
    features.normals || features.normal_map
}

/// Numbers of a vertex.
pub(super) fn stride(features: &SceneFeatures) -> u32 {
    parts(features).iter().filter(|(_, present, _)| *present).map(|(_, _, size)| size).sum()
}

/// Meshes without normals among meshes with them keep their flat look: their corners are no longer shared.
fn is_flat(mesh: &Mesh, features: &SceneFeatures) -> bool {
    has_normals(features) && mesh.normals.is_none()
}

/// Vertices that the device has of a mesh.
pub(super) fn vertex_count(mesh: &Mesh, features: &SceneFeatures) -> usize {
    if is_flat(mesh, features) { mesh.triangles.len() * 3 } else { mesh.positions.len() }
}

/// Uploads `corner_vertices` and `vertex_attributes`, and names the offsets.
pub(super) fn upload(
    target: &mut Target<'_>,
    scene: &Scene,
    accel: &Accel,
    features: &SceneFeatures,
) -> Result<(), DeviceError> {
    let mut stride = 0;
    for (name, present, size) in parts(features) {
        if present {
            target.constants.push((name, f64::from(stride)));
            stride += size;
        }
    }
    target.constants.push(("ATTRIBUTE_STRIDE", f64::from(stride)));

    let counts = scene.meshes.iter().map(|mesh| vertex_count(mesh, features) as u64);
    let numbers = counts.clone().sum::<u64>() * u64::from(stride);
    let buffer = PagedBuffer::VertexAttributes;
    let mut writer = PageWriter::new(target.context, &mut target.buffers, buffer, numbers)?;
    let mut data: Vec<f32> = Vec::new();
    for mesh in &scene.meshes {
        if is_flat(mesh, features) {
            for triangles in mesh.triangles.chunks(ITEMS_AT_ONCE) {
                for triangle in triangles {
                    let normal = face_normal(mesh, triangle);
                    triangle
                        .iter()
                        .for_each(|&vertex| push(&mut data, mesh, vertex as usize, Some(normal), features));
                }
                writer.push(&data)?;
                data.clear();
            }
        } else {
            for first in (0..mesh.positions.len()).step_by(ITEMS_AT_ONCE) {
                let end = mesh.positions.len().min(first + ITEMS_AT_ONCE);
                (first..end).for_each(|vertex| push(&mut data, mesh, vertex, None, features));
                writer.push(&data)?;
                data.clear();
            }
        }
    }
    writer.finish(&mut target.pages, &mut target.constants);

    let mut end = 0;
    let first_vertex: Vec<u32> = counts
        .map(|count| {
            end += count;
            (end - count) as u32
        })
        .collect();
    target.upload_by(PagedBuffer::CornerVertices, accel.triangles.len(), 3, |range, words| {
        for triangle in &accel.triangles[range] {
            let mesh = &scene.meshes[triangle.mesh as usize];
            let vertex = |corner: u8| {
                if is_flat(mesh, features) {
                    triangle.triangle * 3 + u32::from(corner)
                } else {
                    mesh.triangles[triangle.triangle as usize][corner as usize]
                }
            };
            let first = first_vertex[triangle.mesh as usize];
            words.extend(triangle.corners.map(|corner| first + vertex(corner)));
        }
    })
}

fn face_normal(mesh: &Mesh, triangle: &[u32; 3]) -> [f32; 3] {
    let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
    let (e1, e2) = (b - a, c - a);
    let size = e1.abs().max(e2.abs()).max_element();
    (e1 / size).cross(e2 / size).try_normalize().unwrap_or(DVec3::ZERO).as_vec3().to_array()
}

fn push(data: &mut Vec<f32>, mesh: &Mesh, vertex: usize, face: Option<[f32; 3]>, features: &SceneFeatures) {
    if has_normals(features) {
        let normal = mesh.normals.as_ref().map(|normals| normals[vertex].to_array());
        data.extend(normal.or(face).unwrap_or([0.0; 3]));
    }
    for (set, present) in [features.uv0, features.uv1].into_iter().enumerate() {
        if present {
            data.extend(mesh.uvs[set].as_ref().map_or([0.0; 2], |uvs| uvs[vertex].to_array()));
        }
    }
    if features.normal_map {
        // A mesh without tangents has no normal map, so this is never read.
        data.extend(
            mesh.tangents.as_ref().map_or([1.0, 0.0, 0.0, 1.0], |tangents| tangents[vertex].to_array()),
        );
    }
    if features.vertex_colors {
        data.extend(mesh.colors.as_ref().map_or([1.0; 4], |colors| colors[vertex].to_array()));
    }
}
