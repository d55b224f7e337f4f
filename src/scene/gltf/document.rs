//! The document of a glTF 2.0 file: `gltf::json::Root`, and beside it what that type cannot hold as the file has it.
//!
//! Nothing here is validated beyond its shape; each index is looked up through [`Document::get`].

use std::collections::{BTreeMap, HashMap};
use std::ops::Deref;

use gltf::json::extensions::scene::khr_lights_punctual::Light;
use gltf::json::mesh::Semantic;
use gltf::json::texture::Sampler;
use gltf::json::validation::Checked;
use gltf::json::{
    Accessor, Buffer, Camera, Image, Index, Material, Mesh, Node, Root, Scene, Skin, Texture, buffer,
};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::integers::BEYOND;
use super::sieve;
use crate::scene::SceneError;

/// The extension for lights without a surface.
pub const LIGHTS: &str = "KHR_lights_punctual";

/// The extension for materials to choose from.
pub const VARIANTS: &str = "KHR_materials_variants";

/// Accessors by what they are for: those of a primitive or of a morph target.
pub type Attributes = BTreeMap<Checked<Semantic>, Index<Accessor>>;

/// The root object. Parts that are faulty are empty there.
#[derive(Debug)]
pub struct Document {
    root: Root,
    /// Of each node.
    pub transforms: Vec<Transform>,
    /// Of each mesh.
    pub morphs: Vec<Morph>,
    /// What is wrong, by the place of the part.
    faulty: HashMap<String, String>,
}

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

impl Deref for Document {
    type Target = Root;

    fn deref(&self) -> &Root {
        &self.root
    }
}

impl Document {
    /// Reads the document from its JSON, of which `integers::repair` has made integers of what has to be some.
    ///
    /// # Errors
    /// [`SceneError::Json`] where the root, a node, a scene or a buffer has another shape than glTF prescribes. What is
    /// wrong with other parts is an error of [`Self::get`].
    pub fn new(mut value: Value) -> Result<Self, SceneError> {
        sieve::tidy(&mut value);
        let mut faulty = HashMap::new();
        let morphs = sieve::faulty_parts(&mut value, &mut faulty);
        let malformed = |cause| SceneError::Json { cause };
        let transforms = match value.get("nodes") {
            Some(nodes) => Vec::deserialize(nodes).map_err(malformed)?,
            None => Vec::new(),
        };
        let root = Root::deserialize(value).map_err(malformed)?;
        Ok(Self { root, transforms, morphs, faulty })
    }

    /// The part that `index` refers to; `from` names the place of the reference.
    ///
    /// # Errors
    /// A part that is not there, or that has another shape than glTF prescribes.
    pub fn get<T: Listed>(&self, index: Index<T>, from: &str) -> Result<&T, SceneError> {
        let items = T::list(&self.root);
        let item = at(items, index, from)?;
        self.whole(&format!("{}[{}]", T::LIST, index.value()))?;
        Ok(item)
    }

    /// The names of the file's variants.
    pub fn variants(&self) -> Vec<String> {
        let extensions = self.root.extensions.as_ref();
        let list = extensions.and_then(|extensions| extensions.khr_materials_variants.as_ref());
        list.into_iter().flat_map(|list| &list.variants).map(|variant| variant.name.clone()).collect()
    }

    /// Says what is wrong with the shape of the part at `place`.
    pub fn whole(&self, place: &str) -> Result<(), SceneError> {
        match self.faulty.get(place) {
            None => Ok(()),
            Some(detail) => {
                Err(SceneError::invalid(place, "TYPE_MISMATCH", format!("it cannot be read: {detail}")))
            }
        }
    }
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

/// Element `index` of a list that goes with the root's list of `T`, or the error that names both and the place of the
/// reference.
pub fn at<'a, T: Listed, U>(items: &'a [U], index: Index<T>, from: &str) -> Result<&'a U, SceneError> {
    items.get(index.value()).ok_or_else(|| {
        let (list, count) = (T::LIST, items.len());
        let detail = if index.value() == BEYOND as usize {
            format!("refers to {list} by an index that 32 bits do not hold, but there are only {count}")
        } else {
            format!("refers to {list}[{}], but there are only {count}", index.value())
        };
        SceneError::invalid(from, "UNRESOLVED_REFERENCE", detail)
    })
}

/// Reads an extension object for which `gltf::json` has no type; `None` where it is absent.
pub fn extension<T: DeserializeOwned>(
    extensions: Option<&Map<String, Value>>,
    name: &str,
    from: &str,
) -> Result<Option<T>, SceneError> {
    let Some(value) = extensions.and_then(|extensions| extensions.get(name)) else { return Ok(None) };
    T::deserialize(value).map(Some).map_err(|error| {
        SceneError::invalid(from, "TYPE_MISMATCH", format!("cannot read extension {name}: {error}"))
    })
}
