//! Triangles that are wide beside what stands on them, cut where it stands.
//!
//! A point of a triangle is known to a few of the last digits of the triangle's size, and so is where a ray meets it: on
//! a ground a million times as wide as a cube, rays leave so far above it that they pass over the cube. Cut in two again
//! and again towards the cube, the ground's triangles become small where that matters, and stay few.
//!
//! The longest edge is halved in all triangles that share it, of whatever mesh, after those of them that have a longer one
//! (Rivara, New longest-edge algorithms for the refinement and/or improvement of unstructured triangulations, Int. J.
//! Numer. Meth. Eng. 40, 1997): meshes that were closed stay closed. What vertices carry is linear over a triangle and so
//! over its halves; normals are not made unit ones again, so shading is what it was.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, HashMap};

use glam::DVec3;

use super::nearby::Nearby;
use super::{UnitSpace, corners, has_area, unit_space};
use crate::scene::{Mesh, Scene};

/// A triangle's longest edge may be this many times that of what stands on it: rays then leave at about a hundredth of
/// the size of that.
const WIDEST: f64 = 8192.0;
/// What stands on a triangle is as near as this share of its longest edge.
pub(super) const NEAR: f64 = 0.25;
/// Of what is this many times as far from the middle of unit space as it is large, a step off its surface is a quarter.
const FEWEST_DIGITS: f64 = 262_144.0;
/// Triangles that may be added however few there are.
const MOST_ADDED: usize = 1 << 17;

/// The scene with its wide triangles cut, and with the middle of unit space at the finest of what stands on them; the same
/// scene where there are none. Its content hash is of no use: the original's stands for what is shown.
///
/// Triangles are added as long as they are not more than half of those that there were, or 2^17; where that ends it, a
/// warning says so.
pub fn without_wide_triangles(scene: &Scene) -> Cow<'_, Scene> {
    let Some(smallest) = smallest_beside_wide(scene) else { return Cow::Borrowed(scene) };
    let mut cut = Cutter::new(scene, smallest);
    let most = MOST_ADDED.max(scene.triangle_count() / 2);
    let before = cut.faces.len();
    while let Some((_, Reverse(face))) = cut.pending.pop() {
        let Some(standing) = cut.standing_on(face) else { continue };
        if cut.finest.is_none_or(|finest| standing < finest) {
            cut.finest = Some(standing);
        }
        cut.halve(face);
        if cut.faces.len() - before > 2 * most {
            log::warn!(
                "the scene has triangles so much wider than others that stand on them, in so many places, that cutting \
                 them would take more than {most} triangles; shadows where small things stand on wide triangles may be \
                 missing; divide the wide triangles"
            );
            break;
        }
    }
    let Some(finest) = cut.finest else { return Cow::Borrowed(scene) };
    let added = cut.scene.triangle_count() - scene.triangle_count();
    log::info!("wide triangles: cut where small ones stand on them, {added} triangles more");
    cut.scene.middle = cut.small.corner(finest.1);
    let blurred = cut.small.count_far_from(finest.1, FEWEST_DIGITS);
    if blurred > 0 {
        log::warn!(
            "{blurred} triangles are smaller than a {FEWEST_DIGITS:.0}th of their distance from the finest ones: positions have \
             too few digits for them, they lose their shape and their shadows; make scenes of one place at a time"
        );
    }
    Cow::Owned(cut.scene)
}

/// The length of the longest edge along an axis.
fn reach(corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    (b - a).abs().max((c - b).abs()).max((a - c).abs()).max_element()
}

/// The least `reach` of all triangles; `None` where no triangle can be wide beside it.
fn smallest_beside_wide(scene: &Scene) -> Option<f64> {
    let reaches = corners(scene).filter(|(_, _, corners)| has_area(corners)).map(|(_, _, c)| reach(&c));
    let (least, most) = reaches.fold((f64::INFINITY, 0.0f64), |(least, most), r| (least.min(r), most.max(r)));
    // A longest edge is at most sqrt(3) times as long as it is along an axis.
    (most * 1.75 > WIDEST * least).then_some(least)
}

/// An edge: its length squared, and its points, the lower index first. In this order no two edges are equal.
type Edge = (u64, u32, u32);

/// A triangle that may have to be cut.
#[derive(Clone, Copy)]
struct Face {
    mesh: u32,
    /// Index into the mesh's triangles.
    triangle: u32,
    /// Of the mesh.
    vertices: [u32; 3],
    /// Indices into `Cutter::points`: vertices in one place are one point.
    points: [u32; 3],
    longest: Edge,
    is_cut: bool,
}

