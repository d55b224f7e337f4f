//! Meshes that are shown in many places, each with a tree of its own: the tree of the scene has the places.
//!
//! A mesh's triangles are stored once, in the mesh's space: its box's middle is the origin, and half of its diagonal in
//! [0.5, 1). Kernels bring a triangle's vertices to unit space before they test it, so that a hit is what a copy would have
//! given; the ray goes to the mesh's space for the boxes of its tree alone (`shaders/lib/two_levels.wgsl`).
//!
//! A triangle of an instance has a number of its own, beyond the indices of those that are stored: those of an instance are
//! in a row, and begin at a whole number of blocks. So a table of blocks says whose a number is.

use glam::{DMat3, DVec3, Mat3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;

use super::{AccelTriangle, UnitSpace, build_bvh, depth, sorted, unit_space_around};
use crate::scene::{Instance, Mesh, Scene};

/// Bits of numbers of triangles; light vertices have no more room (`INDEX_BITS` of `shaders/bind/light_cache.wgsl`).
pub(super) const NUMBER_BITS: u32 = 28;
/// Room around an instance for the rounding of its vertices, as a share of its largest coordinate: that of f32, and of the
/// few products and sums that make them.
const ROOM: f64 = 1.0 / (1 << 20) as f64;

/// A mesh in one of its places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelInstance {
    /// Its mesh, and which of that mesh's instances it is.
    pub mesh: u32,
    pub place: u32,
    /// From the mesh's space to unit space: unit = origin + (linear * v + origin_rest).
    pub linear: Mat3,
    pub origin: Vec3,
    /// What rounding leaves out of `origin`.
    pub origin_rest: Vec3,
    /// Of `linear`.
    pub inverse: Mat3,
    /// The largest coordinate of any of its points in unit space.
    pub reach: f32,
    pub is_mirrored: bool,
    /// The root of its mesh's tree.
    pub root: u32,
    /// Its mesh's triangles, as they are stored.
    pub first_triangle: u32,
    pub triangles: u32,
    /// Number of its first triangle.
    pub first_number: u32,
}

/// The instances of a scene.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    /// In the order of the scene's tree, which is that of their numbers.
    pub list: Vec<AccelInstance>,
    /// For each, the index of the triangle that stands for it in the scene's tree.
    pub entries: Vec<u32>,
    /// The first number that is none of a stored triangle.
    pub first_number: u32,
    /// Numbers of a block are 2^this many.
    pub block_bits: u32,
    /// The instance of each block.
    pub blocks: Vec<u32>,
}

/// A mesh in its own space with the tree over it.
pub(super) struct SharedMesh {
    pub space: UnitSpace,
    pub triangles: Vec<AccelTriangle>,
    pub dropped: usize,
}

impl SharedMesh {
    /// `None` where nothing is left of the mesh.
    pub fn new(index: u32, mesh: &Mesh) -> Option<Self> {
        let corners = || {
            let at = |vertex: u32| mesh.positions[vertex as usize];
            mesh.triangles.iter().enumerate().map(move |(index, triangle)| (index as u32, triangle.map(at)))
        };
        let space = unit_space_around(corners().map(|(_, corners)| corners), None);
        let triangles: Vec<AccelTriangle> =
            corners().filter_map(|(triangle, corners)| sorted(index, triangle, corners, &space)).collect();
        let dropped = mesh.triangles.len() - triangles.len();
        (!triangles.is_empty()).then_some(Self { space, triangles, dropped })
    }

    /// One of its places, not yet in the order of any tree, with its box.
    pub fn place(&self, instance: &Instance, unit: &UnitSpace) -> (AccelInstance, Aabb) {
        let scale = unit.length(self.space.world_length(1.0));
        let linear = instance.transform.matrix3 * scale;
        let origin = unit.point_f64(instance.transform.transform_point3(self.space.centre));
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for vertex in self.triangles.iter().flat_map(|triangle| triangle.vertices) {
            let at = linear * vertex.as_dvec3() + origin;
            (low, high) = (low.min(at), high.max(at));
        }
        let reach = low.abs().max(high.abs()).max_element();
        let room = reach * ROOM;
        let aabb = Aabb::new(Vec3A::from((low - room).as_vec3()), Vec3A::from((high + room).as_vec3()));
        let narrow = |m: DMat3| m.as_mat3();
        let placed = AccelInstance {
            mesh: 0,
            place: 0,
            linear: narrow(linear),
            origin: origin.as_vec3(),
            origin_rest: (origin - origin.as_vec3().as_dvec3()).as_vec3(),
            inverse: narrow(linear.inverse()),
            reach: (reach + room) as f32,
            is_mirrored: instance.is_mirrored(),
            root: 0,
            first_triangle: 0,
            triangles: self.triangles.len() as u32,
            first_number: 0,
        };
        (placed, aabb)
    }
}

