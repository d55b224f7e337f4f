//! Takes out of a document what `gltf::json::Root` would fall over: that type is read whole or not at all, and a part
//! that nothing refers to, or a member that nothing reads, is no reason to refuse a scene.

use std::collections::HashMap;

use gltf::json::extensions::mesh::KhrMaterialsVariants as VariantMaterials;
use gltf::json::extensions::root::{KhrLightsPunctual as LightList, KhrMaterialsVariants as VariantList};
use gltf::json::extensions::scene::khr_lights_punctual::{KhrLightsPunctual as LightReference, Light};
use gltf::json::mesh::Primitive;
use gltf::json::texture::Sampler;
use gltf::json::{Accessor, Camera, Image, Material, Mesh, Node, Skin, Texture, buffer};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Error, Map, Value, json};

use super::parts::{LIGHTS, Listed, Morph, Targets, VARIANTS};

/// Members that are not read, by their list: whatever stands there is left out.
const UNREAD: &[(&str, &[&str])] = &[
    ("accessors", &["min", "max", "name"]),
    ("buffers", &["name"]),
    ("bufferViews", &["name", "target"]),
    ("images", &["mimeType"]),
    ("materials", &["occlusionTexture"]),
    ("samplers", &["minFilter", "name"]),
    ("skins", &["name", "skeleton"]),
    ("textures", &["name"]),
];

/// Members that `gltf::json` asks for, and what glTF, or its reader here, takes where they are absent. Depth ranges and
/// aspect ratios are not read; 0 is no extent and no angle of view, which is said where the camera is used.
const CAMERA_DEFAULTS: &[(&str, &[&str])] =
    &[("perspective", &["yfov", "znear"]), ("orthographic", &["xmag", "ymag", "zfar", "znear"])];

/// Leaves out what is not read, and fills in what may be absent.
pub fn tidy(document: &mut Value) {
    let extras = document.get_mut("extras").map(Value::take);
    strip(document);
    let Some(root) = document.as_object_mut() else { return };
    root.extend(extras.map(|extras| ("extras".into(), extras)));
    // The version has been looked at, and nothing else of it is read.
    root.insert("asset".into(), json!({"version": "2.0"}));
    root.remove("animations");
    for (list, members) in UNREAD {
        for part in objects(root, list) {
            part.retain(|name, _| !members.contains(&name.as_str()));
        }
    }
    for scene in objects(root, "scenes") {
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
    for camera in objects(root, "cameras") {
        for (kind, members) in CAMERA_DEFAULTS {
            let Some(projection) = camera.get_mut(*kind).and_then(Value::as_object_mut) else { continue };
            for unread in ["aspectRatio", "zfar", "znear"] {
                projection.remove(unread);
            }
            for member in *members {
                projection.entry(*member).or_insert_with(|| json!(0));
            }
        }
    }
}

/// The members of a root list that are objects.
fn objects<'a>(
    root: &'a mut Map<String, Value>,
    list: &str,
) -> impl Iterator<Item = &'a mut Map<String, Value>> {
    root.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().filter_map(Value::as_object_mut)
}

/// Leaves out all extras, and members that are null, which exporters write for absent ones. The parser has limited the
/// depth.
fn strip(value: &mut Value) {
    match value {
        Value::Object(members) => {
            members.retain(|name, member| name != "extras" && !member.is_null());
            members.values_mut().for_each(strip);
        }
        Value::Array(items) => items.iter_mut().filter(|item| !item.is_number()).for_each(strip),
        _ => {}
    }
}

/// A list of the root whose elements are parts: what such an element is read as, and an empty one.
struct Shape {
    pointer: &'static str,
    /// As places of parts have it.
    list: &'static str,
    read: fn(&Value) -> Result<(), Error>,
    empty: fn() -> Value,
}

impl Shape {
    const fn of<T: Listed + DeserializeOwned>(pointer: &'static str, empty: fn() -> Value) -> Self {
        Self { pointer, list: T::LIST, read: read::<T>, empty }
    }
}

