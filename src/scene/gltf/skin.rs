//! Posing a skinned primitive at the pose that the node tree has.

use glam::{DAffine3, DMat3, DVec3};
use gltf::json::accessor::Type;
use gltf::json::{self, Index};

use super::document::{Document, at};
use super::mesh::{Influences, Primitive};
use crate::scene::gltf::accessor::{Accessors, Format};
use crate::scene::{SceneError, normal_matrix};

const INVERSE_BIND: Format =
    Format { what: "inverseBindMatrices", kinds: &[Type::Mat4], integers: &[], float: true };

/// The matrix of each joint of skin `index`, from the bind pose in mesh space to the world:
/// world transform of the joint times its inverse bind matrix (glTF 2.0, 3.7.3.2).
///
/// # Errors
/// Dangling references, fewer inverse bind matrices than joints, those of [`Accessors::read`].
pub fn joint_matrices(
    document: &Document,
    index: Index<json::Skin>,
    world: &[DAffine3],
    accessors: &Accessors<'_>,
    from: &str,
) -> Result<Vec<DAffine3>, SceneError> {
    let skin = document.get(index, from)?;
    let place = format!("skins[{}]", index.value());
    let mut matrices = Vec::with_capacity(skin.joints.len());
    for &joint in &skin.joints {
        matrices.push(*at(world, joint, &place)?);
    }
    let Some(accessor) = skin.inverse_bind_matrices else { return Ok(matrices) };
    let inverse_binds = accessors.read(accessor, &INVERSE_BIND, &place)?;
    if inverse_binds.len() < matrices.len() {
        return Err(SceneError::invalid(
            place,
            "INVALID_IBM_ACCESSOR_COUNT",
            format!("{} inverse bind matrices for {} joints", inverse_binds.len(), matrices.len()),
        ));
    }
    for (matrix, columns) in matrices.iter_mut().zip(inverse_binds.elements::<16>()) {
        // The fourth row is 0 0 0 1 by definition, so only the affine part is taken.
        let column = |c: usize| DVec3::new(columns[4 * c], columns[4 * c + 1], columns[4 * c + 2]);
        *matrix *= DAffine3::from_cols(column(0), column(1), column(2), column(3));
    }
    Ok(matrices)
}

/// Moves the primitive to where its joints are; afterwards it stands in world space.
/// Triangles that the joints mirror are turned over.
pub fn pose(primitive: &mut Primitive, influences: &Influences, joints: &[DAffine3]) {
    let mut mirrored = vec![false; primitive.positions.len()];
    for (vertex, mirrored) in mirrored.iter_mut().enumerate() {
        let lanes = vertex * influences.lanes..(vertex + 1) * influences.lanes;
        let mut linear = DMat3::ZERO;
        let mut translation = DVec3::ZERO;
        for (&joint, &weight) in influences.joints[lanes.clone()].iter().zip(&influences.weights[lanes]) {
            linear += joints[joint].matrix3 * weight;
            translation += joints[joint].translation * weight;
        }
        *mirrored = linear.determinant() < 0.0;
        let position = &mut primitive.positions[vertex];
        *position = linear * *position + translation;
        if let Some(normals) = &mut primitive.normals {
            normals[vertex] = normal_matrix(linear) * normals[vertex];
        }
        if let Some(tangents) = &mut primitive.tangents {
            let sign = if *mirrored { -tangents[vertex].w } else { tangents[vertex].w };
            tangents[vertex] = (linear * tangents[vertex].truncate()).extend(sign);
        }
    }
    for triangle in &mut primitive.triangles {
        if triangle.iter().filter(|&&vertex| mirrored[vertex as usize]).count() >= 2 {
            triangle.swap(1, 2);
        }
    }
}
