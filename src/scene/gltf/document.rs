//! The JSON of a glTF 2.0 file, as far as Halfway reads it.
//!
//! These types are our own because a renderer wants numbers as the file has them: `gltf-json` cuts indices to
//! 32 bits (4294967296 becomes 0) and node transforms to `f32`. Nothing here is validated beyond its shape;
//! every index is looked up through [`at`] or [`part`].

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};

use crate::scene::SceneError;

/// Extension objects by name.
pub type Extensions = Map<String, Value>;

/// An element of the document that may have another shape than glTF prescribes: that concerns nothing but what refers
/// to it.
#[derive(Debug)]
pub struct Part<T>(Result<T, serde_json::Error>);

impl<'de, T: DeserializeOwned> Deserialize<'de> for Part<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self(T::deserialize(Value::deserialize(deserializer)?)))
    }
}

impl<T> Part<T> {
    /// The element, if it has the right shape; `place` names it.
    pub fn get(&self, place: impl FnOnce() -> String) -> Result<&T, SceneError> {
        self.0.as_ref().map_err(|error| {
            SceneError::invalid(place(), "TYPE_MISMATCH", format!("it cannot be read: {error}"))
        })
    }

    /// The element, if it has the right shape.
    pub fn ok(&self) -> Option<&T> {
        self.0.as_ref().ok()
    }
}

/// The root object.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Document {
    #[serde(default)]
    pub extensions_used: Vec<String>,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub extensions: Extensions,
    #[serde(default)]
    pub extras: Value,
    pub scene: Option<u64>,
    #[serde(default)]
    pub scenes: Vec<SceneList>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub meshes: Vec<Part<Mesh>>,
    #[serde(default)]
    pub skins: Vec<Part<Skin>>,
    #[serde(default)]
    pub cameras: Vec<Part<Camera>>,
    #[serde(default)]
    pub materials: Vec<Part<Material>>,
    #[serde(default)]
    pub textures: Vec<Part<Texture>>,
    #[serde(default)]
    pub samplers: Vec<Part<Sampler>>,
    #[serde(default)]
    pub images: Vec<Part<Image>>,
    #[serde(default)]
    pub accessors: Vec<Part<Accessor>>,
    #[serde(default)]
    pub buffer_views: Vec<Part<BufferView>>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
}

#[derive(Debug, Deserialize)]
pub struct SceneList {
    pub name: Option<String>,
    #[serde(default)]
    pub nodes: Vec<u64>,
}

#[derive(Debug, Deserialize)]
pub struct Node {
    pub name: Option<String>,
    #[serde(default)]
    pub children: Vec<u64>,
    pub mesh: Option<u64>,
    pub skin: Option<u64>,
    pub camera: Option<u64>,
    /// Column-major.
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    /// Quaternion x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub weights: Option<Vec<f64>>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Deserialize)]
pub struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Part<Primitive>>,
    pub weights: Option<Vec<f64>>,
}

#[derive(Debug, Deserialize)]
pub struct Primitive {
    pub attributes: Map<String, Value>,
    pub indices: Option<u64>,
    pub material: Option<u64>,
    #[serde(default = "triangles")]
    pub mode: u64,
    #[serde(default)]
    pub targets: Vec<Map<String, Value>>,
    #[serde(default)]
    pub extensions: Extensions,
}

fn triangles() -> u64 {
    4
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Skin {
    pub inverse_bind_matrices: Option<u64>,
    pub joints: Vec<u64>,
}

#[derive(Debug, Deserialize)]
pub struct Camera {
    pub name: Option<String>,
    #[serde(rename = "type", default)]
    pub kind: String,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
pub struct Perspective {
    /// 0 where it is missing, which is no angle of view; likewise below.
    #[serde(default)]
    pub yfov: f64,
}

#[derive(Debug, Deserialize)]
pub struct Orthographic {
    #[serde(default)]
    pub xmag: f64,
    #[serde(default)]
    pub ymag: f64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    pub name: Option<String>,
    pub pbr_metallic_roughness: Option<MetallicRoughness>,
    pub normal_texture: Option<TextureInfo>,
    pub emissive_texture: Option<TextureInfo>,
    pub emissive_factor: Option<[f64; 3]>,
    pub alpha_mode: Option<String>,
    pub alpha_cutoff: Option<f64>,
    #[serde(default)]
    pub double_sided: bool,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct MetallicRoughness {
    pub base_color_factor: Option<[f64; 4]>,
    pub base_color_texture: Option<TextureInfo>,
    pub metallic_factor: Option<f64>,
    pub roughness_factor: Option<f64>,
    pub metallic_roughness_texture: Option<TextureInfo>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    pub index: u64,
    #[serde(default)]
    pub tex_coord: u64,
    /// Normal textures only.
    pub scale: Option<f64>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Deserialize)]
pub struct Texture {
    pub sampler: Option<u64>,
    pub source: Option<u64>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Sampler {
    pub mag_filter: Option<u64>,
    pub wrap_s: Option<u64>,
    pub wrap_t: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Image {
    pub name: Option<String>,
    pub uri: Option<String>,
    pub buffer_view: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<u64>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u64,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: u64,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: u64,
    #[serde(default)]
    pub byte_offset: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: u64,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub byte_length: u64,
    pub uri: Option<String>,
}

/// Element `index` of the root array `what`, or the error that names both and the place of the reference.
pub fn at<'a, T>(items: &'a [T], index: u64, what: &'static str, from: &str) -> Result<&'a T, SceneError> {
    usize::try_from(index).ok().and_then(|i| items.get(i)).ok_or_else(|| {
        SceneError::invalid(
            from,
            "UNRESOLVED_REFERENCE",
            format!("refers to {what}[{index}], but there are only {}", items.len()),
        )
    })
}

/// Element `index` of the root array `what`, as [`at`] has it, if it has the right shape.
pub fn part<'a, T>(
    items: &'a [Part<T>],
    index: u64,
    what: &'static str,
    from: &str,
) -> Result<&'a T, SceneError> {
    at(items, index, what, from)?.get(|| format!("{what}[{index}]"))
}

/// Reads an extension object into its type; `None` where it is absent.
pub fn extension<T: DeserializeOwned>(
    extensions: &Extensions,
    name: &str,
    from: &str,
) -> Result<Option<T>, SceneError> {
    let Some(value) = extensions.get(name) else { return Ok(None) };
    T::deserialize(value).map(Some).map_err(|error| {
        SceneError::invalid(from, "TYPE_MISMATCH", format!("cannot read extension {name}: {error}"))
    })
}
