//! The scene as plain data: what a glTF file holds, flattened to world space, before anything is built from it.
//!
//! Units are the file's own (metres by convention). Positions are `f64`, so that a scene far from its origin
//! loses nothing before it is recentred. Colours are linear Rec.709. A triangle's front is the side from which
//! its vertices run counter-clockwise; the loader has already turned the windings that a mirroring transform
//! turns over.

pub mod builtin;
pub mod environment;
mod error;
pub mod features;
pub mod gltf;

mod bounds;
mod camera;
mod hash;
mod instance;
mod light;
mod light_groups;
mod material;
mod pick;
mod texture;
mod viewpoint;
mod warning;

use glam::{DVec3, Vec2, Vec3, Vec4};

pub use bounds::Bounds;
pub use camera::{Camera, Pose, Projection};
pub use environment::{Environment, EqualAreaMap};
pub use error::{SceneError, ViewpointError};
pub use features::SceneFeatures;
pub use instance::{Instance, Instancing, Repeated, normal_matrix, worth_keeping};
pub use light::{LightKind, PunctualLight};
pub use light_groups::LightGroup;
pub use material::{AlphaMode, MIN_REFRACTED_SPREAD, Material, TextureRef};
pub use texture::{Filter, Image, Texture, Wrap};
pub use viewpoint::{Viewpoint, moved_name};
pub use warning::Warning;

/// Everything a picture is made from. No invariants beyond those stated at the fields; every index is in range.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The file's stem, or the name of a built-in scene.
    pub name: String,
    /// World-space meshes, but for those with instances.
    pub meshes: Vec<Mesh>,
    pub materials: Vec<Material>,
    /// Decoded pictures, shared by `textures`.
    pub images: Vec<Image>,
    /// A picture with the way it is sampled; material slots refer to these.
    pub textures: Vec<Texture>,
    /// Lights without a surface: point, spot, directional.
    pub lights: Vec<PunctualLight>,
    pub cameras: Vec<Camera>,
    /// The last of `cameras` is none of the scene's own ([`Scene::place_camera`]).
    pub camera_placed: bool,
    pub environment: Option<Environment>,
    /// Names of the sets of materials that the file has to choose from (`KHR_materials_variants`).
    pub variants: Vec<String>,
    /// Width and height that the file asks for (`extras.resolution` of the root), in pixels.
    pub resolution: Option<[u32; 2]>,
    /// What unit space (`accel`) has in its middle, scene units; `None` for the middle of the box around all triangles.
    pub middle: Option<DVec3>,
    /// How meshes are held that are shown often.
    pub repeated: Vec<Repeated>,
    /// What is not shown as the file has it.
    pub warnings: Vec<Warning>,
}

/// A set of triangles with one material, in world space; in a space of its own where it has instances.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub name: String,
    /// Index into [`Scene::materials`].
    pub material: u32,
    pub positions: Vec<DVec3>,
    /// Unit shading normals, one per vertex; `None` means flat shading.
    pub normals: Option<Vec<Vec3>>,
    /// Unit tangents with the sign of the bitangent in `w`; present wherever the material has a normal map.
    pub tangents: Option<Vec<Vec4>>,
    /// `TEXCOORD_0` and `TEXCOORD_1`.
    pub uvs: [Option<Vec<Vec2>>; 2],
    /// `COLOR_0`: linear, multiplies base colour and alpha.
    pub colors: Option<Vec<Vec4>>,
    pub triangles: Vec<[u32; 3]>,
    /// Where the mesh is shown; empty for one that is shown once, as it is. Meshes that emit have none.
    pub instances: Vec<Instance>,
}

impl Scene {
    /// Number of triangles that are shown, all meshes and their instances together.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles.len() * mesh.places()).sum()
    }

    /// The box around all vertices; the origin where there are none.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.meshes.iter().flat_map(Mesh::world_positions))
    }

    /// Lets the camera look through the backs of single-sided surfaces, as glTF has it where `doubleSided` is false. What
    /// transmits light stays: its back is the inside of a solid. Light meets all surfaces from both sides.
    pub fn cull_backs(&mut self) {
        for material in &mut self.materials {
            material.culled = !material.double_sided && material.transmission == 0.0;
        }
    }

    /// The cameras that are the scene's own.
    pub fn own_cameras(&self) -> &[Camera] {
        let placed = usize::from(self.camera_placed);
        &self.cameras[..self.cameras.len().saturating_sub(placed)]
    }

    /// Adds a camera that is none of the scene's own, in place of the one that was added before; returns its index. The
    /// content stays the same, so that what was learnt of the scene stays valid.
    pub fn place_camera(&mut self, camera: Camera) -> usize {
        self.cameras.truncate(self.own_cameras().len());
        self.cameras.push(camera);
        self.camera_placed = true;
        self.cameras.len() - 1
    }
}
