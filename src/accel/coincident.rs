//! Surfaces that lie in one another: which of them is there.
//!
//! Where two surfaces share a plane, rounding would decide anew for each ray which of them it meets, and lights would
//! be sampled at points that no ray meets. So one of them is in front, on either side, for all rays and strategies:
//! what shines there before what does not, then what may be absent, then what is opaque, then the smaller mesh, and
//! last an order of the contents that does not depend on the file's.

use std::cmp::Ordering;
use std::hash::{DefaultHasher, Hasher};

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::AccelTriangle;
use crate::math::color::luminance;
use crate::scene::{AlphaMode, Mesh, Scene};

/// Two triangles of a list that share a plane and some of its area.
pub(super) type Overlap = [u32; 2];

/// What decides between meshes in one plane.
struct Standing {
    /// Luminance emitted to the front and to the back.
    emission: [f32; 2],
    may_be_absent: bool,
    transmits: bool,
    area: f64,
    content: [f32; 10],
}

impl Standing {
    fn of(scene: &Scene, mesh: &Mesh, area: f64) -> Self {
        let material = &scene.materials[mesh.material as usize];
        let emission = luminance(if material.unlit { material.base_color } else { material.emission });
        let [r, g, b] = material.base_color.to_array();
        let [sr, sg, sb] = material.specular_color.to_array();
        Self {
            emission: [emission, if material.double_sided { emission } else { 0.0 }],
            may_be_absent: material.alpha_mode != AlphaMode::Opaque,
            transmits: material.transmission > 0.0,
            area,
            content: [
                r,
                g,
                b,
                material.alpha,
                material.metallic,
                material.roughness,
                material.transmission,
                sr * material.specular,
                sg * material.specular,
                sb * material.specular,
            ],
        }
    }

    /// The standing on one of the sides: less is in front.
    fn order(&self, front: bool, other: &Self, other_front: bool) -> Ordering {
        let towards = |standing: &Self, front: bool| standing.emission[usize::from(!front)];
        let brightest = |standing: &Self| standing.emission[0].max(standing.emission[1]);
        let content = || {
            let pairs = self.content.iter().zip(&other.content);
            pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        };
        towards(other, other_front)
            .total_cmp(&towards(self, front))
            // Where neither shines, what is no lamp at all is rather meant to be seen than a lamp's back.
            .then((brightest(self) > 0.0).cmp(&(brightest(other) > 0.0)))
            .then(brightest(other).total_cmp(&brightest(self)))
            .then(other.may_be_absent.cmp(&self.may_be_absent))
            .then(self.transmits.cmp(&other.transmits))
            .then((self.area as f32).total_cmp(&(other.area as f32)))
            .then_with(content)
    }
}

/// Which of two triangles in one plane is in front.
pub(super) struct Precedence(Vec<Standing>);

impl Precedence {
    pub fn new(scene: &Scene, triangles: &[AccelTriangle]) -> Self {
        let mut areas = vec![0.0; scene.meshes.len()];
        triangles.iter().for_each(|triangle| areas[triangle.mesh as usize] += area(triangle));
        Self(scene.meshes.iter().zip(areas).map(|(mesh, area)| Standing::of(scene, mesh, area)).collect())
    }

    /// Less where `a` hides `b` for those who look at a third triangle's front or its back; all share a plane. Never
    /// equal for two triangles.
    pub fn order(&self, [a, b]: [&AccelTriangle; 2], (seen, front): (&AccelTriangle, bool)) -> Ordering {
        let [a_standing, b_standing] = [a, b].map(|triangle| &self.0[triangle.mesh as usize]);
        let side = |triangle: &AccelTriangle| front == (normal(triangle).dot(normal(seen)) > 0.0);
        a_standing
            .order(side(a), b_standing, side(b))
            .then_with(|| bits(a).cmp(&bits(b)))
            .then(a.flipped.cmp(&b.flipped))
            .then((a.mesh, a.triangle).cmp(&(b.mesh, b.triangle)))
    }

    /// True where the triangle hides all that is behind it.
    fn is_solid(&self, triangle: &AccelTriangle) -> bool {
        !self.0[triangle.mesh as usize].may_be_absent
    }

    pub fn emits(&self, triangle: &AccelTriangle) -> bool {
        self.0[triangle.mesh as usize].emission[0] > 0.0
    }
}

