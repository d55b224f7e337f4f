//! The scene's triangles in unit space, and the wide BVH over them.
//!
//! Unit space: the scene moved so that the middle of its box is the origin, then scaled by the power of two that
//! brings half of the box's diagonal into [0.5, 1). Kernels see numbers of one size whatever the scene's units
//! are, and a scene scaled by a power of two or moved exactly gives the same picture bit for bit (C-20, C-22). Where small
//! things stand on wide triangles (`wide.rs`), the finest of them is the origin, since numbers have most digits there.

mod coincident;
mod copies;
mod covers;
mod instances;
mod nearby;
mod thin;
mod wide;

use std::time::{Duration, Instant};

use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::{Boundable, BvhBuildParams};
use thiserror::Error;

use coincident::Precedence;
pub use copies::arranged;
use instances::SharedMesh;
pub use instances::{AccelInstance, Instances, block_bits};
pub use wide::without_wide_triangles;

use crate::fault::Fault;
use crate::math::scale::{normalising_exponent, scale_by_power_of_two};
use crate::scene::{Mesh, Scene};

/// Building the acceleration structure.
#[derive(Debug, Error)]
pub enum AccelError {
    #[error(
        "{count} triangles are more than one acceleration structure holds; split the scene or decimate its meshes"
    )]
    TooManyTriangles { count: usize },
    #[error(
        "{count} triangles, those of instances counted each time, are more than can be told apart; show fewer instances"
    )]
    TooManyInstances { count: usize },
}

impl AccelError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::TooManyTriangles { .. } | Self::TooManyInstances { .. } => Fault::Input,
        }
    }
}

/// From world space (scene units, f64) to unit space (f32).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnitSpace {
    pub centre: DVec3,
    /// unit = (world - centre) * 2^exponent
    pub exponent: i32,
}

impl UnitSpace {
    pub fn point(&self, world: DVec3) -> Vec3 {
        // Adding zero turns -0 into +0, so that equal vertices have equal bits.
        (self.point_f64(world) + DVec3::ZERO).as_vec3()
    }

    pub fn point_f64(&self, world: DVec3) -> DVec3 {
        let moved = world - self.centre;
        DVec3::new(self.length(moved.x), self.length(moved.y), self.length(moved.z))
    }

    /// A length of the scene in unit space.
    pub fn length(&self, world: f64) -> f64 {
        scale_by_power_of_two(world, self.exponent)
    }

    /// A length of unit space in scene units.
    pub fn world_length(&self, unit: f64) -> f64 {
        scale_by_power_of_two(unit, -self.exponent)
    }
}

/// A triangle of the BVH's order.
#[derive(Clone, Copy, Debug)]
pub struct AccelTriangle {
    /// Unit space, sorted by their bits: see `shaders/lib/intersect.wgsl`.
    pub vertices: [Vec3; 3],
    /// `vertices[i]` is corner `corners[i]` of the scene's triangle.
    pub corners: [u8; 3],
    /// The sorted vertices run clockwise seen from the front.
    pub flipped: bool,
    pub mesh: u32,
    /// Index into the mesh's triangles.
    pub triangle: u32,
    /// Index into [`Accel::covers`]; 0 where nothing of the triangle's plane is in front of it.
    pub cover: u32,
}

/// The acceleration structure.
#[derive(Clone, Debug)]
pub struct Accel {
    /// obvhs' 80-byte nodes as words; never empty.
    pub nodes: Vec<[u32; 20]>,
    /// In the order of the nodes' references: those of the scene's tree, some of which stand for instances, then those of the
    /// meshes that have instances, in the meshes' spaces. Spatial splits may list a triangle more than once.
    pub triangles: Vec<AccelTriangle>,
    pub instances: Instances,
    /// Levels of inner nodes: what a traversal stack must hold.
    pub depth: u32,
    /// Triangles left out: zero area, or so thin that their area is zero in unit space.
    pub dropped: usize,
    /// What is in front of triangles in their own plane, in the words of `covers.rs`; empty where nothing is.
    pub covers: Vec<u32>,
    pub coincidence: Coincidence,
    /// Surfaces along two axes are nearer to each other than points of surfaces are told apart otherwise.
    pub thin_gaps: bool,
    pub unit: UnitSpace,
    pub build_time: Duration,
}

