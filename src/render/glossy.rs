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
    bring_light(scene, Part::is_smooth)
}

/// The surfaces that make light tracing worth its time, where there are others for them to light.
pub(super) fn glossy(scene: &Scene) -> Option<String> {
    bring_light(scene, |part| part.roughness <= if part.is_bare { GLOSSY } else { GLAZED })
}

/// What a place of a surface reflects or refracts in lobes.
struct Part {
    roughness: f32,
    /// Metal, or it lets light through: all of the light, not what a glaze reflects of it.
    is_bare: bool,
}

impl Part {
    fn is_smooth(&self) -> bool {
        self.is_bare && self.roughness < SMOOTH
    }
}

/// The surfaces of which a part sends light, where there is some and others are lit: all that are not smooth everywhere.
fn bring_light(scene: &Scene, sends: impl Fn(&Part) -> bool) -> Option<String> {
    let receives = |material: &Material| {
        !material.unlit && (material.is_lambert() || !parts(scene, material).iter().all(Part::is_smooth))
    };
    if !SceneFeatures::of(scene).lights() || names(scene, receives).is_none() {
        return None;
    }
    names(scene, |material| {
        if material.unlit || material.is_lambert() {
            return false;
        }
        let parts = parts(scene, material);
        parts.iter().filter(|part| sends(part)).count() as f32 > LEAST_SHARE * parts.len() as f32
    })
}

/// Places of a surface: one, or some texels.
fn parts(scene: &Scene, material: &Material) -> Vec<Part> {
    let part = |[roughness, metallic]: [f32; 2]| Part {
        roughness: roughness * material.roughness,
        // Less metal than that is noise of the file.
        is_bare: (metallic >= 0.1 && material.metallic > 0.0) || material.transmission > 0.0,
    };
    let texture =
        material.metallic_roughness_texture.and_then(|slot| scene.textures.get(slot.texture as usize));
    let Some(image) = texture.and_then(|texture| scene.images.get(texture.image as usize)) else {
        return vec![part([1.0; 2])];
    };
    let step = |side: u32| (side / TEXELS).max(1) as usize;
    let rows = image.texels.chunks(image.width.max(1) as usize).step_by(step(image.height));
    let texels = rows.flat_map(|row| row.iter().step_by(step(image.width)));
    // Black is what files have where no surface is.
    let used = texels.filter(|texel| texel[1] > 0 || texel[2] > 0);
    used.map(|texel| part([texel[1], texel[2]].map(|value| f32::from(value) / 255.0))).collect()
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
