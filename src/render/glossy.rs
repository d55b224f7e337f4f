//! Which surfaces send light on in lobes: light paths that are connected to the camera find what eye paths miss of it.

use crate::scene::{Material, Scene, SceneFeatures};

/// Roughness below which what a surface reflects or refracts is as good as never found by chance.
const SMOOTH: f32 = 0.2;
/// Roughness up to which light tracing pays: that of metals and of what lets light through, and that of what has a glaze
/// (docs/measurements.md, Light tracing).
const GLOSSY: f32 = 0.5;
const GLAZED: f32 = 0.25;
/// Texels along either side of a texture that are looked at, at most twice as many, and the share of them that counts.
const TEXELS: u32 = 64;
const LEAST_SHARE: f32 = 0.01;
/// Materials that are named.
const NAMED: usize = 3;

/// The smooth metals and transparent surfaces that bring light to others, where there are both and light.
pub(super) fn caustics(scene: &Scene) -> Option<String> {
    let is_smooth = |material: &Material| sends(scene, material, SMOOTH.next_down(), 0.0);
    bring_light(scene, is_smooth, is_smooth)
}

/// The surfaces that make light tracing worth its time, where there are others for them to light.
pub(super) fn glossy(scene: &Scene) -> Option<String> {
    let is_smooth = |material: &Material| sends(scene, material, SMOOTH.next_down(), 0.0);
    bring_light(scene, |material| sends(scene, material, GLOSSY, GLAZED), is_smooth)
}

/// Those that send light, where there is some and others are lit: all that are not smooth.
fn bring_light(
    scene: &Scene,
    send: impl Fn(&Material) -> bool,
    is_smooth: impl Fn(&Material) -> bool,
) -> Option<String> {
    let receives = |material: &Material| !material.unlit && !is_smooth(material);
    if !SceneFeatures::of(scene).lights() || names(scene, receives).is_none() {
        return None;
    }
    names(scene, send)
}

/// A part of the surface reflects or refracts in lobes of no more roughness: metal and what lets light through up to `bare`,
/// others up to `glazed`.
fn sends(scene: &Scene, material: &Material, bare: f32, glazed: f32) -> bool {
    if material.unlit || material.is_lambert() {
        return false;
    }
    let sends = |&[roughness, metallic]: &[f32; 2]| {
        let is_bare = metallic > 0.0 || material.transmission > 0.0;
        (is_bare && roughness <= bare) || (material.specular > 0.0 && roughness <= glazed)
    };
    let parts = parts(scene, material);
    parts.iter().filter(|part| sends(part)).count() as f32 > LEAST_SHARE * parts.len() as f32
}

/// Roughness and metalness in places of a surface: one, or those of some texels.
fn parts(scene: &Scene, material: &Material) -> Vec<[f32; 2]> {
    let factors = [material.roughness, material.metallic];
    let texture =
        material.metallic_roughness_texture.and_then(|slot| scene.textures.get(slot.texture as usize));
    let Some(image) = texture.and_then(|texture| scene.images.get(texture.image as usize)) else {
        return vec![factors];
    };
    let step = |side: u32| (side / TEXELS).max(1) as usize;
    let rows = image.texels.chunks(image.width.max(1) as usize).step_by(step(image.height));
    let of_texel = |texel: &[u8; 4]| {
        // Less metal than that is noise of the file.
        let [roughness, metallic] = [texel[1], texel[2]].map(|value| f32::from(value) / 255.0);
        [factors[0] * roughness, if metallic < 0.1 { 0.0 } else { factors[1] * metallic }]
    };
    rows.flat_map(|row| row.iter().step_by(step(image.width)).map(of_texel)).collect()
}

/// Materials of triangles that fit, by name; `None` where there are none.
pub(super) fn names(scene: &Scene, fits: impl Fn(&Material) -> bool) -> Option<String> {
    let mut used = vec![false; scene.materials.len()];
    for mesh in scene.meshes.iter().filter(|mesh| !mesh.triangles.is_empty()) {
        if let Some(used) = used.get_mut(mesh.material as usize) {
            *used = true;
        }
    }
    let mut names: Vec<&str> = Vec::new();
    for (material, _) in scene.materials.iter().zip(used).filter(|&(_, used)| used) {
        if !names.contains(&material.name.as_str()) && fits(material) {
            names.push(&material.name);
        }
    }
    let others = names.len().saturating_sub(NAMED);
    let quoted: Vec<String> = names.iter().take(NAMED).map(|name| format!("\"{name}\"")).collect();
    let list = quoted.join(", ");
    match (names.is_empty(), others) {
        (true, _) => None,
        (_, 0) => Some(list),
        _ => Some(format!("{list} and {others} more")),
    }
}
