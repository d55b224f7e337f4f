//! The scene as the judge sees it: triangles, and what a surface is at a point of one.

use glam::{DVec2, DVec3, DVec4, Vec2};
use halfway::scene::{AlphaMode, Material, Mesh, Scene, TextureRef};

use super::geometry::{Hit, Ray, Tree};
use super::light::Lights;
use super::texture::lookup;
use crate::bsdf_f64::{Bsdf, Factors, Sample, albedo_table};
use crate::normals_f64::Normals;

pub struct World<'a> {
    pub scene: &'a Scene,
    pub tree: Tree,
    pub lights: Lights,
    /// Mesh and triangle of every triangle of the tree.
    triangles: Vec<(usize, usize)>,
}

/// A point of a surface.
#[derive(Clone)]
pub struct Point<'a> {
    pub position: DVec3,
    /// Triangle of the tree, and barycentrics of its second and third corner.
    pub triangle: usize,
    pub b: [f64; 2],
    /// Unit geometric normal of the front.
    pub world_ng: DVec3,
    /// Orthonormal, z is the shading normal.
    frame: [DVec3; 3],
    normals: Normals,
    pub material: &'a Material,
    pub bsdf: Bsdf,
    /// Radiance from the front, and from the back if the material is double-sided.
    emission: DVec3,
}

