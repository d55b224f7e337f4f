//! What Halfway does with each glTF extension.

use super::document::{Document, Part};
use super::faults::Faults;
use crate::scene::SceneError;

/// Read and honoured (or, like quantisation, a licence for formats that are read anyway).
const UNDERSTOOD: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// The advice that goes with an extension that is not understood.
fn advice(name: &str) -> &'static str {
    match name {
        "KHR_draco_mesh_compression" => "decompress with `gltf-transform copy in.glb out.glb`",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "decompress with `gltf-transform copy in.glb out.glb`"
        }
        "KHR_texture_basisu" => "convert the textures with `gltf-transform ktxdecompress in.glb out.glb`",
        "KHR_materials_pbrSpecularGlossiness" => {
            "convert the materials with `gltf-transform metalrough in.glb out.glb`"
        }
        _ => "export without it",
    }
}

/// Refuses required extensions that are not understood, all in one error.
///
/// # Errors
/// [`SceneError::Extensions`] naming every one of them with advice.
pub fn check_required(document: &Document) -> Result<(), SceneError> {
    let mut missing: Vec<&str> = Vec::new();
    for name in &document.extensions_required {
        if !UNDERSTOOD.contains(&name.as_str()) && !missing.contains(&name.as_str()) {
            missing.push(name);
        }
    }
    if missing.is_empty() { Ok(()) } else { Err(unsupported(&missing)) }
}

/// The error for extensions without which the file cannot be shown.
pub fn unsupported(names: &[&str]) -> SceneError {
    let names: Vec<String> = names.iter().map(|name| format!("{name} ({})", advice(name))).collect();
    SceneError::Extensions { names: names.join(", ") }
}

/// One warning for each used extension that is ignored: those listed, and those found on materials unlisted.
pub fn warn_ignored(document: &Document, faults: &mut Faults) {
    let on_materials =
        document.materials.iter().filter_map(Part::ok).flat_map(|material| material.extensions.keys());
    let mut seen: Vec<&str> = Vec::new();
    for name in document.extensions_used.iter().chain(on_materials).map(String::as_str) {
        if !UNDERSTOOD.contains(&name) && !seen.contains(&name) {
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
