//! glTF materials to ours.

use std::path::Path;

use glam::{Affine2, Mat2, Vec2, Vec3};
use gltf::json::extensions::material as typed;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode as AlphaModeName, NormalTexture};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use gltf::json::{self, Index};
use serde::Deserialize;

use super::LoadOptions;
use super::buffers::Buffers;
use super::document::Document;
use super::faults::Faults;
use super::image::{TextureTable, magenta};
use super::uv_sets;
use crate::scene::material::{AlphaMode, Material, TextureRef};
use crate::scene::{Scene, SceneError};

/// Extensions of materials that are read here.
pub(super) const EXTENSIONS: &[&str] = &[
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
];

/// `KHR_materials_ior` writes 0 for an infinite index (a dielectric that reflects everything); this stands for it,
/// with a reflectance of 0.996 at normal incidence.
const IOR_OF_INFINITY: f32 = 1000.0;

/// Converts the materials that meshes use; each one once.
#[derive(Debug)]
pub struct MaterialTable<'a> {
    document: &'a Document,
    /// glTF index of each entry of `materials`; `None` is glTF's default material.
    sources: Vec<Option<usize>>,
    pub materials: Vec<Material>,
    /// The sets of texture coordinates that each material's textures call 0 and 1.
    pub uv_sets: Vec<[u32; 2]>,
    pub textures: TextureTable<'a>,
}

impl<'a> MaterialTable<'a> {
    pub fn new(document: &'a Document) -> Self {
        let textures = TextureTable::new(document);
        Self { document, sources: Vec::new(), materials: Vec::new(), uv_sets: Vec::new(), textures }
    }