/// How many triangles stand where others do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coincidence {
    /// Left out, since no ray can meet them: the same as another one, or hidden by one of the same vertices.
    pub hidden: usize,
    /// Those of them that emit.
    pub hidden_emitters: usize,
    /// Pairs that share a plane and some of its area.
    pub overlaps: usize,
    /// Triangles of these pairs that emit.
    pub overlapping_emitters: usize,
}

impl Accel {
    /// Builds the BVH. A scene without triangles gets one empty node.
    ///
    /// # Errors
    /// More triangles than a 32-bit index holds.
    pub fn build(scene: &Scene) -> Result<Self, AccelError> {
        let start = Instant::now();
        if scene.triangle_count() > (u32::MAX / 8) as usize {
            return Err(AccelError::TooManyTriangles { count: scene.triangle_count() });
        }
        let unit = unit_space(scene);
        let (mut triangles, mut dropped) = unit_triangles(scene, &unit);
        let precedence = Precedence::new(scene, &triangles);
        let mut coincidence = leave_out_hidden(scene, &precedence, &mut triangles);
        let meshes: Vec<Option<SharedMesh>> = (0..)
            .zip(&scene.meshes)
            .map(|(index, mesh)| if mesh.instances.is_empty() { None } else { SharedMesh::new(index, mesh) })
            .collect();
        let mut instances = Instances::default();
        if triangles.is_empty() && meshes.iter().all(Option::is_none) {
            return Ok(Self {
                nodes: vec![[0; 20]],
                triangles,
                instances,
                depth: 1,
                dropped,
                covers: Vec::new(),
                coincidence,
                thin_gaps: false,
                unit,
                build_time: start.elapsed(),
            });
        }
        let (bvh, places) = match meshes.iter().all(Option::is_none) {
            true => (build_bvh(&triangles), Vec::new()),
            false => tree_of_both(scene, &unit, &triangles, &meshes),
        };
        let mut depth = depth(&bvh, 0);
        let CwBvh { nodes, primitive_indices, .. } = bvh;
        // What is not in the BVH's order goes before more is made.
        triangles = (0..)
            .zip(&primitive_indices)
            .map(|(at, &index)| match (index as usize).checked_sub(triangles.len()) {
                None => triangles[index as usize],
                Some(place) => {
                    instances.list.push(places[place]);
                    instances.entries.push(at);
                    instances::entry(places[place].mesh)
                }
            })
            .collect();
        drop((primitive_indices, places));
        let mut nodes: Vec<[u32; 20]> = bytemuck::cast_vec(nodes);
        let overlaps = coincident::overlaps(&triangles);
        coincidence.overlaps = overlaps.len();
        let mut emitters: Vec<u32> = overlaps.as_flattened().to_vec();
        emitters.retain(|&index| precedence.emits(&triangles[index as usize]));
        emitters.sort_unstable();
        emitters.dedup();
        coincidence.overlapping_emitters = emitters.len();
        let thin_gaps = thin::has_thin_gaps(&triangles);
        let covers = covers::covers(&mut triangles, &overlaps, &precedence);
        if !instances.list.is_empty() {
            dropped += meshes.iter().zip(&scene.meshes).map(dropped_by_instances).sum::<usize>();
            let deepest = instances.finish(scene, meshes, &mut nodes, &mut triangles);
            // On its way into an instance a ray leaves other triangles of the node behind.
            depth += 1 + deepest.ok_or(AccelError::TooManyInstances { count: scene.triangle_count() })?;
        }
        Ok(Self {
            nodes,
            triangles,
            instances,
            depth,
            dropped,
            covers,
            thin_gaps,
            coincidence,
            unit,
            build_time: start.elapsed(),
        })
    }
}

