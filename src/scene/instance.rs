//! Meshes that are shown in many places: kept once, as instances, where copies would take much more.

use std::borrow::Cow;
use std::sync::Arc;

use clap::ValueEnum;
use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};

use super::{Mesh, Scene};

/// How meshes are held that are shown in many places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Instancing {
    /// Once, where copies would take much more memory.
    #[default]
    Auto,
    /// As a copy for each place.
    Never,
    /// Once, wherever that can be.
    Always,
}

/// A place where a mesh is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// From the mesh's own space to world space; it has an inverse ([`Instance::suits`]).
    pub transform: DAffine3,
    /// Of the object that is shown there.
    pub name: Arc<str>,
}

/// How a mesh is held that is shown often enough for it to matter, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repeated {
    pub mesh: String,
    pub triangles: usize,
    /// How often it is shown.
    pub places: usize,
    pub as_instances: bool,
    pub reason: String,
}

impl Repeated {
    /// As what it is held, in a word.
    pub fn held(&self) -> &'static str {
        if self.as_instances { "instances" } else { "copies" }
    }
}

/// Bytes that a copied triangle takes at the peak, and an instance; measured (docs/measurements.md).
const COPY_BYTES: u64 = 310;
const INSTANCE_BYTES: u64 = 640;
/// Copies of less than this are no matter, and rays are faster in them.
const LITTLE: u64 = 64 << 20;
/// How many times the memory of instances copies have to take.
const CLEAR: u64 = 8;
/// Axes may be this many times as long as others: beyond that a transform has hardly an inverse.
const MOST_STRETCHED: f64 = 4096.0;

impl Instance {
    /// Whether a mesh can be shown by that transform without a copy: the numbers of f32 have to lead there and back.
    pub fn suits(transform: &DAffine3) -> bool {
        let linear = transform.matrix3;
        let largest =
            |m: &DMat3| m.to_cols_array().into_iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let inverse = linear.inverse();
        let stretched = largest(&linear) * largest(&inverse);
        transform.is_finite() && inverse.is_finite() && stretched <= MOST_STRETCHED
    }

    /// Front sides are turned over.
    pub fn is_mirrored(&self) -> bool {
        self.transform.matrix3.determinant() < 0.0
    }
}

/// The reason to keep a mesh of so many triangles as instances in so many places, or else to copy it.
pub fn worth_keeping(triangles: usize, places: usize) -> Result<String, String> {
    let [triangles, places] = [triangles as u64, places as u64];
    let copies = triangles.saturating_mul(places).saturating_mul(COPY_BYTES);
    let instances = triangles * COPY_BYTES + places * INSTANCE_BYTES;
    let [mib, least] = [copies, instances].map(|bytes| bytes.div_ceil(1 << 20));
    if copies <= LITTLE {
        Err(format!("copies take about {mib} MiB, and rays are faster in them"))
    } else if copies < CLEAR * instances {
        Err(format!("copies take about {mib} MiB, instances {least} MiB, and rays are faster in copies"))
    } else {
        Ok(format!("copies would take about {mib} MiB, instances take {least} MiB"))
    }
}

/// The inverse transpose of `linear` up to a positive factor: its cofactors with the sign of its determinant.
/// Exists for singular matrices too, and is scaled so that nothing overflows.
pub fn normal_matrix(linear: DMat3) -> DMat3 {
    let largest = linear.to_cols_array().into_iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 {
        return DMat3::ZERO;
    }
    let m = linear * (1.0 / largest);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)) * sign
}

/// A triangle as it is shown: turned over where that is a mirror image, so that its front stays its front.
fn shown([a, b, c]: [u32; 3], is_mirrored: bool) -> [u32; 3] {
    if is_mirrored { [a, c, b] } else { [a, b, c] }
}

impl Mesh {
    /// Where it is shown: `None`, once, as it is.
    pub fn shown_at(&self) -> impl Iterator<Item = Option<&Instance>> {
        self.instances.iter().map(Some).chain(self.instances.is_empty().then_some(None))
    }