/// The vertices' bits, in an order that does not depend on anything else.
fn bits(triangle: &AccelTriangle) -> [u32; 9] {
    let [a, b, c] = triangle.vertices.map(|vertex| vertex.to_array().map(f32::to_bits));
    [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
}

/// True where the same mesh's or an equal mesh's face stands twice: equal material, side and attributes.
fn is_duplicate(scene: &Scene, a: &AccelTriangle, b: &AccelTriangle) -> bool {
    let of = |triangle: &AccelTriangle| {
        let mesh = &scene.meshes[triangle.mesh as usize];
        let corners = mesh.triangles[triangle.triangle as usize];
        (mesh, triangle.corners.map(|corner| corners[corner as usize] as usize))
    };
    let ((mesh_a, corners_a), (mesh_b, corners_b)) = (of(a), of(b));
    fn same<T: PartialEq>(a: Option<&Vec<T>>, b: Option<&Vec<T>>, corners: [[usize; 3]; 2]) -> bool {
        match (a, b) {
            (Some(a), Some(b)) => corners[0].iter().zip(&corners[1]).all(|(&i, &j)| a[i] == b[j]),
            (None, None) => true,
            _ => false,
        }
    }
    let corners = [corners_a, corners_b];
    mesh_a.material == mesh_b.material
        && a.flipped == b.flipped
        && same(mesh_a.normals.as_ref(), mesh_b.normals.as_ref(), corners)
        && same(mesh_a.tangents.as_ref(), mesh_b.tangents.as_ref(), corners)
        && same(mesh_a.colors.as_ref(), mesh_b.colors.as_ref(), corners)
        && (0..2).all(|set| same(mesh_a.uvs[set].as_ref(), mesh_b.uvs[set].as_ref(), corners))
}

/// Indices of triangles that no ray can meet: another one of the same vertices is the same, or hides both sides.
pub(super) fn hidden(scene: &Scene, precedence: &Precedence, triangles: &[AccelTriangle]) -> Vec<u32> {
    let mut keys: Vec<(u64, u32)> = triangles
        .par_iter()
        .enumerate()
        .map(|(index, triangle)| {
            let mut hasher = DefaultHasher::new();
            bits(triangle).iter().for_each(|&word| hasher.write_u32(word));
            (hasher.finish(), index as u32)
        })
        .collect();
    keys.par_sort_unstable();
    let mut hidden = Vec::new();
    for same_key in keys.chunk_by(|a, b| a.0 == b.0).filter(|keys| keys.len() > 1) {
        let mut group: Vec<u32> = same_key.iter().map(|key| key.1).collect();
        let of = |index: u32| &triangles[index as usize];
        group.sort_by_key(|&a| bits(of(a)));
        for same in group.chunk_by_mut(|&a, &b| bits(of(a)) == bits(of(b))) {
            let mut kept: Vec<u32> = same.to_vec();
            for is_upper in [true, false] {
                // The upper side is where triangles that are not flipped have their front.
                let first = of(same[0]);
                let side = (first, is_upper != first.flipped);
                same.sort_by(|&a, &b| precedence.order([of(a), of(b)], side));
                let solid = same.iter().position(|&index| precedence.is_solid(of(index)));
                let seen = &same[..solid.map_or(same.len(), |solid| solid + 1)];
                let twice = |pair: &[u32]| is_duplicate(scene, of(pair[0]), of(pair[1])).then_some(pair[1]);
                let twice: Vec<u32> = seen.windows(2).filter_map(twice).collect();
                // What is seen from neither side goes.
                kept.retain(|index| !seen.contains(index) || twice.contains(index));
            }
            hidden.append(&mut kept);
        }
    }
    hidden.sort_unstable();
    hidden
}

/// A triangle's box, a little larger than its vertices' rounding.
#[derive(Clone, Copy)]
pub(super) struct Boxed {
    low: Vec3,
    high: Vec3,
    index: u32,
}

impl Boxed {
    /// With `room` on all sides.
    pub fn new(index: usize, triangle: &AccelTriangle, room: Vec3) -> Self {
        let [a, b, c] = triangle.vertices;
        Self::around(index, a.min(b).min(c) - room, a.max(b).max(c) + room)
    }

    /// From `low` to `high`.
    pub fn around(index: usize, low: Vec3, high: Vec3) -> Self {
        Self { low, high, index: index as u32 }
    }

    /// The same box by another index.
    pub fn numbered(self, index: usize) -> Self {
        Self { index: index as u32, ..self }
    }

    /// The box around boxes; that of none meets none.
    pub fn union(boxes: impl Iterator<Item = Self>) -> Self {
        let none = Self::around(0, Vec3::MAX, Vec3::MIN);
        boxes.fold(none, |all, one| Self { low: all.low.min(one.low), high: all.high.max(one.high), ..all })
    }

    pub fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// How far rounding may have moved a vertex, for each axis: of the file's numbers and of unit space, at both
/// triangles, and some room for planes that are extended beyond their triangle.
pub(super) fn rounding(triangle: &AccelTriangle) -> Vec3 {
    let [a, b, c] = triangle.vertices.map(Vec3::abs);
    a.max(b).max(c) * 2f32.powi(-21)
}

/// All pairs of triangles that share a plane, to within rounding, and some of its area.
pub(super) fn overlaps(triangles: &[AccelTriangle]) -> Vec<Overlap> {
    let boxes = triangles
        .par_iter()
        .enumerate()
        .filter(|(_, triangle)| !triangle.is_entry())
        .map(|(index, triangle)| Boxed::new(index, triangle, rounding(triangle)))
        .collect();
    pairs_among(boxes, &|a, b| share_plane(&triangles[a as usize], &triangles[b as usize]))
}

/// All pairs of indices whose boxes meet and that pass a test; the lower one first, sorted.
pub(super) fn pairs_among(boxes: Vec<Boxed>, test: &(impl Fn(u32, u32) -> bool + Sync)) -> Vec<Overlap> {
    let mut overlaps = overlaps_among(boxes, test);
    overlaps.sort_unstable();
    overlaps.dedup();
    overlaps
}

/// Halves space as long as that separates the boxes, then compares all with all.
fn overlaps_among(boxes: Vec<Boxed>, test: &(impl Fn(u32, u32) -> bool + Sync)) -> Vec<Overlap> {
    const FEW: usize = 12;
    let half = if boxes.len() > FEW { halves(&boxes) } else { None };
    let Some((lower, upper)) = half else {
        return pairs(&boxes, test);
    };
    drop(boxes);
    let (mut overlaps, more) = rayon::join(|| overlaps_among(lower, test), || overlaps_among(upper, test));
    overlaps.extend(more);
    overlaps
}

/// The boxes that reach below and above the middle of their centres along the axis that separates most; `None` where
/// nearly all reach to both sides.
fn halves(boxes: &[Boxed]) -> Option<(Vec<Boxed>, Vec<Boxed>)> {
    let centre = |b: &Boxed| 0.5 * (b.low + b.high);
    let middle = boxes.iter().map(|b| centre(b).as_dvec3()).sum::<DVec3>() / boxes.len() as f64;
    let middle = middle.as_vec3();
    let (mut lower, mut upper) = ([0; 3], [0; 3]);
    for b in boxes {
        for axis in 0..3 {
            lower[axis] += usize::from(b.low[axis] <= middle[axis]);
            upper[axis] += usize::from(b.high[axis] >= middle[axis]);
        }
    }
    let axis = (0..3).min_by_key(|&axis| lower[axis].max(upper[axis]))?;
    // As long as each half is a tenth smaller this ends after a few dozen levels.
    if 10 * lower[axis].max(upper[axis]) > 9 * boxes.len() {
        return None;
    }
    let reaching = |test: &dyn Fn(&Boxed) -> bool| boxes.iter().copied().filter(test).collect::<Vec<_>>();
    Some((reaching(&|b| b.low[axis] <= middle[axis]), reaching(&|b| b.high[axis] >= middle[axis])))
}

fn pairs(boxes: &[Boxed], test: &impl Fn(u32, u32) -> bool) -> Vec<Overlap> {
    let mut overlaps = Vec::new();
    for (i, a) in boxes.iter().enumerate() {
        for b in &boxes[i + 1..] {
            if a.meets(b) {
                let (a, b) = (a.index.min(b.index), a.index.max(b.index));
                if test(a, b) {
                    overlaps.push([a, b]);
                }
            }
        }
    }
    overlaps
}

/// Twice the area times the unit normal of the front, in f64.
pub(super) fn normal(triangle: &AccelTriangle) -> DVec3 {
    let [a, b, c] = triangle.vertices.map(|vertex| vertex.as_dvec3());
    let normal = (b - a).cross(c - a);
    if triangle.flipped { -normal } else { normal }
}

fn area(triangle: &AccelTriangle) -> f64 {
    0.5 * normal(triangle).length()
}

/// True where one of two triangles may lie in the plane of the other, to within `room`, and they share some area: whatever
/// a linear map does to both, `share_plane` finds no more.
pub(super) fn may_share_plane(a: &AccelTriangle, b: &AccelTriangle, room: f64) -> bool {
    const NO_AREA: f64 = 1.0 / 1048576.0;
    let lies_in = |small: &AccelTriangle, large: &AccelTriangle| {
        let unit = normal(large).normalize();
        let base = large.vertices[0].as_dvec3();
        if small.vertices.iter().any(|vertex| unit.dot(vertex.as_dvec3() - base).abs() > room) {
            return false;
        }
        let turned = plane_axes(unit);
        let [small, large] = [small, large].map(|triangle| triangle.vertices.map(|v| turned(v.as_dvec3())));
        polygon_area(&clipped(&small, &large)).abs() > NO_AREA * polygon_area(&small).abs()
    };
    lies_in(a, b) || lies_in(b, a)
}

/// True where two triangles lie in one plane, to within rounding, and share some area.
pub(super) fn share_plane(a: &AccelTriangle, b: &AccelTriangle) -> bool {
    // Planes that rounding cannot tell from one another are hardly turned, unless the triangle is as small as that.
    const PARALLEL: f64 = 0.99;
    let (normal_a, normal_b) = (normal(a), normal(b));
    let (size_a, size_b) = (normal_a.length(), normal_b.length());
    let cosine = normal_a.dot(normal_b) / (size_a * size_b);
    if cosine.abs() < PARALLEL {
        return false;
    }
    // The plane of the larger one is known better.
    let (small, large, unit) =
        if size_a < size_b { (a, b, normal_b / size_b) } else { (b, a, normal_a / size_a) };
    let room = unit.abs().dot(rounding(a).max(rounding(b)).as_dvec3());
    let base = large.vertices[0].as_dvec3();
    if small.vertices.iter().any(|vertex| unit.dot(vertex.as_dvec3() - base).abs() > room) {
        return false;
    }
    // Neighbours in one plane share an edge, which rounding may give some area.
    const NO_AREA: f64 = 1.0 / 65536.0;
    let turned = plane_axes(unit);
    let [small, large] = [small, large].map(|triangle| triangle.vertices.map(|v| turned(v.as_dvec3())));
    let common = polygon_area(&clipped(&small, &large)).abs();
    common > NO_AREA * polygon_area(&small).abs()
}

/// The two coordinates in which a plane with that normal is seen largest.
pub(super) fn plane_axes(normal: DVec3) -> impl Fn(DVec3) -> DVec2 {
    let axis = normal.abs().max_position();
    move |point| DVec2::new(point[(axis + 1) % 3], point[(axis + 2) % 3])
}

fn polygon_area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    0.5 * polygon.windows(2).map(|edge| (edge[0] - first).perp_dot(edge[1] - first)).sum::<f64>()
}

/// The part of a polygon inside a triangle (Sutherland and Hodgman, Reentrant Polygon Clipping, CACM 17(1), 1974).
pub(super) fn clipped(polygon: &[DVec2], triangle: &[DVec2; 3]) -> Vec<DVec2> {
    let turn = polygon_area(triangle).signum();
    let mut inside = polygon.to_vec();
    for corner in 0..3 {
        let (start, end) = (triangle[corner], triangle[(corner + 1) % 3]);
        let distance = |point: DVec2| turn * (end - start).perp_dot(point - start);
        let mut kept = Vec::with_capacity(inside.len() + 1);
        for (index, &point) in inside.iter().enumerate() {
            let next = inside[(index + 1) % inside.len()];
            let (here, there) = (distance(point), distance(next));
            if here >= 0.0 {
                kept.push(point);
            }
            if (here >= 0.0) != (there >= 0.0) {
                kept.push(point.lerp(next, here / (here - there)));
            }
        }
        inside = kept;
    }
    inside
}
