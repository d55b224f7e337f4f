//! Instances that cannot stay instances.
//!
//! Where surfaces lie in one another, the host decides which of them is in front (`coincident.rs`), and where they all but touch
//! kernels look closer (`thin.rs`): both know single triangles. So an instance with such a triangle becomes a copy, and all that
//! stay instances stand apart from whatever else there is, to within rounding.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::{DAffine3, Vec3};
use rayon::prelude::*;

use super::coincident::{Boxed, may_share_plane, pairs_among, rounding, share_plane};
use super::instances::SharedMesh;
use super::thin::{THIN, flat_axis, is_thin, nearly};
use super::wide::{wide_instances, without_wide_triangles};
use super::{AccelTriangle, UnitSpace, sorted, unit_space};
use crate::scene::{Instance, Repeated, Scene};

/// Pairs of neighbours that are looked at, for each instance or triangle of a scene: heaps of more become copies.
const MOST_NEIGHBOURS: usize = 256;

/// The scene as its tree is built: wide triangles are cut, and instances are copies that cannot stay what they are. The same
/// scene where there are none of either. Its content hash is of no use: the original's stands for what is shown.
pub fn arranged(scene: &Scene) -> Cow<'_, Scene> {
    if !scene.has_instances() {
        return without_wide_triangles(scene);
    }
    let wide = wide_instances(scene);
    let mut arranged = with_copies(scene, "that are wide beside others", &wide);
    if let Cow::Owned(cut) = without_wide_triangles(&arranged) {
        arranged = Cow::Owned(cut);
    }
    let (touching, why) = touching(&arranged);
    if let Cow::Owned(copied) = with_copies(&arranged, why, &touching) {
        arranged = Cow::Owned(copied);
    }
    arranged
}

/// Instances by mesh and number.
type Named = BTreeSet<(usize, usize)>;

/// The scene with copies of some instances, which is said of it.
fn with_copies<'a>(scene: &'a Scene, why: &str, named: &Named) -> Cow<'a, Scene> {
    let mut copied = scene.with_copies(|mesh, place| named.contains(&(mesh, place)));
    if let Cow::Owned(copied) = &mut copied {
        for (index, mesh) in scene.meshes.iter().enumerate() {
            let places = named.range((index, 0)..(index + 1, 0)).count();
            if places > 0 {
                let reason = format!("{places} of its instances have triangles {why}: these are copies");
                log::info!("mesh '{}': {reason}", mesh.name);
                copied.repeated.push(Repeated {
                    mesh: mesh.name.clone(),
                    triangles: mesh.triangles.len(),
                    places,
                    as_instances: false,
                    reason,
                });
            }
        }
    }
    copied
}

/// What stands in a scene: triangles that are shown once, then instances.
struct Things<'a> {
    scene: &'a Scene,
    unit: UnitSpace,
    /// Near instances.
    once: Vec<AccelTriangle>,
    /// Mesh and place.
    places: Vec<(usize, usize)>,
}

/// The instances that have a triangle in the plane of another one, or all but.
fn touching(scene: &Scene) -> (Named, &'static str) {
    let unit = unit_space(scene);
    let mut places = Vec::new();
    let mut boxes = Vec::new();
    let mut within: BTreeMap<usize, Vec<[u32; 2]>> = BTreeMap::new();
    for (index, mesh) in scene.meshes.iter().enumerate().filter(|(_, mesh)| !mesh.instances.is_empty()) {
        let Some(shared) = SharedMesh::new(index as u32, mesh) else { continue };
        let mut room = Vec3::ZERO;
        for (place, instance) in mesh.instances.iter().enumerate() {
            let (placed, aabb) = shared.place(instance, &unit);
            places.push((index, place));
            let around = THIN * placed.reach;
            boxes.push(Boxed::around(0, Vec3::from(aabb.min) - around, Vec3::from(aabb.max) + around));
            let inverse = placed.inverse;
            let rows = inverse.x_axis.abs() + inverse.y_axis.abs() + inverse.z_axis.abs();
            room = room.max(rows * placed.reach);
        }
        within.insert(index, pairs_within(&shared, room));
    }
    let all = Boxed::union(boxes.iter().copied());
    let near = |triangle: &AccelTriangle| nearly(0, triangle).meets(&all);
    let once =
        (0..).zip(&scene.meshes).filter(|(_, mesh)| mesh.instances.is_empty()).flat_map(|(index, mesh)| {
            let in_unit = move |(triangle, corners)| sorted(index, triangle as u32, corners, &unit);
            mesh.world_corners().filter_map(in_unit).filter(near)
        });
    let once: Vec<AccelTriangle> = once.collect();
    // Instances are numbered after what is shown once.
    let mut all: Vec<Boxed> = (0..).zip(&once).map(|(index, triangle)| nearly(index, triangle)).collect();
    all.extend((once.len()..).zip(boxes).map(|(index, place)| place.numbered(index)));
    let things = Things { scene, unit, once, places };
    things.touching(all, &within)
}

