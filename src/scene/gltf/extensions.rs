//! What Halfway does with each glTF extension.

use super::document::Document;
use super::faults::Faults;
use super::material;
use super::unsupported::{COMPRESSED, unsupported};
use crate::scene::SceneError;

/// Read and honoured (or, like quantisation, a licence for formats that are read anyway), beside those of materials.
const UNDERSTOOD: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_variants",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

fn is_understood(name: &str) -> bool {
    UNDERSTOOD.contains(&name)
        || material::EXTENSIONS.contains(&name)
        || (cfg!(feature = "compressed") && COMPRESSED.contains(&name))
}

/// Refuses required extensions that are not understood, all in one error.
///
/// # Errors
/// [`SceneError::Extensions`] naming every one of them with advice.
pub fn check_required(document: &Document) -> Result<(), SceneError> {
    let mut missing: Vec<&str> = Vec::new();
    for name in &document.extensions_required {
        if !is_understood(name) && !missing.contains(&name.as_str()) {
            missing.push(name);
        }
    }
    if missing.is_empty() { Ok(()) } else { Err(unsupported(&missing)) }
}

/// One warning for each used extension that is ignored: those listed, and those found on materials unlisted.
pub fn warn_ignored(document: &Document, faults: &mut Faults) {
    let on_materials = document.materials.iter().filter_map(|material| material.extensions.as_ref());
    let on_materials = on_materials.flat_map(|extensions| extensions.others.keys());
    let mut seen: Vec<&str> = Vec::new();
    for name in document.extensions_used.iter().chain(on_materials).map(String::as_str) {
        if !is_understood(name) && !seen.contains(&name) {
            seen.push(name);
            let (problem, remedy) = ignored(name);
            faults.note(format!("extension {name}"), problem, remedy);
        }
    }
}

/// What is wrong, and what to do.
fn ignored(name: &str) -> (&'static str, &'static str) {
    match name {
        "EXT_lights_image_based" | "KHR_lights_image_based" => {
            ("the environment in the file is not used", "give a latitude-longitude picture of it with --env")
        }
        _ => ("it is ignored", "the picture may differ"),
    }
}