impl<'a> World<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        // Made here, since it is made in parallel: first asked for in a parallel loop, it may be waited for by the very
        // thread that makes it.
        albedo_table();
        let mut triangles = Vec::new();
        let mut corners = Vec::new();
        for (m, mesh) in scene.meshes.iter().enumerate() {
            for (t, triangle) in mesh.triangles.iter().enumerate() {
                let positions = triangle.map(|vertex| mesh.positions[vertex as usize]);
                if normal_of(&positions).is_some() {
                    corners.push(positions);
                    triangles.push((m, t));
                }
            }
        }
        let material =
            |index: usize| -> &Material { &scene.materials[scene.meshes[index].material as usize] };
        let emission = |triangle: usize| material(triangles[triangle].0);
        let lights = Lights::new(scene, &corners, emission);
        Self { scene, tree: Tree::new(corners), lights, triangles }
    }

    /// The first surface along the ray beyond `from` that is there: a surface of opacity a is there with probability a,
    /// by the number `u` draws.
    pub fn trace(&self, ray: &Ray, mut draw: impl FnMut() -> f64) -> Option<(f64, Point<'a>)> {
        let mut from = self.tree.nearest;
        loop {
            let hit = self.tree.closest(ray, from, f64::INFINITY)?;
            let opacity = self.opacity(&hit);
            if opacity == 1.0 || draw() < opacity {
                return Some((hit.distance, self.point(&hit)));
            }
            from = hit.distance + self.tree.nearest;
        }
    }

    /// Share of light that goes straight from `origin` along `direction` for `distance`, absorption in volumes aside.
    pub fn visibility(&self, origin: DVec3, direction: DVec3, distance: f64) -> f64 {
        let ray = Ray { origin, direction };
        let (mut from, mut share) = (self.tree.nearest, 1.0);
        while let Some(hit) = self.tree.closest(&ray, from, distance - self.tree.nearest) {
            share *= 1.0 - self.opacity(&hit);
            if share == 0.0 {
                break;
            }
            from = hit.distance + self.tree.nearest;
        }
        share
    }

    /// Mesh and triangle of the scene of a triangle of the tree.
    pub fn scene_triangle(&self, triangle: usize) -> (usize, usize) {
        self.triangles[triangle]
    }

    /// The other way round; `None` without area.
    pub fn tree_triangle(&self, mesh: usize, triangle: usize) -> Option<usize> {
        self.triangles.binary_search(&(mesh, triangle)).ok()
    }

    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        let (mesh, vertices, _) = self.mesh_of(triangle);
        vertices.map(|vertex| mesh.positions[vertex])
    }

    fn mesh_of(&self, triangle: usize) -> (&'a Mesh, [usize; 3], &'a Material) {
        let (mesh, triangle) = self.triangles[triangle];
        let mesh = &self.scene.meshes[mesh];
        let vertices = mesh.triangles[triangle].map(|vertex| vertex as usize);
        (mesh, vertices, &self.scene.materials[mesh.material as usize])
    }

    /// Base colour and opacity.
    fn base_color(&self, hit: &Hit) -> DVec4 {
        let (mesh, vertices, material) = self.mesh_of(hit.triangle);
        let weights = weights_of(hit.b);
        let slot = self.slot(hit, &material.base_color_texture, true);
        let factor = material.base_color.as_dvec3().extend(f64::from(material.alpha));
        let vertex = mesh
            .colors
            .as_ref()
            .map_or(DVec4::ONE, |colors| (0..3).map(|i| weights[i] * colors[vertices[i]].as_dvec4()).sum());
        factor * slot * vertex
    }

    pub fn opacity(&self, hit: &Hit) -> f64 {
        match self.mesh_of(hit.triangle).2.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f64::from(self.base_color(hit).w >= f64::from(cutoff)),
            AlphaMode::Blend => self.base_color(hit).w.clamp(0.0, 1.0),
        }
    }

    /// The value of a slot's texture at the hit, white without one.
    fn slot(&self, hit: &Hit, slot: &Option<TextureRef>, srgb: bool) -> DVec4 {
        let Some(slot) = slot else { return DVec4::ONE };
        let (mesh, vertices, _) = self.mesh_of(hit.triangle);
        let weights = weights_of(hit.b);
        let uv: DVec2 = mesh.uvs[slot.uv_set as usize]
            .as_ref()
            .map_or(DVec2::ZERO, |uvs| (0..3).map(|i| weights[i] * uvs[vertices[i]].as_dvec2()).sum());
        lookup(self.scene, slot, Vec2::new(uv.x as f32, uv.y as f32), srgb)
    }

    pub fn point(&self, hit: &Hit) -> Point<'a> {
        let (mesh, vertices, material) = self.mesh_of(hit.triangle);
        let weights = weights_of(hit.b);
        let corners = vertices.map(|vertex| mesh.positions[vertex]);
        let world_ng = normal_of(&corners).expect("only triangles with a normal are in the tree");
        let mut normal = world_ng;
        if let Some(normals) = &mesh.normals {
            let sum: DVec3 = (0..3).map(|i| weights[i] * normals[vertices[i]].as_dvec3()).sum();
            normal = sum.try_normalize().unwrap_or(world_ng);
        }
        if let (Some(map), Some(tangents)) = (&material.normal_texture, &mesh.tangents) {
            let tangent: DVec4 = (0..3).map(|i| weights[i] * tangents[vertices[i]].as_dvec4()).sum();
            let bitangent = normal.cross(tangent.truncate()) * tangent.w.signum();
            let value = 2.0 * self.slot(hit, &Some(*map), false) - 1.0;
            let scale = f64::from(material.normal_scale);
            let bent = scale * (value.x * tangent.truncate() + value.y * bitangent) + value.z * normal;
            normal = bent.try_normalize().unwrap_or(normal);
        }
        // What points into the surface is mirrored to its outer side.
        normal -= 2.0 * normal.dot(world_ng).min(0.0) * world_ng;
        let base_color = self.base_color(hit).truncate();
        let emission = if material.unlit {
            base_color
        } else {
            material.emission.as_dvec3() * self.slot(hit, &material.emission_texture, true).truncate()
        };
        Point {
            position: (0..3).map(|i| weights[i] * corners[i]).sum(),
            triangle: hit.triangle,
            b: hit.b,
            world_ng,
            frame: frame_about(normal),
            normals: Normals::new(normal, world_ng),
            material,
            bsdf: Bsdf::new(&Factors::at(material, base_color, |texture, srgb| {
                self.slot(hit, texture, srgb)
            })),
            emission,
        }
    }
}

