//! How many of its connections an eye vertex makes, by its material (`shaders/lib/thinning.wgsl`).

use crate::device::layout::THINNING_UNITS;
use crate::math::color::luminance;
use crate::scene::{Material, Scene};

/// GGX's alpha from which a lobe has all of its connections.
const BROAD_ALPHA: f32 = 0.02;
/// Share of its connections that the narrowest lobe has: light that is small and near is found best by these.
const LEAST_SHARE: f32 = 0.125;
/// Reflectance of glass and plastic, seen frontally.
const DIELECTRIC: f32 = 0.04;

/// In units of 1 / [`THINNING_UNITS`], at least 1: what the broad lobes scatter, and of what narrow ones do a share.
/// Textures count by their means.
pub(super) fn thinning_units(scene: &Scene, material: &Material) -> u32 {
    if material.unlit || material.is_delta() {
        return THINNING_UNITS;
    }
    let [roughness, metallic] = match material.metallic_roughness_texture {
        Some(texture) => {
            let image = &scene.images[scene.textures[texture.texture as usize].image as usize];
            let mean = |channel: usize| {
                let sum: u64 = image.texels.iter().map(|texel| u64::from(texel[channel])).sum();
                sum as f32 / (255.0 * image.texels.len() as f32)
            };
            [material.roughness * mean(1), material.metallic * mean(2)]
        }
        None => [material.roughness, material.metallic],
    };
    let lobe = (roughness * roughness / BROAD_ALPHA).clamp(LEAST_SHARE, 1.0);
    let color = luminance(material.base_color);
    let diffuse = (1.0 - metallic) * (1.0 - material.transmission) * color;
    let narrow = metallic * color
        + (1.0 - metallic) * (material.transmission * color + DIELECTRIC * material.specular);
    if diffuse + narrow <= 0.0 {
        return THINNING_UNITS;
    }
    let share = (diffuse + narrow * lobe) / (diffuse + narrow);
    ((share * THINNING_UNITS as f32).round() as u32).clamp(1, THINNING_UNITS)
}