impl Accel {
    /// The triangle of a number that a hit has, in unit space.
    pub fn triangle_at(&self, number: u32) -> AccelTriangle {
        let (instance, stored) = self.instances.resolve(number);
        let triangle = self.triangles[stored as usize];
        instance.map(|index| &self.instances.list[index]).map_or(triangle, |instance| AccelTriangle {
            vertices: triangle.vertices.map(|vertex| instance.point(vertex)),
            flipped: triangle.flipped != instance.is_mirrored,
            ..triangle
        })
    }

    /// The numbers of all triangles that are shown.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        let own = self.instances.list.iter().map(|instance| instance.first_triangle).min();
        let own = own.unwrap_or(self.triangles.len() as u32);
        let once = (0..own).filter(|&index| !self.triangles[index as usize].is_entry());
        let of = |instance: &AccelInstance| instance.first_number..instance.first_number + instance.triangles;
        once.chain(self.instances.list.iter().flat_map(of))
    }
}

/// The tree over triangles and instances: the indices of these come after those of triangles.
fn tree_of_both(
    scene: &Scene,
    unit: &UnitSpace,
    triangles: &[AccelTriangle],
    meshes: &[Option<SharedMesh>],
) -> (CwBvh, Vec<AccelInstance>) {
    let mut boxes: Vec<Aabb> = triangles.iter().map(Boundable::aabb).collect();
    let mut places = Vec::new();
    for (index, (mesh, shared)) in scene.meshes.iter().zip(meshes).enumerate() {
        let Some(shared) = shared else { continue };
        for (place, instance) in mesh.instances.iter().enumerate() {
            let (placed, aabb) = shared.place(instance, unit);
            places.push(AccelInstance { mesh: index as u32, place: place as u32, ..placed });
            boxes.push(aabb);
        }
    }
    (build_bvh(&boxes), places)
}

fn dropped_by_instances((shared, mesh): (&Option<SharedMesh>, &Mesh)) -> usize {
    let all = if mesh.instances.is_empty() { 0 } else { mesh.triangles.len() };
    shared.as_ref().map_or(all, |shared| shared.dropped) * mesh.places()
}

/// Leaves out what no ray can meet, since another triangle of the same vertices is in front of it on both sides.
fn leave_out_hidden(
    scene: &Scene,
    precedence: &Precedence,
    triangles: &mut Vec<AccelTriangle>,
) -> Coincidence {
    let hidden = coincident::hidden(scene, precedence, triangles);
    let Some(&first) = hidden.first() else { return Coincidence::default() };
    let emits = |&&index: &&u32| precedence.emits(&triangles[index as usize]);
    let coincidence = Coincidence {
        hidden: hidden.len(),
        hidden_emitters: hidden.iter().filter(emits).count(),
        ..Coincidence::default()
    };
    log::warn!(
        "{} triangles have the same three corners as others that are in front of them, the first in mesh '{}'; they \
         are left out, {} of them are emitters and count once; remove faces that stand twice",
        coincidence.hidden,
        scene.meshes[triangles[first as usize].mesh as usize].name,
        coincidence.hidden_emitters,
    );
    let mut hidden = hidden.into_iter().peekable();
    let mut index = 0;
    triangles.retain(|_| {
        index += 1;
        hidden.next_if_eq(&(index - 1)).is_none()
    });
    coincidence
}

/// The corners of all triangles that are shown, with their meshes and their indices there.
fn corners(scene: &Scene) -> impl Iterator<Item = (u32, u32, [DVec3; 3])> {
    (0..).zip(&scene.meshes).flat_map(|(mesh_index, mesh)| {
        mesh.world_corners().map(move |(index, corners)| (mesh_index, index as u32, corners))
    })
}

/// True for triangles with a direction to face: a finite normal that is not zero.
fn has_area(corners: &[DVec3; 3]) -> bool {
    let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
    // Scaled first, since the product of two tiny edges may underflow.
    let size = a.abs().max(b.abs()).max_element();
    let normal = (a / size).cross(b / size);
    normal.is_finite() && normal != DVec3::ZERO
}

