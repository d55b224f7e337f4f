//! Materials and their textures.

use std::collections::BTreeMap;

use glam::Vec3;

use super::Target;
use super::microfacet::{AlbedoTable, Microfacet};
use super::thinning::thinning_units;
use super::units::scaled;
use crate::accel::UnitSpace;
use crate::device::layout::{
    MATERIAL_DELTA, MATERIAL_DOUBLE_SIDED, MATERIAL_MASK, MATERIAL_UNLIT, MATERIAL_VOLUME, Material,
    TEXTURE_NEAREST, TEXTURE_SRGB, TEXTURE_UV1, THINNING_SHIFT, THINNING_UNITS, TextureSlot,
};
use crate::device::pages::PageWriter;
use crate::device::{DeviceError, Feature, Features, PagedBuffer};
use crate::scene::{self, AlphaMode, Filter, Scene, SceneFeatures, TextureRef};

/// Uploads `materials`, `ggx_albedo_table` where there are microfacets, and `texture_slots` and `texels` where the scene has
/// textures. True where connections of some material
/// are thinned.
pub(super) fn upload(
    target: &mut Target<'_>,
    scene: &Scene,
    unit: &UnitSpace,
    features: &SceneFeatures,
    radiance_exponent: i32,
) -> Result<bool, DeviceError> {
    let mut textures =
        Textures { scene, slots: Vec::new(), images: Vec::new(), placed: BTreeMap::new(), end: 0 };
    let mut materials = Vec::with_capacity(scene.materials.len().max(1));
    let mut thins = false;
    let is_whole = Features::from(*features).contains(Feature::SurfaceTextures);
    let mut table = (!features.lambert_only).then(|| AlbedoTable::new(is_whole));
    for material in &scene.materials {
        let thinning = thinning_units(scene, material);
        thins |= thinning < THINNING_UNITS;
        let facets = table.as_mut().map_or_else(Microfacet::default, |table| table.microfacet(material));
        let mut slot = |texture: Option<TextureRef>, srgb: bool| match texture {
            Some(texture) if features.textures => textures.slot(texture, srgb),
            _ => 0,
        };
        materials.push(Material {
            base_color: material.base_color.to_array(),
            flags: flags(material) | thinning << THINNING_SHIFT,
            emission: emission(material, radiance_exponent).to_array(),
            opacity: material.alpha,
            f0: facets.f0.to_array(),
            f90: facets.f90,
            absorption: absorption(material, unit).to_array(),
            alpha_cutoff: match material.alpha_mode {
                AlphaMode::Mask { cutoff } => cutoff,
                _ => 0.0,
            },
            metallic: material.metallic,
            alpha: facets.alpha,
            transmission: material.transmission,
            eta: facets.eta,
            inv_base_average: facets.inv_base_average,
            albedo_row: facets.row,
            roughness: material.roughness,
            ior: material.ior,
            specular_color: material.specular_color.to_array(),
            specular: material.specular,
            normal_scale: material.normal_scale,
            base_color_texture: slot(material.base_color_texture, true),
            metallic_roughness_texture: slot(material.metallic_roughness_texture, false),
            normal_texture: slot(material.normal_texture, false),
            emission_texture: slot(material.emission_texture.filter(|_| !material.unlit), true),
            specular_texture: slot(material.specular_texture, false),
            specular_color_texture: slot(material.specular_color_texture, true),
            transmission_texture: slot(material.transmission_texture, false),
        });
    }
    target.buffers.upload(target.context, "materials", &materials)?;
    if let Some(table) = table {
        target.buffers.upload(target.context, "ggx_albedo_table", &table.texels)?;
    }
    if features.textures {
        target.buffers.upload(target.context, "texture_slots", &textures.slots)?;
        textures.upload(target)?;
    }
    Ok(thins)
}

fn flags(material: &scene::Material) -> u32 {
    let bit = |set: bool, flag: u32| if set { flag } else { 0 };
    bit(material.is_delta(), MATERIAL_DELTA)
        | bit(material.volume && material.transmission > 0.0, MATERIAL_VOLUME)
        | bit(material.double_sided, MATERIAL_DOUBLE_SIDED)
        | bit(material.unlit, MATERIAL_UNLIT)
        | bit(matches!(material.alpha_mode, AlphaMode::Mask { .. }), MATERIAL_MASK)
}

/// The factor that the kernels multiply with the emission texture, and for unlit materials with the base colour.
fn emission(material: &scene::Material, radiance_exponent: i32) -> Vec3 {
    scaled(if material.unlit { Vec3::ONE } else { material.emission }, radiance_exponent)
}

/// Beer and Lambert: absorption per unit length, such that white becomes the attenuation colour after the
/// attenuation distance. A colour of zero absorbs all within a tiny part of that distance.
fn absorption(material: &scene::Material, unit: &UnitSpace) -> Vec3 {
    let distance = unit.length(f64::from(material.attenuation_distance));
    if !distance.is_finite() || distance <= 0.0 {
        return Vec3::ZERO;
    }
    let absorb = |channel: f32| (-f64::from(channel.max(f32::MIN_POSITIVE)).ln() / distance).min(1e30) as f32;
    material.attenuation_color.to_array().map(absorb).into()
}

struct Textures<'a> {
    scene: &'a Scene,
    slots: Vec<TextureSlot>,
    /// Those that have a place, in its order.
    images: Vec<u32>,
    /// First texel of each of them.
    placed: BTreeMap<u32, u32>,
    /// Texels of all of them.
    end: u64,
}

impl Textures<'_> {
    /// Index plus one of a slot for the texture.
    fn slot(&mut self, reference: TextureRef, srgb: bool) -> u32 {
        let texture = self.scene.textures[reference.texture as usize];
        let image = &self.scene.images[texture.image as usize];
        let (images, end) = (&mut self.images, &mut self.end);
        let offset = *self.placed.entry(texture.image).or_insert_with(|| {
            images.push(texture.image);
            let offset = *end as u32;
            *end += image.texels.len() as u64;
            offset
        });
        let bit = |set: bool, flag: u32| if set { flag } else { 0 };
        let transform = reference.transform;
        let [u, v] = [0, 1].map(|row| {
            [transform.matrix2.x_axis[row], transform.matrix2.y_axis[row], transform.translation[row]]
        });
        self.slots.push(TextureSlot {
            offset,
            width: image.width,
            height: image.height,
            flags: texture.wrap[0] as u32
                | (texture.wrap[1] as u32) << 2
                | bit(texture.filter == Filter::Nearest, TEXTURE_NEAREST)
                | bit(srgb, TEXTURE_SRGB)
                | bit(reference.uv_set == 1, TEXTURE_UV1),
            row_u: u,
            pad0: 0,
            row_v: v,
            pad1: 0,
        });
        self.slots.len() as u32
    }

    /// Straight from the images: there is no copy of all of them.
    fn upload(&self, target: &mut Target<'_>) -> Result<(), DeviceError> {
        let mut writer = PageWriter::new(target.context, &mut target.buffers, PagedBuffer::Texels, self.end)?;
        for &image in &self.images {
            writer.push(&self.scene.images[image as usize].texels)?;
        }
        writer.finish(&mut target.pages, &mut target.constants);
        Ok(())
    }
}
