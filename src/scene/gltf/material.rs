//! glTF materials to ours.

use std::path::Path;

use glam::{Affine2, Mat2, Vec2, Vec3};
use serde::Deserialize;

use super::LoadOptions;
use super::buffers::Buffers;
use super::document::{self, Document, TextureInfo, extension, part};
use super::faults::Faults;
use super::image::{TextureTable, magenta};
use super::unsupported::unsupported;
use crate::scene::material::{AlphaMode, Material, TextureRef};
use crate::scene::{Scene, SceneError};

/// Extensions of materials that are read here.
pub(super) const EXTENSIONS: &[&str] = &[
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
];

/// `KHR_materials_ior` writes 0 for an infinite index (a dielectric that reflects everything); this stands for it,
/// with a reflectance of 0.996 at normal incidence.
const IOR_OF_INFINITY: f64 = 1000.0;

const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct EmissiveStrength {
    emissive_strength: Option<f64>,
}

#[derive(Deserialize)]
struct Ior {
    ior: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Specular {
    specular_factor: Option<f64>,
    specular_texture: Option<TextureInfo>,
    specular_color_factor: Option<[f64; 3]>,
    specular_color_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Transmission {
    transmission_factor: Option<f64>,
    transmission_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Volume {
    thickness_factor: Option<f64>,
    thickness_texture: Option<TextureInfo>,
    attenuation_distance: Option<f64>,
    attenuation_color: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureTransform {
    offset: Option<[f64; 2]>,
    rotation: Option<f64>,
    scale: Option<[f64; 2]>,
    tex_coord: Option<u64>,
}

/// Converts the materials that meshes use; each one once.
#[derive(Debug)]
pub struct MaterialTable<'a> {
    document: &'a Document,
    /// glTF index of each entry of `materials`; `None` is glTF's default material.
    sources: Vec<Option<u64>>,
    pub materials: Vec<Material>,
    pub textures: TextureTable<'a>,
}

impl<'a> MaterialTable<'a> {
    pub fn new(document: &'a Document) -> Self {
        Self { document, sources: Vec::new(), materials: Vec::new(), textures: TextureTable::new(document) }
    }

    /// The scene's index of glTF material `index`, or of the default material. A faulty one is magenta.
    ///
    /// # Errors
    /// Extensions without which it cannot be shown; where strict, dangling references, values outside of what the
    /// model can take, malformed extension objects, and faulty textures.
    pub fn register(
        &mut self,
        index: Option<u64>,
        from: &str,
        faults: &mut Faults,
    ) -> Result<u32, SceneError> {
        if let Some(known) = self.sources.iter().position(|source| *source == index) {
            return Ok(known as u32);
        }
        let material = match index {
            None => Material { name: "default".into(), ..Material::default() },
            Some(index) => {
                let place = match self
                    .document
                    .materials
                    .get(index as usize)
                    .map(|source| source.ok()?.name.as_ref())
                {
                    Some(Some(name)) => format!("materials[{index}] \"{name}\""),
                    Some(None) => format!("materials[{index}]"),
                    None => from.into(),
                };
                let converted = part(&self.document.materials, index, "materials", from).and_then(|source| {
                    let textures = &mut self.textures;
                    Converter { source, place: place.clone(), textures, faults }.convert(index)
                });
                faults
                    .or_without(&place, converted, "what has this material is magenta")?
                    .unwrap_or_else(|| Material::lambert("faulty", Vec3::new(1.0, 0.0, 1.0)))
            }
        };
        self.sources.push(index);
        self.materials.push(material);
        Ok((self.materials.len() - 1) as u32)
    }

    /// Decodes the images and fills in the scene's materials, textures and images. Where a picture cannot be read,
    /// colours are magenta and other slots are emptied.
    ///
    /// # Errors
    /// Those of [`TextureTable::decode_images`].
    pub fn finish(
        mut self,
        buffers: &Buffers<'_>,
        base_dir: Option<&Path>,
        options: &LoadOptions,
        faults: &mut Faults,
        scene: &mut Scene,
    ) -> Result<(), SceneError> {
        let images = self.textures.decode_images(buffers, base_dir, options, faults)?;
        let textures = self.textures.textures;
        for material in &mut self.materials {
            let slots = [
                &mut material.metallic_roughness_texture,
                &mut material.normal_texture,
                &mut material.specular_texture,
                &mut material.transmission_texture,
            ];
            for slot in slots {
                *slot = slot.filter(|slot| images[textures[slot.texture as usize].image as usize].is_some());
            }
        }
        scene.images = images.into_iter().map(|image| image.unwrap_or_else(|| magenta("missing"))).collect();
        scene.textures = textures;
        scene.materials = self.materials;
        Ok(())
    }
}

/// What a texture is for: a colour, or numbers of which none could stand for a missing texture.
#[derive(Clone, Copy)]
enum Slot {
    Color,
    Data,
}

struct Converter<'t, 'a> {
    source: &'a document::Material,
    place: String,
    textures: &'t mut TextureTable<'a>,
    faults: &'t mut Faults,
}

impl Converter<'_, '_> {
    fn convert(mut self, index: u64) -> Result<Material, SceneError> {
        let source = self.source;
        if source.extensions.contains_key(SPECULAR_GLOSSINESS) && source.pbr_metallic_roughness.is_none() {
            return Err(unsupported(&[SPECULAR_GLOSSINESS]));
        }
        let pbr = source.pbr_metallic_roughness.clone().unwrap_or_default();
        let [red, green, blue, alpha] = pbr.base_color_factor.unwrap_or([1.0; 4]);
        let alpha_mode = match source.alpha_mode.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask {
                cutoff: self.at_least(0.0, source.alpha_cutoff.unwrap_or(0.5), "alphaCutoff")?,
            },
            Some("BLEND") => AlphaMode::Blend,
            Some(other) => return Err(self.fault(format!("alphaMode \"{other}\" is unknown"))),
        };
        let strength: Option<EmissiveStrength> = self.extension("KHR_materials_emissive_strength")?;
        let strength = strength.and_then(|e| e.emissive_strength).unwrap_or(1.0);
        let emission = source.emissive_factor.unwrap_or([0.0; 3]).map(|factor| factor * strength);
        let normal_scale = source.normal_texture.as_ref().and_then(|info| info.scale).unwrap_or(1.0);

        let mut material = Material {
            name: source.name.clone().unwrap_or_else(|| format!("material {index}")),
            base_color: self.color([red, green, blue], "baseColorFactor")?,
            alpha: self.unit(alpha, "baseColorFactor alpha")?,
            base_color_texture: self.texture(pbr.base_color_texture.as_ref(), Slot::Color)?,
            metallic: self.unit(pbr.metallic_factor.unwrap_or(1.0), "metallicFactor")?,
            roughness: self.unit(pbr.roughness_factor.unwrap_or(1.0), "roughnessFactor")?,
            metallic_roughness_texture: self.texture(pbr.metallic_roughness_texture.as_ref(), Slot::Data)?,
            normal_texture: self.texture(source.normal_texture.as_ref(), Slot::Data)?,
            normal_scale: self.finite(normal_scale, "normalTexture.scale")?,
            emission: self.positive(emission, "emissiveFactor")?,
            emission_texture: self.texture(source.emissive_texture.as_ref(), Slot::Color)?,
            alpha_mode,
            double_sided: source.double_sided,
            unlit: source.extensions.contains_key("KHR_materials_unlit"),
            ..Material::default()
        };
        self.dielectric(&mut material)?;
        self.interior(&mut material)?;
        Ok(material)
    }

    /// `KHR_materials_ior` and `KHR_materials_specular`.
    fn dielectric(&mut self, material: &mut Material) -> Result<(), SceneError> {
        if let Some(Ior { ior: Some(ior) }) = self.extension("KHR_materials_ior")? {
            let ior = if ior == 0.0 { IOR_OF_INFINITY } else { ior };
            material.ior = self.at_least(1.0, ior, "ior")?;
        }
        if let Some(specular) = self.extension::<Specular>("KHR_materials_specular")? {
            material.specular = self.unit(specular.specular_factor.unwrap_or(1.0), "specularFactor")?;
            material.specular_texture = self.texture(specular.specular_texture.as_ref(), Slot::Data)?;
            let color = specular.specular_color_factor.unwrap_or([1.0; 3]);
            material.specular_color = self.positive(color, "specularColorFactor")?;
            material.specular_color_texture =
                self.texture(specular.specular_color_texture.as_ref(), Slot::Color)?;
        }
        Ok(())
    }

    /// `KHR_materials_transmission` and `KHR_materials_volume`.
    fn interior(&mut self, material: &mut Material) -> Result<(), SceneError> {
        if let Some(transmission) = self.extension::<Transmission>("KHR_materials_transmission")? {
            let factor = transmission.transmission_factor.unwrap_or(0.0);
            material.transmission = self.unit(factor, "transmissionFactor")?;
            material.transmission_texture =
                self.texture(transmission.transmission_texture.as_ref(), Slot::Data)?;
        }
        if let Some(volume) = self.extension::<Volume>("KHR_materials_volume")? {
            // The thickness itself is a hint for rasterisers; rays measure the distance inside.
            let thickness = self.at_least(0.0, volume.thickness_factor.unwrap_or(0.0), "thicknessFactor")?;
            material.volume = thickness > 0.0 || volume.thickness_texture.is_some();
            if let Some(distance) = volume.attenuation_distance {
                if distance <= 0.0 {
                    return Err(self.fault(format!("attenuationDistance {distance} is not positive")));
                }
                material.attenuation_distance = self.finite(distance, "attenuationDistance")?;
            }
            material.attenuation_color =
                self.color(volume.attenuation_color.unwrap_or([1.0; 3]), "attenuationColor")?;
        }
        Ok(())
    }

    fn texture(&mut self, info: Option<&TextureInfo>, slot: Slot) -> Result<Option<TextureRef>, SceneError> {
        let Some(info) = info else { return Ok(None) };
        let transform: Option<TextureTransform> =
            extension(&info.extensions, "KHR_texture_transform", &self.place)?;
        let uv_set = transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        if uv_set > 1 {
            let problem = format!("a texture uses TEXCOORD_{uv_set}, but only sets 0 and 1 are read");
            self.faults.note(&self.place, problem, "it is left out");
            return Ok(None);
        }
        let transform = match transform {
            None => Affine2::IDENTITY,
            Some(transform) => self.transform(&transform)?,
        };
        let texture = match (self.textures.register(info.index, &self.place, self.faults), slot) {
            (Ok(texture), _) => texture,
            (Err(error), Slot::Color) => {
                self.faults.tolerate(&self.place, error, "magenta is shown in its place")?;
                self.textures.stand_in()
            }
            (Err(error), Slot::Data) => {
                self.faults.tolerate(&self.place, error, "its factor alone counts")?;
                return Ok(None);
            }
        };
        Ok(Some(TextureRef { texture, uv_set: uv_set as u32, transform }))
    }

    /// translation * rotation * scale. The rotation is counter-clockwise as seen in the picture, whose
    /// v runs down: its first column is (cos, -sin), as the quadrant example of the extension's text requires.
    fn transform(&self, transform: &TextureTransform) -> Result<Affine2, SceneError> {
        let vector = |v: Option<[f64; 2]>, default: f64, name: &str| -> Result<Vec2, SceneError> {
            let [x, y] = v.unwrap_or([default; 2]);
            Ok(Vec2::new(self.finite(x, name)?, self.finite(y, name)?))
        };
        let rotation = self.finite(transform.rotation.unwrap_or(0.0), "texture rotation")?;
        let scale = vector(transform.scale, 1.0, "texture scale")?;
        let offset = vector(transform.offset, 0.0, "texture offset")?;
        Ok(Affine2::from_mat2_translation(Mat2::from_angle(-rotation) * Mat2::from_diagonal(scale), offset))
    }

    fn extension<T: serde::de::DeserializeOwned>(&self, name: &str) -> Result<Option<T>, SceneError> {
        extension(&self.source.extensions, name, &self.place)
    }

    fn fault(&self, detail: String) -> SceneError {
        SceneError::invalid(&self.place, "VALUE_NOT_IN_RANGE", detail)
    }

    fn finite(&self, value: f64, name: &str) -> Result<f32, SceneError> {
        let narrow = value as f32;
        if narrow.is_finite() { Ok(narrow) } else { Err(self.fault(format!("{name} {value} is too large"))) }
    }

    fn at_least(&self, least: f64, value: f64, name: &str) -> Result<f32, SceneError> {
        if value < least {
            return Err(self.fault(format!("{name} {value} is less than {least}")));
        }
        self.finite(value, name)
    }

    /// A factor in 0..=1. Exporters round just past the ends, so what lies outside is cut with a warning.
    fn unit(&mut self, value: f64, name: &str) -> Result<f32, SceneError> {
        if !(0.0..=1.0).contains(&value) {
            self.faults.note(&self.place, format!("{name} is {value}"), "it is cut to 0..=1");
        }
        self.finite(value.clamp(0.0, 1.0), name)
    }

    fn color(&mut self, [r, g, b]: [f64; 3], name: &str) -> Result<Vec3, SceneError> {
        Ok(Vec3::new(self.unit(r, name)?, self.unit(g, name)?, self.unit(b, name)?))
    }

    fn positive(&self, [r, g, b]: [f64; 3], name: &str) -> Result<Vec3, SceneError> {
        Ok(Vec3::new(
            self.at_least(0.0, r, name)?,
            self.at_least(0.0, g, name)?,
            self.at_least(0.0, b, name)?,
        ))
    }
}
