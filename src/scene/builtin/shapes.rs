//! Simple bodies as meshes, and what is needed to place them.
//!
//! Every function returns a mesh without a name and with material 0; [`super::Stage`] gives both. Fronts look outward.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};

use crate::scene::{Camera, Mesh, Projection};

/// A parallelogram with corner `corner` and edges `u`, `v`; its front looks along `u` x `v`. Texture coordinates
/// run from (0, 0) at the corner to (1, 1) opposite.
pub fn quad(corner: DVec3, u: DVec3, v: DVec3) -> Mesh {
    Mesh {
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        uvs: [Some(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]), None],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A grid of `cells[0]` x `cells[1]` squares on the parallelogram of [`quad`], two triangles each, with shared
/// vertices: rows along `v`, columns along `u`.
pub fn grid(corner: DVec3, u: DVec3, v: DVec3, cells: [u32; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    let mut uvs = Vec::new();
    for row in 0..=cells[1] {
        for column in 0..=cells[0] {
            let s = f64::from(column) / f64::from(cells[0]);
            let t = f64::from(row) / f64::from(cells[1]);
            mesh.positions.push(corner + u * s + v * t);
            uvs.push(Vec2::new(s as f32, t as f32));
        }
    }
    let stride = cells[0] + 1;
    for row in 0..cells[1] {
        for column in 0..cells[0] {
            let a = row * stride + column;
            mesh.triangles.push([a, a + 1, a + stride + 1]);
            mesh.triangles.push([a, a + stride + 1, a + stride]);
        }
    }
    mesh.uvs[0] = Some(uvs);
    mesh
}

/// An axis-aligned box from `min` to `max`: 8 shared vertices, 12 triangles, no texture coordinates.
pub fn cuboid(min: DVec3, max: DVec3) -> Mesh {
    let positions = (0..8)
        .map(|corner| {
            let pick = |bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
            DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z))
        })
        .collect();
    // Bit 0 of a corner's number is x, bit 1 is y, bit 2 is z.
    const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A sphere of 20 * 4^`subdivisions` triangles whose vertices lie on it: an icosahedron, halved at every edge.
/// Flat shading; see [`smooth_sphere`].
pub fn icosphere(center: DVec3, radius: f64, subdivisions: u32) -> Mesh {
    let (mut directions, mut triangles) = icosahedron();
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let halfway = (directions[a as usize] + directions[b as usize]).normalize();
                directions.push(halfway);
                directions.len() as u32 - 1
            })
        };
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let positions = directions.iter().map(|&direction| center + direction * radius).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// [`icosphere`] with the sphere's own normals.
pub fn smooth_sphere(center: DVec3, radius: f64, subdivisions: u32) -> Mesh {
    let mut mesh = icosphere(center, radius, subdivisions);
    mesh.normals = Some(mesh.positions.iter().map(|&p| (p - center).normalize().as_vec3()).collect());
    mesh
}

/// The 12 unit vertices and 20 outward triangles of an icosahedron: three golden rectangles.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut vertices = Vec::with_capacity(12);
    for axis in 0..3 {
        for (short, long) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
            let mut vertex = [0.0; 3];
            vertex[axis] = short;
            vertex[(axis + 1) % 3] = long;
            vertices.push(DVec3::from_array(vertex).normalize());
        }
    }
    // Three vertices are a face exactly where all pairs are neighbours; only neighbours are less than 90 degrees apart.
    let is_edge = |a: usize, b: usize| vertices[a].dot(vertices[b]) > 0.0;
    let mut triangles = Vec::with_capacity(20);
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(a, c) {
                    let outward = (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]);
                    let front = outward.dot(vertices[a]) > 0.0;
                    let [a, b, c] = [a as u32, b as u32, c as u32];
                    triangles.push(if front { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    (vertices, triangles)
}

/// The same surface with front and back exchanged.
pub fn flipped(mut mesh: Mesh) -> Mesh {
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    if let Some(normals) = &mut mesh.normals {
        for normal in normals {
            *normal = -*normal;
        }
    }
    mesh
}

/// The mesh turned by `degrees` about the vertical (+y) through `pivot`, counter-clockwise seen from above.
pub fn turned(mut mesh: Mesh, pivot: DVec3, degrees: f64) -> Mesh {
    let turn = DAffine3::from_translation(pivot)
        * DAffine3::from_rotation_y(degrees.to_radians())
        * DAffine3::from_translation(-pivot);
    for position in &mut mesh.positions {
        *position = turn.transform_point3(*position);
    }
    if let Some(normals) = &mut mesh.normals {
        for normal in normals {
            *normal = turn.transform_vector3(normal.as_dvec3()).as_vec3();
        }
    }
    mesh
}

/// A camera at `position` that looks at `target` with +y up; `yfov_degrees` is the full vertical field of view.
/// `target` must not lie straight above or below `position`.
pub fn looking_at(name: &str, position: DVec3, target: DVec3, yfov_degrees: f32) -> Camera {
    let (right, up, forward) = frame_towards((target - position).normalize());
    let projection = Projection::Perspective { yfov: yfov_degrees.to_radians() };
    Camera { name: name.into(), position, right, up, forward, projection }
}

/// Right, up and forward of a camera that looks along the unit vector `forward` with +y up.
pub fn frame_towards(forward: DVec3) -> (Vec3, Vec3, Vec3) {
    let right = forward.cross(DVec3::Y).normalize();
    let basis = DMat3::from_cols(right, right.cross(forward), forward);
    (basis.x_axis.as_vec3(), basis.y_axis.as_vec3(), basis.z_axis.as_vec3())
}
