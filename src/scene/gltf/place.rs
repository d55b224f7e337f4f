//! From mesh space to world space.

use glam::{DAffine3, DVec3, Vec3, Vec4};

use super::mesh::Primitive;
use crate::scene::{Instance, Mesh, SceneError, normal_matrix};

/// Gives vertices whose normal has no length the area-weighted normal of their triangles; returns how many.
pub fn repair_normals(primitive: &mut Primitive) -> usize {
    let Some(normals) = &mut primitive.normals else { return 0 };
    let broken: Vec<bool> = normals.iter().map(|normal| normal.try_normalize().is_none()).collect();
    let count = broken.iter().filter(|broken| **broken).count();
    if count == 0 {
        return 0;
    }
    for triangle in &primitive.triangles {
        let [a, b, c] = triangle.map(|vertex| primitive.positions[vertex as usize]);
        let face = (b - a).cross(c - a);
        for &vertex in triangle {
            if broken[vertex as usize] {
                normals[vertex as usize] += face;
            }
        }
    }
    count
}

/// The primitive as a mesh of the scene, moved by `transform`. A mirroring transform turns windings over,
/// so that fronts stay fronts.
///
/// # Errors
/// Positions or texture coordinates that the transform or single precision make infinite.
pub fn place(
    primitive: &Primitive,
    transform: &DAffine3,
    name: &str,
    material: u32,
) -> Result<Mesh, SceneError> {
    let overflow = || SceneError::invalid(name, "VALUE_NOT_IN_RANGE", "a vertex lies at infinity");
    let linear = transform.matrix3;
    let mirrored = linear.determinant() < 0.0;
    let positions: Vec<DVec3> = primitive.positions.iter().map(|p| transform.transform_point3(*p)).collect();
    if !positions.iter().all(|p| p.is_finite()) {
        return Err(overflow());
    }
    let normal_matrix = normal_matrix(linear);
    let normals: Option<Vec<Vec3>> = primitive.normals.as_ref().map(|normals| {
        normals.iter().map(|n| (normal_matrix * *n).try_normalize().unwrap_or(DVec3::Z).as_vec3()).collect()
    });
    let tangents = match (&primitive.tangents, &normals) {
        (Some(tangents), Some(normals)) => {
            let place = |(tangent, normal): (&glam::DVec4, &Vec3)| -> Vec4 {
                let sign = if (tangent.w < 0.0) != mirrored { -1.0 } else { 1.0 };
                let direction = (linear * tangent.truncate()).try_normalize();
                direction.map_or_else(|| normal.any_orthonormal_vector(), |d| d.as_vec3()).extend(sign)
            };
            Some(tangents.iter().zip(normals).map(place).collect())
        }
        _ => None,
    };
    let mut uvs = [None, None];
    for (out, uvs) in uvs.iter_mut().zip(&primitive.uvs) {
        let narrow: Option<Vec<_>> = uvs.as_ref().map(|uvs| uvs.iter().map(|uv| uv.as_vec2()).collect());
        if narrow.iter().flatten().any(|uv| !uv.is_finite()) {
            return Err(overflow());
        }
        *out = narrow;
    }
    let flip = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    Ok(Mesh {
        name: name.into(),
        material,
        positions,
        normals,
        tangents,
        uvs,
        colors: primitive.colors.as_ref().map(|colors| colors.iter().map(|c| c.as_vec4()).collect()),
        triangles: primitive.triangles.iter().map(flip).collect(),
        instances: Vec::new(),
    })
}

/// The primitive as a mesh of the scene in its own space, shown at `instances`.
///
/// # Errors
/// As [`place`].
pub fn share(
    primitive: &Primitive,
    name: &str,
    material: u32,
    instances: Vec<Instance>,
) -> Result<Mesh, SceneError> {
    let mesh = Mesh { instances, ..place(primitive, &DAffine3::IDENTITY, name, material)? };
    let is_finite = mesh.world_positions().all(|position| position.is_finite());
    let overflow = || SceneError::invalid(name, "VALUE_NOT_IN_RANGE", "a vertex lies at infinity");
    is_finite.then_some(mesh).ok_or_else(overflow)
}
