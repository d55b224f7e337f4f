//! What to do about extensions that cannot be read.

use crate::scene::SceneError;

/// Extensions that are understood in builds with the feature `compressed`.
pub const COMPRESSED: &[&str] = &[
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
];

/// The advice that goes with an extension that is not understood.
fn advice(name: &str) -> &'static str {
    if name == "KHR_texture_basisu" {
        "this build cannot read it: build with the feature `compressed`, or convert the textures with \
         `gltf-transform ktxdecompress in.glb out.glb`"
    } else if COMPRESSED.contains(&name) {
        "this build cannot read it: build with the feature `compressed`, or decompress with \
         `gltf-transform copy in.glb out.glb`"
    } else {
        "export without it"
    }
}

/// The error for extensions without which the file cannot be shown.
pub fn unsupported(names: &[&str]) -> SceneError {
    let names: Vec<String> = names.iter().map(|name| format!("{name} ({})", advice(name))).collect();
    SceneError::Extensions { names: names.join(", ") }
}
