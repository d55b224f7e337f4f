//! What vertices carry beside positions, interleaved; only the parts some mesh of the scene needs.

use glam::DVec3;

use crate::accel::Accel;
use crate::device::{BufferTable, Context, DeviceError};
use crate::scene::{Mesh, Scene, SceneFeatures};

/// Uploads `corner_vertices` and `vertex_attributes`, and names the offsets.
pub(super) fn upload(
    context: &Context,
    buffers: &mut BufferTable,
    constants: &mut Vec<(&'static str, f64)>,
    scene: &Scene,
    accel: &Accel,
    features: &SceneFeatures,
) -> Result<(), DeviceError> {
    let parts = [
        ("NORMAL_OFFSET", features.normals || features.normal_map, 3),
        ("UV0_OFFSET", features.uv0, 2),
        ("UV1_OFFSET", features.uv1, 2),
        ("TANGENT_OFFSET", features.normal_map, 4),
        ("COLOR_OFFSET", features.vertex_colors, 4),
    ];
    let mut stride = 0;
    for (name, present, size) in parts {
        if present {
            constants.push((name, f64::from(stride)));
            stride += size;
        }
    }
    constants.push(("ATTRIBUTE_STRIDE", f64::from(stride)));

    // Meshes without normals among meshes with them keep their flat look: their corners are no longer shared.
    let flat = |mesh: &Mesh| parts[0].1 && mesh.normals.is_none();
    let mut first_vertex = Vec::with_capacity(scene.meshes.len());
    let mut data: Vec<f32> = Vec::new();
    let mut count = 0u32;
    for mesh in &scene.meshes {
        first_vertex.push(count);
        if flat(mesh) {
            for triangle in &mesh.triangles {
                let normal = face_normal(mesh, triangle);
                triangle
                    .iter()
                    .for_each(|&vertex| push(&mut data, mesh, vertex as usize, Some(normal), features));
            }
            count += mesh.triangles.len() as u32 * 3;
        } else {
            (0..mesh.positions.len()).for_each(|vertex| push(&mut data, mesh, vertex, None, features));
            count += mesh.positions.len() as u32;
        }
    }
    let corner_vertices: Vec<u32> = accel
        .triangles
        .iter()
        .flat_map(|triangle| {
            let mesh = &scene.meshes[triangle.mesh as usize];
            let first = first_vertex[triangle.mesh as usize];
            triangle.corners.map(|corner| {
                first
                    + if flat(mesh) {
                        triangle.triangle * 3 + u32::from(corner)
                    } else {
                        mesh.triangles[triangle.triangle as usize][corner as usize]
                    }
            })
        })
        .collect();
    buffers.upload(context, "corner_vertices", &corner_vertices)?;
    buffers.upload(context, "vertex_attributes", &data)
}

fn face_normal(mesh: &Mesh, triangle: &[u32; 3]) -> [f32; 3] {
    let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
    let (e1, e2) = (b - a, c - a);
    let size = e1.abs().max(e2.abs()).max_element();
    (e1 / size).cross(e2 / size).try_normalize().unwrap_or(DVec3::ZERO).as_vec3().to_array()
}

fn push(data: &mut Vec<f32>, mesh: &Mesh, vertex: usize, face: Option<[f32; 3]>, features: &SceneFeatures) {
    if features.normals || features.normal_map {
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
