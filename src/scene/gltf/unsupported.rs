//! What to do about extensions that cannot be read.

use crate::scene::SceneError;

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

/// The error for extensions without which the file cannot be shown.
pub fn unsupported(names: &[&str]) -> SceneError {
    let names: Vec<String> = names.iter().map(|name| format!("{name} ({})", advice(name))).collect();
    SceneError::Extensions { names: names.join(", ") }
}