struct Cutter {
    scene: Scene,
    unit: UnitSpace,
    /// In the scene's units, and in unit space.
    points: Vec<(DVec3, DVec3)>,
    point_at: HashMap<[u64; 3], u32>,
    faces: Vec<Face>,
    /// Faces at each edge.
    at_edge: HashMap<Edge, Vec<u32>>,
    /// Faces yet to be looked at, the largest first.
    pending: BinaryHeap<(u64, Reverse<u32>)>,
    small: Nearby,
    /// No edge shorter than this is cut.
    shortest: f64,
    /// Size (bits) and index of the smallest triangle that stands on a wide one.
    finest: Option<(u64, u32)>,
}

impl Cutter {
    /// `smallest`: from `smallest_beside_wide`.
    fn new(scene: &Scene, smallest: f64) -> Self {
        let unit = unit_space(scene);
        let shortest = WIDEST * unit.length(smallest);
        let in_unit = |corners: [DVec3; 3]| corners.map(|corner| unit.point_f64(corner));
        let all = || corners(scene).filter(|(_, _, corners)| has_area(corners));
        let longest = all().map(|(_, _, corners)| longest(&in_unit(corners))).fold(0.0, f64::max);
        let small = scene.meshes.iter().flat_map(|mesh| standing(mesh, &unit));
        let small = small.filter(|(_, _, size)| size * WIDEST < longest);
        let mut cutter = Self {
            scene: scene.clone(),
            unit,
            points: Vec::new(),
            point_at: HashMap::new(),
            faces: Vec::new(),
            at_edge: HashMap::new(),
            pending: BinaryHeap::new(),
            small: Nearby::new(small),
            shortest,
            finest: None,
        };
        for (mesh, triangle, corners) in all() {
            if self::longest(&in_unit(corners)) > shortest {
                let vertices = scene.meshes[mesh as usize].triangles[triangle as usize];
                let points = corners.map(|corner| cutter.point(corner));
                cutter.add(mesh, triangle, vertices, points);
            }
        }
        cutter
    }

    fn point(&mut self, world: DVec3) -> u32 {
        // Adding zero turns -0 into +0.
        let key = (world + DVec3::ZERO).to_array().map(f64::to_bits);
        *self.point_at.entry(key).or_insert_with(|| {
            self.points.push((world, self.unit.point_f64(world)));
            self.points.len() as u32 - 1
        })
    }

    fn edge(&self, a: u32, b: u32) -> Edge {
        let (low, high) = (a.min(b), a.max(b));
        let squared = (self.points[high as usize].1 - self.points[low as usize].1).length_squared();
        // The bits of positive numbers are in the order of the numbers.
        (squared.to_bits(), low, high)
    }

    fn edges(&self, points: [u32; 3]) -> [Edge; 3] {
        let [a, b, c] = points;
        [self.edge(a, b), self.edge(b, c), self.edge(c, a)]
    }

    fn add(&mut self, mesh: u32, triangle: u32, vertices: [u32; 3], points: [u32; 3]) {
        let edges = self.edges(points);
        let longest = edges.into_iter().max().unwrap_or_default();
        let face = self.faces.len() as u32;
        self.faces.push(Face { mesh, triangle, vertices, points, longest, is_cut: false });
        for edge in edges {
            self.at_edge.entry(edge).or_default().push(face);
        }
        if f64::from_bits(longest.0).sqrt() > self.shortest {
            self.pending.push((longest.0, Reverse(face)));
        }
    }

    /// The smallest triangle beside which the face is too wide, by its size and its index.
    fn standing_on(&self, face: u32) -> Option<(u64, u32)> {
        let face = &self.faces[face as usize];
        if face.is_cut {
            return None;
        }
        let length = f64::from_bits(face.longest.0).sqrt();
        let corners = face.points.map(|point| self.points[point as usize].1);
        self.small.smallest(&corners, NEAR * length, length / WIDEST)
    }

    /// Halves the face's longest edge, after those of neighbours that are longer.
    fn halve(&mut self, face: u32) {
        let mut path = vec![face];
        while let Some(&face) = path.last() {
            let Face { longest, is_cut, .. } = self.faces[face as usize];
            if is_cut {
                path.pop();
                continue;
            }
            let neighbours = self.at_edge.get(&longest).map_or(&[][..], Vec::as_slice);
            match neighbours.iter().find(|&&other| self.faces[other as usize].longest != longest) {
                // Its longest edge is after this one in the order of edges, so the path ends.
                Some(&other) => path.push(other),
                None => self.halve_edge(longest),
            }
        }
    }