fn unit_space(scene: &Scene) -> UnitSpace {
    unit_space_around(corners(scene).map(|(_, _, corners)| corners), scene.middle)
}

/// The unit space of triangles by their corners.
fn unit_space_around(triangles: impl Iterator<Item = [DVec3; 3]>, middle: Option<DVec3>) -> UnitSpace {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corners in triangles.filter(has_area) {
        for corner in corners {
            low = low.min(corner);
            high = high.max(corner);
        }
    }
    // Half first: the sum of two huge numbers overflows.
    let (centre, half) = match middle {
        None => (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low),
        Some(middle) => (middle, (high - middle).max(middle - low)),
    };
    // Two steps, since the squares in the length of a huge box overflow, and those of a tiny one vanish.
    let exponent = normalising_exponent(half.max_element()).and_then(|first| {
        let near_one = half.to_array().map(|side| scale_by_power_of_two(side, first));
        Some(first + normalising_exponent(DVec3::from_array(near_one).length())?)
    });
    exponent.map_or_else(UnitSpace::default, |exponent| UnitSpace { centre, exponent })
}

/// The triangles of meshes that are shown once, and how many are left out.
fn unit_triangles(scene: &Scene, unit: &UnitSpace) -> (Vec<AccelTriangle>, usize) {
    let once = || (0..).zip(&scene.meshes).filter(|(_, mesh)| mesh.instances.is_empty());
    let count = once().map(|(_, mesh)| mesh.triangles.len()).sum();
    let mut triangles = Vec::with_capacity(count);
    for (index, mesh) in once() {
        let in_unit = |(triangle, corners)| sorted(index, triangle as u32, corners, unit);
        triangles.extend(mesh.world_corners().filter_map(in_unit));
    }
    let dropped = count - triangles.len();
    (triangles, dropped)
}

/// A triangle in unit space, its vertices sorted; `None` for one without area.
fn sorted(mesh: u32, triangle: u32, corners: [DVec3; 3], unit: &UnitSpace) -> Option<AccelTriangle> {
    let vertices = corners.map(|corner| unit.point(corner));
    if !has_area(&corners) || !has_area(&vertices.map(|vertex| vertex.as_dvec3())) {
        return None;
    }
    let mut order = [0u8, 1, 2];
    order.sort_by(|&a, &b| {
        let (a, b) = (vertices[a as usize].to_array(), vertices[b as usize].to_array());
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
    });
    Some(AccelTriangle {
        vertices: order.map(|corner| vertices[corner as usize]),
        corners: order,
        // Odd permutations turn the winding.
        flipped: matches!(order, [0, 2, 1] | [1, 0, 2] | [2, 1, 0]),
        mesh,
        triangle,
        cover: 0,
    })
}

/// The slower, better builders pay for themselves in seconds of tracing; past a few hundred thousand triangles
/// their time would be noticed.
fn build_bvh<T: Boundable>(triangles: &[T]) -> CwBvh {
    let parameters = if triangles.len() <= 300_000 {
        BvhBuildParams { pre_split: false, ..BvhBuildParams::slow_build() }
    } else {
        BvhBuildParams::medium_build()
    };
    build_cwbvh(triangles, parameters, &mut Duration::default())
}

impl Boundable for AccelTriangle {
    fn aabb(&self) -> Aabb {
        let [v0, v1, v2] = self.vertices.map(Vec3A::from);
        obvhs::triangle::Triangle { v0, v1, v2 }.aabb()
    }
}

/// Levels of inner nodes below and including `node`.
fn depth(bvh: &CwBvh, node: usize) -> u32 {
    let inner = &bvh.nodes[node];
    let children = inner.imask.count_ones() as usize;
    let first = inner.child_base_idx as usize;
    1 + (first..first + children).map(|child| depth(bvh, child)).max().unwrap_or(0)
}
