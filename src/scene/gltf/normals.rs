//! Normals that point to the back of their triangles.

use std::collections::HashMap;

use super::mesh::Primitive;

/// Turns normals round where all three of a triangle point to its back; returns how many triangles that are. Vertices
/// that other triangles have with another side get copies. The bitangents of normal maps stay.
pub fn turn_to_front(primitive: &mut Primitive) -> usize {
    let Some(normals) = &primitive.normals else { return 0 };
    // 1: the front, -1: the back, 0: on neither, or not the same for all corners.
    let side = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| primitive.positions[vertex as usize]);
        let face = (b - a).cross(c - a);
        let [a, b, c] = triangle.map(|vertex| face.dot(normals[vertex as usize]));
        i32::from(a > 0.0 && b > 0.0 && c > 0.0) - i32::from(a < 0.0 && b < 0.0 && c < 0.0)
    };
    let sides: Vec<i32> = primitive.triangles.iter().map(side).collect();
    let count = sides.iter().filter(|side| **side < 0).count();
    if count == 0 {
        return 0;
    }
    let mut stays = vec![false; primitive.positions.len()];
    let kept = primitive.triangles.iter().zip(&sides).filter(|(_, side)| **side >= 0);
    kept.for_each(|(triangle, _)| triangle.iter().for_each(|&vertex| stays[vertex as usize] = true));
    let mut turned = HashMap::new();
    for (index, _) in sides.iter().enumerate().filter(|(_, side)| **side < 0) {
        primitive.triangles[index] = primitive.triangles[index].map(|vertex| {
            *turned.entry(vertex).or_insert_with(|| {
                let own = if stays[vertex as usize] { repeat(primitive, vertex) } else { vertex };
                turn(primitive, own as usize);
                own
            })
        });
    }
    count
}

/// Adds a copy of a vertex; returns its index.
fn repeat(primitive: &mut Primitive, vertex: u32) -> u32 {
    fn again<T: Copy>(values: &mut Option<Vec<T>>, vertex: u32) {
        if let Some(values) = values {
            values.push(values[vertex as usize]);
        }
    }
    primitive.positions.push(primitive.positions[vertex as usize]);
    again(&mut primitive.normals, vertex);
    again(&mut primitive.tangents, vertex);
    primitive.uvs.iter_mut().for_each(|uvs| again(uvs, vertex));
    again(&mut primitive.colors, vertex);
    primitive.positions.len() as u32 - 1
}

fn turn(primitive: &mut Primitive, vertex: usize) {
    if let Some(normals) = &mut primitive.normals {
        normals[vertex] = -normals[vertex];
    }
    // The bitangent is sign * normal x tangent.
    if let Some(tangents) = &mut primitive.tangents {
        tangents[vertex].w = -tangents[vertex].w;
    }
}
