//! Surfaces that all but touch.
//!
//! Rays step off a surface by 2^-20 of its largest coordinate, and would step over a surface that is nearer than that. Points of
//! surfaces are known better than that only where the surface is along two axes: all its vertices have the same third
//! coordinate, which may be small or have few digits. Where two of those are that near, kernels look closer (feature
//! `thin_gaps`); where others are, the rounding of their vertices is as large as their distance.

use super::AccelTriangle;
use super::coincident::{Boxed, pairs_among};

/// Distance of two surfaces as a share of their largest coordinate below which rays may step over the nearer one: eight
/// steps.
pub(super) const THIN: f32 = 1.0 / (1 << 17) as f32;

/// True where some triangles along two axes are nearly in one plane and side by side, but not in the same one.
pub(super) fn has_thin_gaps(triangles: &[AccelTriangle]) -> bool {
    let boxes = triangles
        .iter()
        .enumerate()
        .filter(|(_, triangle)| flat_axis(triangle).is_some())
        .map(|(index, triangle)| nearly(index, triangle))
        .collect();
    !pairs_among(boxes, &|a, b| is_thin(&triangles[a as usize], &triangles[b as usize])).is_empty()
}

/// A triangle's box with room for what all but touches it.
pub(super) fn nearly(index: usize, triangle: &AccelTriangle) -> Boxed {
    Boxed::new(index, triangle, glam::Vec3::splat(THIN * reach(triangle)))
}

/// The axis along which all vertices have one coordinate.
pub(super) fn flat_axis(triangle: &AccelTriangle) -> Option<usize> {
    let [a, b, c] = triangle.vertices;
    (0..3).find(|&axis| a[axis] == b[axis] && b[axis] == c[axis])
}

fn reach(triangle: &AccelTriangle) -> f32 {
    let [a, b, c] = triangle.vertices.map(glam::Vec3::abs);
    a.max(b).max(c).max_element()
}

/// Of two triangles whose boxes meet.
pub(super) fn is_thin(a: &AccelTriangle, b: &AccelTriangle) -> bool {
    let (Some(axis), Some(other)) = (flat_axis(a), flat_axis(b)) else { return false };
    let gap = (a.vertices[0][axis] - b.vertices[0][axis]).abs();
    axis == other && gap > 0.0 && gap < THIN * reach(a).max(reach(b))
}
