//! Tangents for normal maps, where the file has none: MikkTSpace, as glTF 2.0, 3.7.2.1 asks.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use bevy_mikktspace::{GenerateTangentSpaceError, Geometry, TangentSpace, generate_tangents};
use glam::{DVec2, DVec3, DVec4};

use super::mesh::Primitive;

/// Gives the primitive tangents along the u direction of its uv set `uv_set`, and flat normals first where it
/// has none. Vertices at which triangles disagree are split. Without texture coordinates any tangent will do.
///
/// # Errors
/// Those of MikkTSpace, which has none at present.
pub fn generate(primitive: &mut Primitive, uv_set: usize) -> Result<(), GenerateTangentSpaceError> {
    let corners = Corners::new(primitive, uv_set);
    let tangents = match corners {
        Some(mut corners) => {
            generate_tangents(&mut corners)?;
            corners.tangents
        }
        None => vec![None; 3 * primitive.triangles.len()],
    };
    let flat = primitive.normals.is_none();
    let mut split = Primitive {
        normals: Some(Vec::new()),
        tangents: Some(Vec::new()),
        uvs: primitive.uvs.each_ref().map(|uvs| uvs.as_ref().map(|_| Vec::new())),
        colors: primitive.colors.as_ref().map(|_| Vec::new()),
        ..Primitive::default()
    };
    // A vertex stays one vertex where its corners have the same tangent and, for flat normals, the same face.
    let mut known: HashMap<(u32, [u64; 4], usize), u32> = HashMap::new();
    for (face, triangle) in primitive.triangles.iter().enumerate() {
        let face_normal = face_normal(primitive, triangle);
        let new = std::array::from_fn(|corner| {
            let vertex = triangle[corner];
            let old = vertex as usize;
            let normal = primitive.normals.as_ref().map_or(face_normal, |normals| normals[old]);
            let tangent = tangents[3 * face + corner].unwrap_or_else(|| {
                normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_vector().extend(1.0)
            });
            let key = (vertex, tangent.to_array().map(f64::to_bits), if flat { face } else { 0 });
            match known.entry(key) {
                Entry::Occupied(entry) => *entry.get(),
                Entry::Vacant(entry) => {
                    let index = split.positions.len() as u32;
                    split.push_vertex(primitive, old, normal, tangent);
                    *entry.insert(index)
                }
            }
        });
        split.triangles.push(new);
    }
    *primitive = split;
    Ok(())
}

impl Primitive {
    fn push_vertex(&mut self, from: &Self, vertex: usize, normal: DVec3, tangent: DVec4) {
        self.positions.push(from.positions[vertex]);
        self.normals.get_or_insert_default().push(normal);
        self.tangents.get_or_insert_default().push(tangent);
        for (to, from) in self.uvs.iter_mut().zip(&from.uvs) {
            if let (Some(to), Some(from)) = (to, from) {
                to.push(from[vertex]);
            }
        }
        if let (Some(to), Some(from)) = (&mut self.colors, &from.colors) {
            to.push(from[vertex]);
        }
    }
}

fn face_normal(primitive: &Primitive, triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|vertex| primitive.positions[vertex as usize]);
    (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Z)
}

/// The triangle corners as MikkTSpace wants to see them. Positions are moved and scaled to the unit box:
/// tangents do not depend on that, and `f32` then holds them well.
struct Corners<'a> {
    primitive: &'a Primitive,
    uvs: &'a [DVec2],
    center: DVec3,
    inv_extent: f64,
    tangents: Vec<Option<DVec4>>,
}

impl<'a> Corners<'a> {
    fn new(primitive: &'a Primitive, uv_set: usize) -> Option<Self> {
        let uvs = primitive.uvs[uv_set].as_deref()?;
        let (low, high) = primitive
            .positions
            .iter()
            .fold((DVec3::MAX, DVec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
        let extent = (high - low).max_element();
        let inv_extent = if extent > 0.0 { 1.0 / extent } else { 1.0 };
        let tangents = vec![None; 3 * primitive.triangles.len()];
        Some(Self { primitive, uvs, center: 0.5 * low + 0.5 * high, inv_extent, tangents })
    }

    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        let position = self.primitive.positions[self.vertex(face, corner)];
        ((position - self.center) * self.inv_extent).as_vec3().to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let normal = match &self.primitive.normals {
            Some(normals) => normals[self.vertex(face, corner)].try_normalize().unwrap_or(DVec3::Z),
            None => face_normal(self.primitive, &self.primitive.triangles[face]),
        };
        normal.as_vec3().to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)].as_vec2().to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        // MikkTSpace's bitangent runs along +v, glTF's along the picture's up, which is -v.
        self.tangents[3 * face + corner] = tangent.map(|tangent| {
            let [x, y, z, w] = tangent.tangent_encoded().map(f64::from);
            DVec4::new(x, y, z, -w)
        });
    }
}