    /// The corners in the world of triangles that are shown at one of [its places](Self::shown_at).
    pub fn corners_at(&self, instance: Option<&Instance>) -> impl Fn(&[u32; 3]) -> [DVec3; 3] {
        let is_mirrored = instance.is_some_and(Instance::is_mirrored);
        let at = move |vertex: u32| {
            let position = self.positions[vertex as usize];
            instance.map_or(position, |instance| instance.transform.transform_point3(position))
        };
        move |triangle| shown(*triangle, is_mirrored).map(at)
    }

    /// How often it is shown.
    pub fn places(&self) -> usize {
        self.instances.len().max(1)
    }

    /// The places of its vertices in the world: those of each instance in turn.
    pub fn world_positions(&self) -> impl Iterator<Item = DVec3> {
        let once = self.instances.is_empty().then_some(&self.positions);
        let placed = self.instances.iter().flat_map(|instance| {
            self.positions.iter().map(|position| instance.transform.transform_point3(*position))
        });
        once.into_iter().flatten().copied().chain(placed)
    }

    /// The corners of its triangles in the world, with the triangles' indices: those of each instance in turn.
    pub fn world_corners(&self) -> impl Iterator<Item = (usize, [DVec3; 3])> {
        self.shown_at().flat_map(|instance| {
            let corners = self.corners_at(instance);
            self.triangles.iter().map(corners).enumerate()
        })
    }

    /// A copy of it in the world, where `instance` shows it. A mirroring transform turns windings over, so that fronts
    /// stay fronts.
    pub fn copy_at(&self, instance: &Instance) -> Self {
        let Instance { transform, name } = instance;
        let (linear, normal_matrix) = (transform.matrix3, normal_matrix(transform.matrix3));
        let mirrored = instance.is_mirrored();
        let unit = |v: DVec3, otherwise: Vec3| v.try_normalize().map_or(otherwise, |unit| unit.as_vec3());
        let normals = self.normals.as_ref().map(|normals| -> Vec<Vec3> {
            normals.iter().map(|normal| unit(normal_matrix * normal.as_dvec3(), Vec3::Z)).collect()
        });
        let tangents = self.tangents.as_ref().map(|tangents| {
            let place = |tangent: &Vec4| {
                let sign = if (tangent.w < 0.0) != mirrored { -1.0 } else { 1.0 };
                unit(linear * tangent.truncate().as_dvec3(), Vec3::X).extend(sign)
            };
            tangents.iter().map(place).collect()
        });
        Self {
            name: name.to_string(),
            material: self.material,
            positions: self.positions.iter().map(|p| transform.transform_point3(*p)).collect(),
            normals,
            tangents,
            uvs: self.uvs.clone(),
            colors: self.colors.clone(),
            triangles: self.triangles.iter().map(|triangle| shown(*triangle, mirrored)).collect(),
            instances: Vec::new(),
        }
    }
}

impl Scene {
    /// Some mesh is shown by instances.
    pub fn has_instances(&self) -> bool {
        self.meshes.iter().any(|mesh| !mesh.instances.is_empty())
    }

    /// The scene with copies in place of the instances that `is_copied` names by mesh and number; the same scene where it
    /// names none.
    pub fn with_copies(&self, is_copied: impl Fn(usize, usize) -> bool) -> Cow<'_, Self> {
        let named = |mesh: usize| (0..self.meshes[mesh].instances.len()).any(|place| is_copied(mesh, place));
        if !(0..self.meshes.len()).any(named) {
            return Cow::Borrowed(self);
        }
        let mut scene = Self { meshes: Vec::new(), ..self.clone() };
        for (index, mesh) in self.meshes.iter().enumerate() {
            let (copied, kept): (Vec<usize>, Vec<usize>) =
                (0..mesh.instances.len()).partition(|&place| is_copied(index, place));
            if copied.is_empty() || !kept.is_empty() {
                let instances = kept.into_iter().map(|place| mesh.instances[place].clone()).collect();
                scene.meshes.push(Mesh { instances, ..mesh.clone() });
            }
            scene.meshes.extend(copied.into_iter().map(|place| mesh.copy_at(&mesh.instances[place])));
        }
        Cow::Owned(scene)
    }
}