    /// Halves an edge that is the longest of all faces at it.
    fn halve_edge(&mut self, edge: Edge) {
        let (_, low, high) = edge;
        let [a, b] = [low, high].map(|point| self.points[point as usize].0);
        let middle = self.point(0.5 * a + 0.5 * b);
        let mut vertex_of: HashMap<(u32, u32, u32), u32> = HashMap::new();
        for face in self.at_edge.remove(&edge).unwrap_or_default() {
            self.faces[face as usize].is_cut = true;
            let Face { mesh, triangle, vertices, points, .. } = self.faces[face as usize];
            for other in self.edges(points) {
                if let Some(faces) = self.at_edge.get_mut(&other) {
                    faces.retain(|&kept| kept != face);
                }
            }
            let start = (0..3).find(|&corner| points[corner] != low && points[corner] != high).unwrap_or(0);
            let (start, end) = ((start + 1) % 3, (start + 2) % 3);
            let (from, to) = (vertices[start], vertices[end]);
            let world = self.points[middle as usize].0;
            let mesh_data = &mut self.scene.meshes[mesh as usize];
            let vertex = *vertex_of
                .entry((mesh, from.min(to), from.max(to)))
                .or_insert_with(|| add_middle(mesh_data, from.min(to), from.max(to), world));
            let mut halves = [(vertices, points); 2];
            for (half, replaced) in halves.iter_mut().zip([end, start]) {
                half.0[replaced] = vertex;
                half.1[replaced] = middle;
            }
            mesh_data.triangles[triangle as usize] = halves[0].0;
            let second = mesh_data.triangles.len() as u32;
            mesh_data.triangles.push(halves[1].0);
            self.add(mesh, triangle, halves[0].0, halves[0].1);
            self.add(mesh, second, halves[1].0, halves[1].1);
        }
    }
}

/// A triangle that may stand on others: a corner in the scene's units, the corners in unit space, the length of the longest
/// edge.
type Standing = (DVec3, [DVec3; 3], f64);

/// The triangles of a mesh that may stand on others. For an instance that is not much larger than its smallest triangle that
/// one stands for all: beside it the others make no difference.
fn standing(mesh: &Mesh, unit: &UnitSpace) -> Vec<Standing> {
    /// `NEAR` is this many sizes of what stands there.
    const NOT_MUCH: f64 = 0.5 * NEAR * WIDEST;
    let in_unit = |corners: [DVec3; 3]| {
        let in_unit = corners.map(|corner| unit.point_f64(corner));
        (corners[0], in_unit, longest(&in_unit))
    };
    let all =
        mesh.world_corners().filter(|(_, corners)| has_area(corners)).map(|(_, corners)| in_unit(corners));
    if mesh.instances.is_empty() {
        return all.collect();
    }
    let area = mesh.triangles.iter().map(|triangle| triangle.map(|vertex| mesh.positions[vertex as usize]));
    let count = area.filter(has_area).count();
    let mut standing = Vec::new();
    let mut of_instance: Vec<Standing> = Vec::with_capacity(count);
    for triangle in all {
        of_instance.push(triangle);
        if of_instance.len() < count {
            continue;
        }
        let smallest = *of_instance.iter().fold(&of_instance[0], |a, b| if b.2 < a.2 { b } else { a });
        let corners = of_instance.iter().flat_map(|(_, corners, _)| corners);
        let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &corner| {
            (low.min(corner), high.max(corner))
        });
        match (high - low).length() < NOT_MUCH * smallest.2 {
            true => standing.push(smallest),
            false => standing.append(&mut of_instance),
        }
        of_instance.clear();
    }
    // What the areas of some instance's triangles round to may differ.
    standing.append(&mut of_instance);
    standing
}

/// The instances, by mesh and number, that have triangles so wide that they may have to be cut.
pub(super) fn wide_instances(scene: &Scene) -> BTreeSet<(usize, usize)> {
    let Some(smallest) = smallest_beside_wide(scene) else { return BTreeSet::new() };
    let mut wide = BTreeSet::new();
    for (index, mesh) in scene.meshes.iter().enumerate().filter(|(_, mesh)| !mesh.instances.is_empty()) {
        let count = mesh.triangles.len();
        let sizes = mesh.world_corners().map(|(_, corners)| longest(&corners));
        for (at, _) in sizes.enumerate().filter(|(_, size)| *size > WIDEST * smallest) {
            wide.insert((index, at / count));
        }
    }
    wide
}

/// Adds a vertex half-way between two others; returns its index.
fn add_middle(mesh: &mut Mesh, a: u32, b: u32, position: DVec3) -> u32 {
    fn push<T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>>(
        values: &mut Option<Vec<T>>,
        a: usize,
        b: usize,
    ) {
        if let Some(values) = values {
            values.push(values[a] * 0.5 + values[b] * 0.5);
        }
    }
    let vertex = mesh.positions.len() as u32;
    let (a, b) = (a as usize, b as usize);
    mesh.positions.push(position);
    push(&mut mesh.normals, a, b);
    push(&mut mesh.tangents, a, b);
    mesh.uvs.iter_mut().for_each(|uvs| push(uvs, a, b));
    push(&mut mesh.colors, a, b);
    vertex
}

/// Length of the longest edge.
fn longest(corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared()).sqrt()
}