    /// The scene's index of glTF material `index`, or of the default material. A faulty one is magenta.
    ///
    /// # Errors
    /// Extensions without which it cannot be shown; where strict, dangling references, values outside of what the
    /// model can take, malformed extension objects, and faulty textures.
    pub fn register(
        &mut self,
        index: Option<Index<json::Material>>,
        from: &str,
        faults: &mut Faults,
    ) -> Result<u32, SceneError> {
        let key = index.map(|index| index.value());
        if let Some(known) = self.sources.iter().position(|source| *source == key) {
            return Ok(known as u32);
        }
        let mut place = String::from(from);
        let mut material = match index {
            None => Material { name: "default".into(), ..Material::default() },
            Some(index) => {
                let number = index.value();
                place = match self.document.materials.get(number).map(|source| source.name.as_ref()) {
                    Some(Some(name)) => format!("materials[{number}] \"{name}\""),
                    Some(None) => format!("materials[{number}]"),
                    None => place,
                };
                let converted = self.document.get(index, from).and_then(|source| {
                    let textures = &mut self.textures;
                    Converter { source, place: place.clone(), textures, faults }.convert(number)
                });
                faults
                    .or_without(&place, converted, "what has this material is magenta")?
                    .unwrap_or_else(|| Material::lambert("faulty", Vec3::new(1.0, 0.0, 1.0)))
            }
        };
        self.uv_sets.push(uv_sets::choose(&mut material, &place, faults));
        self.sources.push(key);
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
enum Use {
    Color,
    Data,
    /// Roughness is 1 less alpha times the factor.
    Gloss(f32),
}

struct Converter<'t, 'a> {
    source: &'a json::Material,
    place: String,
    textures: &'t mut TextureTable<'a>,
    faults: &'t mut Faults,
}

impl Converter<'_, '_> {
    fn convert(mut self, index: usize) -> Result<Material, SceneError> {
        let source = self.source;
        let no_extensions = typed::Material::default();
        let extensions = source.extensions.as_ref().unwrap_or(&no_extensions);
        let pbr = &source.pbr_metallic_roughness;
        let [red, green, blue, alpha] = pbr.base_color_factor.0;
        let alpha_mode = match source.alpha_mode {
            Checked::Valid(AlphaModeName::Opaque) => AlphaMode::Opaque,
            Checked::Valid(AlphaModeName::Mask) => AlphaMode::Mask {
                cutoff: self.at_least(0.0, source.alpha_cutoff.unwrap_or_default().0, "alphaCutoff")?,
            },
            Checked::Valid(AlphaModeName::Blend) => AlphaMode::Blend,
            Checked::Invalid => {
                return Err(self.fault("its alphaMode is none of OPAQUE, MASK and BLEND".into()));
            }
        };
        let strength = extensions.emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength.0);
        let emission = source.emissive_factor.0.map(|factor| factor * strength);
        let normal_scale = source.normal_texture.as_ref().map_or(1.0, |info| info.scale);
        let normal_texture = source.normal_texture.as_ref().map(Slot::of_normals).transpose();

        let mut material = Material {
            name: source.name.clone().unwrap_or_else(|| format!("material {index}")),
            base_color: self.color([red, green, blue], "baseColorFactor")?,
            alpha: self.unit(alpha, "baseColorFactor alpha")?,
            base_color_texture: self.texture(pbr.base_color_texture.as_ref(), Use::Color)?,
            metallic: self.unit(pbr.metallic_factor.0, "metallicFactor")?,
            roughness: self.unit(pbr.roughness_factor.0, "roughnessFactor")?,
            metallic_roughness_texture: self.texture(pbr.metallic_roughness_texture.as_ref(), Use::Data)?,
            normal_texture: self.slot(normal_texture.map_err(|error| self.malformed(&error))?, Use::Data)?,
            normal_scale: self.finite(normal_scale, "normalTexture.scale")?,
            emission: self.positive(emission, "emissiveFactor")?,
            emission_texture: self.texture(source.emissive_texture.as_ref(), Use::Color)?,
            alpha_mode,
            double_sided: source.double_sided,
            unlit: extensions.unlit.is_some(),
            ..Material::default()
        };
        self.dielectric(extensions, &mut material)?;
        self.interior(extensions, &mut material)?;
        match &extensions.pbr_specular_glossiness {
            Some(glossy) if is_empty(pbr) => self.specular_glossiness(glossy, &mut material)?,
            Some(_) => {
                let problem = "it has specular-glossiness and metallic-roughness";
                self.faults.note(&self.place, problem, "metallic-roughness is shown");
            }
            None => {}
        }
        Ok(material)
    }

    /// `KHR_materials_ior` and `KHR_materials_specular`.
    fn dielectric(
        &mut self,
        extensions: &typed::Material,
        material: &mut Material,
    ) -> Result<(), SceneError> {
        if let Some(ior) = extensions.ior.as_ref().map(|ior| ior.ior.0) {
            let ior = if ior == 0.0 { IOR_OF_INFINITY } else { ior };
            material.ior = self.at_least(1.0, ior, "ior")?;
        }
        if let Some(specular) = &extensions.specular {
            material.specular = self.unit(specular.specular_factor.0, "specularFactor")?;
            material.specular_texture = self.texture(specular.specular_texture.as_ref(), Use::Data)?;
            material.specular_color =
                self.positive(specular.specular_color_factor.0, "specularColorFactor")?;
            material.specular_color_texture =
                self.texture(specular.specular_color_texture.as_ref(), Use::Color)?;
        }
        Ok(())
    }

    /// `KHR_materials_transmission` and `KHR_materials_volume`.
    fn interior(&mut self, extensions: &typed::Material, material: &mut Material) -> Result<(), SceneError> {
        if let Some(transmission) = &extensions.transmission {
            material.transmission = self.unit(transmission.transmission_factor.0, "transmissionFactor")?;
            material.transmission_texture =
                self.texture(transmission.transmission_texture.as_ref(), Use::Data)?;
        }
        if let Some(volume) = &extensions.volume {
            // The thickness itself is a hint for rasterisers; rays measure the distance inside.
            let thickness = self.at_least(0.0, volume.thickness_factor.0, "thicknessFactor")?;
            material.volume = thickness > 0.0 || volume.thickness_texture.is_some();
            material.attenuation_distance = volume.attenuation_distance.0;
            if material.attenuation_distance <= 0.0 {
                let detail = format!("attenuationDistance {} is not positive", material.attenuation_distance);
                return Err(self.fault(detail));
            }
            material.attenuation_color = self.color(volume.attenuation_color.0, "attenuationColor")?;
        }
        Ok(())
    }

    /// `KHR_materials_pbrSpecularGlossiness`, whose equations are those of a dielectric with the specular colour as F0,
    /// its reflectance at normal incidence: diffuse * (1 - max(F0)) below it, alpha = (1 - glossiness)^2. So metals are
    /// dielectrics without anything below, and textures stay what they are but for glossiness.
    fn specular_glossiness(
        &mut self,
        glossy: &typed::PbrSpecularGlossiness,
        material: &mut Material,
    ) -> Result<(), SceneError> {
        let [red, green, blue, alpha] = glossy.diffuse_factor.0;
        material.base_color = self.color([red, green, blue], "diffuseFactor")?;
        material.alpha = self.unit(alpha, "diffuseFactor alpha")?;
        material.base_color_texture = self.texture(glossy.diffuse_texture.as_ref(), Use::Color)?;
        material.metallic = 0.0;
        material.ior = IOR_OF_INFINITY;
        material.specular_color = self.color(glossy.specular_factor.0, "specularFactor")?;
        let glossiness = self.unit(glossy.glossiness_factor.0, "glossinessFactor")?;
        let info = glossy.specular_glossiness_texture.as_ref();
        material.specular_color_texture = self.texture(info, Use::Color)?;
        material.roughness = 1.0 - glossiness;
        if info.is_some() && glossiness > 0.0 {
            material.metallic_roughness_texture = self.texture(info, Use::Gloss(glossiness))?;
            if material.metallic_roughness_texture.is_some() {
                material.roughness = 1.0;
            }
        }
        Ok(())
    }

    fn texture(&mut self, info: Option<&Info>, purpose: Use) -> Result<Option<TextureRef>, SceneError> {
        self.slot(info.map(Slot::of), purpose)
    }

    fn slot(&mut self, slot: Option<Slot>, purpose: Use) -> Result<Option<TextureRef>, SceneError> {
        let Some(slot) = slot else { return Ok(None) };
        let uv_set = slot.transform.tex_coord.unwrap_or(slot.tex_coord);
        let transform = self.transform(&slot.transform)?;
        let gloss = match purpose {
            Use::Gloss(factor) => Some(factor),
            Use::Color | Use::Data => None,
        };
        let texture = match (self.textures.register(slot.index, gloss, &self.place, self.faults), purpose) {
            (Ok(texture), _) => texture,
            (Err(error), Use::Color) => {
                self.faults.tolerate(&self.place, error, "magenta is shown in its place")?;
                self.textures.stand_in()
            }
            (Err(error), Use::Data | Use::Gloss(_)) => {
                self.faults.tolerate(&self.place, error, "its factor alone counts")?;
                return Ok(None);
            }
        };
        Ok(Some(TextureRef { texture, uv_set, transform }))
    }

    /// translation * rotation * scale. The rotation is counter-clockwise as seen in the picture, whose
    /// v runs down: its first column is (cos, -sin), as the quadrant example of the extension's text requires.
    fn transform(&self, transform: &TextureTransform) -> Result<Affine2, SceneError> {
        let vector = |[x, y]: [f32; 2], name: &str| -> Result<Vec2, SceneError> {
            Ok(Vec2::new(self.finite(x, name)?, self.finite(y, name)?))
        };
        let rotation = self.finite(transform.rotation.0, "texture rotation")?;
        let scale = vector(transform.scale.0, "texture scale")?;
        let offset = vector(transform.offset.0, "texture offset")?;
        Ok(Affine2::from_mat2_translation(Mat2::from_angle(-rotation) * Mat2::from_diagonal(scale), offset))
    }

    fn malformed(&self, error: &serde_json::Error) -> SceneError {
        let detail = format!("cannot read extension KHR_texture_transform: {error}");
        SceneError::invalid(&self.place, "TYPE_MISMATCH", detail)
    }

    fn fault(&self, detail: String) -> SceneError {
        SceneError::invalid(&self.place, "VALUE_NOT_IN_RANGE", detail)
    }

    /// What the file has beyond single precision has come as infinity.
    fn finite(&self, value: f32, name: &str) -> Result<f32, SceneError> {
        if value.is_finite() { Ok(value) } else { Err(self.fault(format!("{name} is too large"))) }
    }

    fn at_least(&self, least: f32, value: f32, name: &str) -> Result<f32, SceneError> {
        if value < least {
            return Err(self.fault(format!("{name} {value} is less than {least}")));
        }
        self.finite(value, name)
    }

    /// A factor in 0..=1. Exporters round just past the ends, so what lies outside is cut with a warning.
    fn unit(&mut self, value: f32, name: &str) -> Result<f32, SceneError> {
        if !(0.0..=1.0).contains(&value) {
            self.faults.note(&self.place, format!("{name} is {value}"), "it is cut to 0..=1");
        }
        self.finite(value.clamp(0.0, 1.0), name)
    }

    fn color(&mut self, [r, g, b]: [f32; 3], name: &str) -> Result<Vec3, SceneError> {
        Ok(Vec3::new(self.unit(r, name)?, self.unit(g, name)?, self.unit(b, name)?))
    }

    fn positive(&self, [r, g, b]: [f32; 3], name: &str) -> Result<Vec3, SceneError> {
        Ok(Vec3::new(
            self.at_least(0.0, r, name)?,
            self.at_least(0.0, g, name)?,
            self.at_least(0.0, b, name)?,
        ))
    }
}

/// A reference to a texture.
struct Slot {
    index: Index<json::Texture>,
    tex_coord: u32,
    transform: TextureTransform,
}

impl Slot {
    fn of(info: &Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.clone());
        Self { index: info.index, tex_coord: info.tex_coord, transform: transform.unwrap_or_default() }
    }

    /// `gltf::json` has no type for the transform of a normal texture.
    fn of_normals(info: &NormalTexture) -> Result<Self, serde_json::Error> {
        let others = info.extensions.as_ref().map(|extensions| &extensions.others);
        let transform = others.and_then(|others| others.get("KHR_texture_transform"));
        let transform = transform.map(TextureTransform::deserialize).transpose()?.unwrap_or_default();
        Ok(Self { index: info.index, tex_coord: info.tex_coord, transform })
    }
}

/// True where a file that has no metallic-roughness says the same.
fn is_empty(pbr: &json::material::PbrMetallicRoughness) -> bool {
    pbr.base_color_factor.0 == [1.0; 4]
        && [pbr.metallic_factor.0, pbr.roughness_factor.0] == [1.0; 2]
        && pbr.base_color_texture.is_none()
        && pbr.metallic_roughness_texture.is_none()
}
