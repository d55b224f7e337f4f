//! What a document is made of, beside the types of `gltf::json`: its lists, and the numbers that these types would round.

use std::collections::BTreeMap;

use gltf::json::extensions::scene::khr_lights_punctual::Light;
use gltf::json::mesh::Semantic;
use gltf::json::texture::Sampler;
use gltf::json::validation::Checked;
use gltf::json::{
    Accessor, Buffer, Camera, Image, Index, Material, Mesh, Node, Root, Scene, Skin, Texture, buffer,
};
use serde::Deserialize;

/// The extension for lights without a surface.
pub const LIGHTS: &str = "KHR_lights_punctual";

/// The extension for materials to choose from.
pub const VARIANTS: &str = "KHR_materials_variants";

/// Accessors by what they are for: those of a primitive or of a morph target.
pub type Attributes = BTreeMap<Checked<Semantic>, Index<Accessor>>;

/// Where a node stands in its parent, and how far its mesh is morphed. `gltf::json` has single precision.
#[derive(Debug, Default, Deserialize)]
pub struct Transform {
    /// Column-major.
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    /// Quaternion x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub weights: Option<Vec<f64>>,
}

/// The morph targets of a mesh. `gltf::json` has weights in single precision, and no colours or texture coordinates of
/// targets.
#[derive(Debug, Default, Deserialize)]
pub struct Morph {
    pub weights: Option<Vec<f64>>,
    /// Of each primitive.
    #[serde(default)]
    pub primitives: Vec<Targets>,
}

/// The morph targets of a primitive.
#[derive(Debug, Default, Deserialize)]
pub struct Targets {
    #[serde(default)]
    pub targets: Vec<Attributes>,
}

/// What the root object has lists of.
pub trait Listed: Sized + 'static {
    /// The name of the list.
    const LIST: &'static str;

    /// All of them.
    fn list(root: &Root) -> &[Self];
}

macro_rules! listed {
    ($($type:ty: $name:literal $member:ident;)*) => { $(
        impl Listed for $type {
            const LIST: &'static str = $name;

            fn list(root: &Root) -> &[Self] {
                &root.$member
            }
        }
    )* };
}

listed! {
    Accessor: "accessors" accessors;
    Buffer: "buffers" buffers;
    buffer::View: "bufferViews" buffer_views;
    Camera: "cameras" cameras;
    Image: "images" images;
    Material: "materials" materials;
    Mesh: "meshes" meshes;
    Node: "nodes" nodes;
    Sampler: "samplers" samplers;
    Scene: "scenes" scenes;
    Skin: "skins" skins;
    Texture: "textures" textures;
}

impl Listed for Light {
    const LIST: &'static str = "KHR_lights_punctual.lights";

    fn list(root: &Root) -> &[Self] {
        let lights = root.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        lights.map_or(&[], |list| &list.lights)
    }
}