const SHAPES: &[Shape] = &[
    Shape::of::<Accessor>("/accessors", || json!({"componentType": 5121, "count": 0, "type": "SCALAR"})),
    Shape::of::<buffer::View>("/bufferViews", || json!({"buffer": 0, "byteLength": 0})),
    Shape::of::<Camera>("/cameras", || json!({"type": "perspective"})),
    Shape::of::<Image>("/images", || json!({})),
    Shape::of::<Light>("/extensions/KHR_lights_punctual/lights", || json!({"type": "point"})),
    Shape::of::<Material>("/materials", || json!({})),
    Shape::of::<Sampler>("/samplers", || json!({})),
    Shape::of::<Skin>("/skins", || json!({"joints": []})),
    Shape::of::<Texture>("/textures", || json!({})),
];

fn read<T: DeserializeOwned>(value: &Value) -> Result<(), Error> {
    T::deserialize(value).map(drop)
}

/// Empties the parts that have another shape than glTF prescribes, and notes what is wrong with each by its place.
/// Returns the morph targets of the meshes.
pub fn faulty_parts(document: &mut Value, faulty: &mut HashMap<String, String>) -> Vec<Morph> {
    for shape in SHAPES {
        empty(document.pointer_mut(shape.pointer), shape.list, shape.read, shape.empty, faulty);
    }
    if let Some(extensions) = document.get_mut("extensions") {
        remove::<LightList>(extensions, LIGHTS, LIGHTS, faulty);
        remove::<VariantList>(extensions, VARIANTS, VARIANTS, faulty);
    }
    for (index, node) in items(document, "nodes") {
        let place = format!("{}[{index}].{LIGHTS}", Node::LIST);
        if let Some(extensions) = node.get_mut("extensions") {
            remove::<LightReference>(extensions, LIGHTS, &place, faulty);
        }
    }
    items(document, "meshes").map(|(index, mesh)| morph(mesh, index, faulty)).collect()
}

/// Empties a mesh, or those of its primitives, that have another shape than glTF prescribes.
fn morph(mesh: &mut Value, index: usize, faulty: &mut HashMap<String, String>) -> Morph {
    let place = format!("{}[{index}]", Mesh::LIST);
    let list = format!("{place}.primitives");
    for (index, primitive) in items(mesh, "primitives") {
        if let Some(extensions) = primitive.get_mut("extensions") {
            let place = format!("{list}[{index}].{VARIANTS}");
            remove::<VariantMaterials>(extensions, VARIANTS, &place, faulty);
        }
    }
    let both = |value: &Value| read::<Targets>(value).and(read::<Primitive>(value));
    empty(mesh.get_mut("primitives"), &list, both, || json!({"attributes": {}}), faulty);
    let morph = Morph::deserialize(&*mesh).and_then(|morph| read::<Mesh>(mesh).map(|()| morph));
    morph.unwrap_or_else(|error| {
        faulty.insert(place, error.to_string());
        *mesh = json!({"primitives": []});
        Morph::default()
    })
}

fn items<'a>(document: &'a mut Value, list: &str) -> impl Iterator<Item = (usize, &'a mut Value)> {
    document.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().enumerate()
}

/// Puts an empty element in the place of each that cannot be read.
fn empty(
    parts: Option<&mut Value>,
    list: &str,
    read: impl Fn(&Value) -> Result<(), Error>,
    empty: impl Fn() -> Value,
    faulty: &mut HashMap<String, String>,
) {
    for (index, part) in parts.and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
        if let Err(error) = read(part) {
            faulty.insert(format!("{list}[{index}]"), error.to_string());
            *part = empty();
        }
    }
}

/// Removes an extension object that cannot be read.
fn remove<T: DeserializeOwned>(
    extensions: &mut Value,
    name: &str,
    place: &str,
    faulty: &mut HashMap<String, String>,
) {
    let Some(extensions) = extensions.as_object_mut() else { return };
    if let Some(Err(error)) = extensions.get(name).map(read::<T>) {
        faulty.insert(place.into(), error.to_string());
        extensions.remove(name);
    }
}