impl AccelInstance {
    /// A point of the mesh's space in unit space, as kernels have it.
    pub fn point(&self, v: Vec3) -> Vec3 {
        let Mat3 { x_axis, y_axis, z_axis } = self.linear;
        self.origin + ((x_axis * v.x + y_axis * v.y + z_axis * v.z) + self.origin_rest)
    }
}

/// What stands for an instance in the order of the scene's triangles.
pub(super) fn entry(mesh: u32) -> AccelTriangle {
    AccelTriangle {
        vertices: [Vec3::NAN; 3],
        corners: [0, 1, 2],
        flipped: false,
        mesh,
        triangle: 0,
        cover: 0,
    }
}

impl AccelTriangle {
    /// It stands for an instance.
    pub fn is_entry(&self) -> bool {
        self.vertices[0].is_nan()
    }
}

impl Instances {
    /// Appends the trees and the triangles of the meshes that are in `list`, and gives the triangles of each instance their
    /// numbers. Returns the levels of the deepest tree. `None`: there are more triangles than numbers.
    pub(super) fn finish(
        &mut self,
        scene: &Scene,
        mut meshes: Vec<Option<SharedMesh>>,
        nodes: &mut Vec<[u32; 20]>,
        triangles: &mut Vec<AccelTriangle>,
    ) -> Option<u32> {
        let mut places = vec![(0, 0); scene.meshes.len()];
        let mut deepest = 0;
        for (mesh, place) in meshes.iter_mut().zip(&mut places) {
            let Some(mesh) = mesh.take() else { continue };
            *place = (nodes.len() as u32, triangles.len() as u32);
            let bvh = build_bvh(&mesh.triangles);
            deepest = deepest.max(depth(&bvh, 0));
            append(&bvh, nodes, triangles.len() as u32);
            triangles.extend(bvh.primitive_indices.iter().map(|&index| mesh.triangles[index as usize]));
        }
        self.block_bits = block_bits(self.list.iter().map(|instance| instance.triangles));
        self.first_number = triangles.len() as u32;
        let mut next = 0u64;
        for (index, instance) in self.list.iter_mut().enumerate() {
            (instance.root, instance.first_triangle) = places[instance.mesh as usize];
            instance.first_number =
                self.first_number.checked_add(u32::try_from(next << self.block_bits).ok()?)?;
            let blocks = instance.triangles.div_ceil(1 << self.block_bits);
            next += u64::from(blocks);
            if u64::from(self.first_number) + (next << self.block_bits) >= 1 << NUMBER_BITS {
                return None;
            }
            self.blocks.extend(std::iter::repeat_n(index as u32, blocks as usize));
        }
        Some(deepest)
    }

    /// The index of the instance that a triangle's number is of, with the index of the triangle as it is stored.
    pub fn resolve(&self, number: u32) -> (Option<usize>, u32) {
        if self.list.is_empty() || number < self.first_number {
            return (None, number);
        }
        let block = (number - self.first_number) >> self.block_bits;
        let index = self.blocks[block as usize] as usize;
        let instance = &self.list[index];
        (Some(index), number - instance.first_number + instance.first_triangle)
    }
}

/// Bits of a block of numbers, for instances of so many triangles: no more than a quarter of the numbers is of no triangle.
pub fn block_bits(triangles: impl Iterator<Item = u32>) -> u32 {
    (triangles.min().unwrap_or(1) / 4).max(1).ilog2()
}

/// Appends a tree's nodes to those of others; its triangles begin at `first_triangle`.
fn append(bvh: &CwBvh, nodes: &mut Vec<[u32; 20]>, first_triangle: u32) {
    let first_node = nodes.len() as u32;
    nodes.extend(bvh.nodes.iter().map(|node| {
        let mut node = *node;
        node.child_base_idx += first_node;
        node.primitive_base_idx += first_triangle;
        bytemuck::cast::<_, [u32; 20]>(node)
    }));
}