impl Things<'_> {
    fn touching(&self, boxes: Vec<Boxed>, within: &BTreeMap<usize, Vec<[u32; 2]>>) -> (Named, &'static str) {
        let first = self.once.len() as u32;
        let most = MOST_NEIGHBOURS * boxes.len();
        let count = AtomicUsize::new(0);
        // Pairs of triangles that are shown once are none of ours.
        let pairs =
            pairs_among(boxes, &|_: u32, b: u32| b >= first && count.fetch_add(1, Ordering::Relaxed) < most);
        let copied: Vec<AtomicBool> = self.places.iter().map(|_| AtomicBool::new(false)).collect();
        if count.into_inner() >= most {
            return (self.places.iter().copied().collect(), "among more others than are looked at");
        }
        let mut of_instance: Vec<Vec<u32>> = vec![Vec::new(); self.places.len()];
        for [a, b] in pairs {
            of_instance[(b - first) as usize].push(a);
        }
        of_instance.into_par_iter().enumerate().for_each(|(index, others)| {
            let (mesh, _) = self.places[index];
            let candidates = &within[&mesh];
            if others.is_empty() && candidates.is_empty() {
                return;
            }
            let own = self.triangles(index);
            let is_pair = |&[a, b]: &[u32; 2]| match (&own[a as usize], &own[b as usize]) {
                (Some(a), Some(b)) => touch(a, b),
                _ => false,
            };
            if candidates.iter().any(is_pair) {
                copied[index].store(true, Ordering::Relaxed);
            }
            let own: Vec<AccelTriangle> = own.into_iter().flatten().collect();
            for other in others {
                let (touches, of_other) = match other.checked_sub(first) {
                    None => (any_touch(&own, &self.once[other as usize..=other as usize]), None),
                    Some(other) => {
                        let other = other as usize;
                        let both = [&copied[index], &copied[other]];
                        if both.iter().all(|copied| copied.load(Ordering::Relaxed)) {
                            continue;
                        }
                        let others: Vec<AccelTriangle> =
                            self.triangles(other).into_iter().flatten().collect();
                        (any_touch(&own, &others), Some(&copied[other]))
                    }
                };
                if touches {
                    copied[index].store(true, Ordering::Relaxed);
                    of_other.into_iter().for_each(|copied| copied.store(true, Ordering::Relaxed));
                }
            }
        });
        let named = self.places.iter().zip(copied).filter(|(_, copied)| copied.load(Ordering::Relaxed));
        (named.map(|(place, _)| *place).collect(), "in the plane of others")
    }

    /// The triangles of an instance in unit space, as a copy would have them; `None` for one without area.
    fn triangles(&self, index: usize) -> Vec<Option<AccelTriangle>> {
        let (mesh, place) = self.places[index];
        let Instance { transform, .. } = &self.scene.meshes[mesh].instances[place];
        placed(self.scene, mesh, transform, &self.unit)
    }
}

fn placed(scene: &Scene, mesh: usize, transform: &DAffine3, unit: &UnitSpace) -> Vec<Option<AccelTriangle>> {
    let source = &scene.meshes[mesh];
    let world: Vec<_> =
        source.positions.iter().map(|position| transform.transform_point3(*position)).collect();
    let triangles = (0..).zip(&source.triangles);
    triangles
        .map(|(index, triangle)| sorted(mesh as u32, index, triangle.map(|v| world[v as usize]), unit))
        .collect()
}

/// They share a plane and some area, or all but touch.
fn touch(a: &AccelTriangle, b: &AccelTriangle) -> bool {
    let thin = || {
        let both = flat_axis(a).is_some() && flat_axis(b).is_some();
        both && nearly(0, a).meets(&nearly(0, b)) && is_thin(a, b)
    };
    let [box_a, box_b] = [a, b].map(|triangle| Boxed::new(0, triangle, rounding(triangle)));
    (box_a.meets(&box_b) && share_plane(a, b)) || thin()
}

/// Whether any triangle of one list touches one of the other.
fn any_touch(a: &[AccelTriangle], b: &[AccelTriangle]) -> bool {
    let around = |triangles: &[AccelTriangle]| Boxed::union(triangles.iter().map(|t| nearly(0, t)));
    let [around_a, around_b] = [around(a), around(b)];
    let within = |triangles: &[AccelTriangle], other: &Boxed| -> Vec<AccelTriangle> {
        triangles.iter().filter(|triangle| nearly(0, triangle).meets(other)).copied().collect()
    };
    let (mut both, others) = (within(a, &around_b), within(b, &around_a));
    let count = both.len() as u32;
    if count == 0 || others.is_empty() {
        return false;
    }
    both.extend(others);
    let boxes = both.iter().enumerate().map(|(index, triangle)| nearly(index, triangle));
    let found = AtomicBool::new(false);
    pairs_among(boxes.collect(), &|a: u32, b: u32| {
        let crosses = a < count && b >= count && !found.load(Ordering::Relaxed);
        if crosses && touch(&both[a as usize], &both[b as usize]) {
            found.store(true, Ordering::Relaxed);
        }
        false
    });
    found.into_inner()
}

/// Pairs of a mesh's triangles, by their indices there, that may touch in some place: to within `room` times the rounding of
/// unit space, in the mesh's own space.
fn pairs_within(mesh: &SharedMesh, room: Vec3) -> Vec<[u32; 2]> {
    /// Beyond this share of a mesh its instance is so small that it has no shape.
    const MOST: f32 = 1.0 / 64.0;
    let triangles = &mesh.triangles;
    let rooms = [2f32.powi(-20), THIN].map(|share| (room * share).min(Vec3::splat(MOST)));
    let boxed = |room: Vec3, flat: bool| -> Vec<Boxed> {
        let chosen = triangles.iter().enumerate().filter(|(_, t)| !flat || flat_axis(t).is_some());
        chosen.map(|(index, triangle)| Boxed::new(index, triangle, room)).collect()
    };
    let of = |index: u32| &triangles[index as usize];
    let mut pairs = pairs_among(boxed(rooms[0], false), &|a: u32, b: u32| {
        may_share_plane(of(a), of(b), rooms[0].max_element().into())
    });
    pairs.extend(pairs_among(boxed(rooms[1], true), &|a: u32, b: u32| {
        let (Some(axis), Some(other)) = (flat_axis(of(a)), flat_axis(of(b))) else { return false };
        axis == other && of(a).vertices[0][axis] != of(b).vertices[0][axis]
    }));
    pairs.into_iter().map(|pair| pair.map(|index| of(index).triangle)).collect()
}