impl Point<'_> {
    /// Radiance towards a direction.
    pub fn emitted(&self, world: DVec3) -> DVec3 {
        let shows = self.material.double_sided || self.world_ng.dot(world) > 0.0;
        if shows { self.emission } else { DVec3::ZERO }
    }

    /// A direction as the BSDF knows it, and the solid angle there for solid angle here.
    pub fn to_local(&self, world: DVec3) -> (DVec3, f64) {
        let moved = self.normals.to_shading(world);
        (DVec3::from(self.frame.map(|axis| moved.world.dot(axis))), moved.jacobian)
    }

    /// A direction of the BSDF in the world.
    fn to_world(&self, local: DVec3) -> DVec3 {
        let world = local.x * self.frame[0] + local.y * self.frame[1] + local.z * self.frame[2];
        self.normals.to_geometric(world, local.z).world
    }

    /// Cosine to the shading normal, in the measure of directions of the world.
    pub fn carried_cosine(&self, world: DVec3) -> f64 {
        let (local, jacobian) = self.to_local(world);
        local.z * jacobian
    }

    /// The direction is on the same side of the surface in the world and for the BSDF.
    pub fn sides_agree(&self, world: DVec3) -> bool {
        self.world_ng.dot(world) * self.to_local(world).0.z > 0.0
    }

    /// f times the cosine (to the shading normal) of the direction towards the light.
    pub fn scattered(&self, world_eye: DVec3, world_light: DVec3) -> DVec3 {
        if !self.scatters() || !self.sides_agree(world_eye) || !self.sides_agree(world_light) {
            return DVec3::ZERO;
        }
        let cos = self.carried_cosine(world_light).abs();
        self.bsdf.eval(self.to_local(world_eye).0, self.to_local(world_light).0) * cos
    }

    /// Density per solid angle of going on from `from` to `to`, roulette not included.
    pub fn scatter_pdf(&self, from: DVec3, to: DVec3) -> f64 {
        let (to, jacobian) = self.to_local(to);
        self.bsdf.pdf(self.to_local(from).0, to) * jacobian
    }

    /// The direction that a path from `from` goes on along, with the density per solid angle; `None` where it ends.
    pub fn sample(&self, from: DVec3, u: [f64; 3], from_eye: bool) -> Option<Sample> {
        if !self.sides_agree(from) {
            return None;
        }
        let mut sample = self.bsdf.sample(self.to_local(from).0, u, from_eye)?;
        sample.w = self.to_world(sample.w);
        if !self.bsdf.delta {
            sample.pdf *= self.to_local(sample.w).1;
        }
        self.sides_agree(sample.w).then_some(sample)
    }

    /// Unlit surfaces only radiate.
    pub fn scatters(&self) -> bool {
        !self.material.unlit
    }

    /// Probability with which a path goes on here: a function of the point alone.
    pub fn roulette(&self) -> f64 {
        self.bsdf.albedo().max_element().clamp(0.3, 1.0)
    }

    /// [`Self::roulette`] as the renderer has it, whose paths always end: part of the densities that bidirectional
    /// weights are made of.
    pub fn survival(&self) -> f64 {
        let kept = self.bsdf.albedo().max_element().max(0.3);
        if kept > 1.0 - 1.0 / 4096.0 { 255.0 / 256.0 } else { kept }
    }

    /// The same where the path comes from so many delta surfaces in a row, `caught_run` of which it passes like any others.
    pub fn survival_after(&self, row: usize, caught_run: usize) -> f64 {
        self.survival() * if self.bsdf.delta && row >= caught_run { 0.95 } else { 1.0 }
    }

    /// The medium that a segment leaving towards a direction is in, as far as this end knows.
    pub fn medium_towards(&self, world: DVec3) -> Option<&Material> {
        (self.material.volume && self.world_ng.dot(world) < 0.0).then_some(self.material)
    }
}

fn weights_of([b1, b2]: [f64; 2]) -> [f64; 3] {
    [1.0 - b1 - b2, b1, b2]
}

/// Unit normal of the front, `None` without area.
fn normal_of([a, b, c]: &[DVec3; 3]) -> Option<DVec3> {
    let (e1, e2) = (b - a, c - a);
    let size = e1.abs().max(e2.abs()).max_element();
    (e1 / size).cross(e2 / size).try_normalize()
}

fn frame_about(normal: DVec3) -> [DVec3; 3] {
    let tangent = normal.any_orthonormal_vector();
    [tangent, normal.cross(tangent), normal]
}
