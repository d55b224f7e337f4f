//! For each triangle, which others of its plane are in front of it: a table for the kernels.
//!
//! Words. A triangle's `cover` is the index of a header of two, the blocks of its front and of its back. A block has
//! n, then n^2 + 1 indices, the limits of the entries of n x n cells, then the entries: indices of triangles, the one
//! in front of all others first. Cells divide the triangle's barycentric coordinates (of its second and third vertex,
//! columns and rows) so that no point has to look at many. 0 is the cover of a triangle that nothing is in front of.
//! See `shaders/lib/coincident.wgsl`.

use std::collections::BTreeMap;

use glam::DVec2;

use super::AccelTriangle;
use super::coincident::{Overlap, Precedence, clipped, normal, plane_axes};

/// A block without entries; its offset in the table.
const EMPTY: u32 = 1;
/// Cells along one side of a triangle.
const MOST_CELLS: u32 = 256;
/// Room for the rounding of a hit's barycentric coordinates at the limits of cells.
const CELL_ROOM: f64 = 1.0 / 4096.0;

/// Sets each triangle's `cover`, and returns the table; empty where nothing is in front of anything.
pub(super) fn covers(
    triangles: &mut [AccelTriangle],
    overlaps: &[Overlap],
    precedence: &Precedence,
) -> Vec<u32> {
    if overlaps.is_empty() {
        return Vec::new();
    }
    // Of each triangle, on its front and on its back: what is in front of it.
    let mut in_front: BTreeMap<u32, [Vec<u32>; 2]> = BTreeMap::new();
    for &[a, b] in overlaps {
        for (covered, other) in [(a, b), (b, a)] {
            for (side, front) in [true, false].into_iter().enumerate() {
                let pair = [other, covered].map(|index| &triangles[index as usize]);
                if precedence.order(pair, (pair[1], front)).is_lt() {
                    in_front.entry(covered).or_default()[side].push(other);
                }
            }
        }
    }
    let mut table = vec![0, 1, EMPTY + 3, EMPTY + 3];
    for (covered, mut sides) in in_front {
        for (side, front) in sides.iter_mut().zip([true, false]) {
            let seen = (&triangles[covered as usize], front);
            side.sort_by(|&a, &b| precedence.order([a, b].map(|index| &triangles[index as usize]), seen));
        }
        let header = table.len() as u32;
        table.extend([EMPTY, EMPTY]);
        for (side, entries) in sides.iter().enumerate() {
            if side == 1 && sides[0] == sides[1] {
                table[header as usize + 1] = table[header as usize];
            } else if !entries.is_empty() {
                table[header as usize + side] = table.len() as u32;
                add_block(&mut table, triangles, covered, entries);
            }
        }
        triangles[covered as usize].cover = header;
    }
    table
}

fn add_block(table: &mut Vec<u32>, triangles: &[AccelTriangle], covered: u32, entries: &[u32]) {
    let cells = ((entries.len() as f64 / 4.0).sqrt().ceil() as u32).clamp(1, MOST_CELLS);
    let boxes: Vec<[DVec2; 2]> = entries
        .iter()
        .map(|&entry| barycentric_box(&triangles[covered as usize], &triangles[entry as usize]))
        .collect();
    let mut rows: Vec<Vec<u32>> = vec![Vec::new(); (cells * cells) as usize];
    for (&entry, [low, high]) in entries.iter().zip(boxes) {
        let cell = |at: f64| ((at * f64::from(cells)) as u32).min(cells - 1);
        for row in cell(low.y)..=cell(high.y) {
            for column in cell(low.x)..=cell(high.x) {
                rows[(row * cells + column) as usize].push(entry);
            }
        }
    }
    table.push(cells);
    let mut limit = table.len() as u32 + cells * cells + 1;
    table.push(limit);
    for cell in &rows {
        limit += cell.len() as u32;
        table.push(limit);
    }
    rows.iter().for_each(|cell| table.extend(cell));
}

/// The box around what two triangles share, in barycentric coordinates of the first.
fn barycentric_box(triangle: &AccelTriangle, other: &AccelTriangle) -> [DVec2; 2] {
    let turned = plane_axes(normal(triangle));
    let [corners, others] = [triangle, other].map(|t| t.vertices.map(|vertex| turned(vertex.as_dvec3())));
    let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let inv_area = 1.0 / e1.perp_dot(e2);
    let shared = clipped(&others, &corners);
    let shared = shared.iter().map(|&point| {
        let from = point - corners[0];
        DVec2::new(from.perp_dot(e2), e1.perp_dot(from)) * inv_area
    });
    let (low, high) = shared.fold((DVec2::ONE, DVec2::ZERO), |(low, high), at| (low.min(at), high.max(at)));
    [(low - CELL_ROOM).max(DVec2::ZERO), (high + CELL_ROOM).min(DVec2::ONE)]
}
