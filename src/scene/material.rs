//! Surface materials: the glTF metallic-roughness model with the extensions Halfway understands.

use glam::{Affine2, Vec3};

use crate::math::ggx_albedo::MIN_ALPHA;

/// Factors and textures of a material; each factor multiplies its texture and the vertex colour where glTF asks for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    pub base_color: Vec3,
    pub alpha: f32,
    /// RGB base colour (sRGB), A alpha.
    pub base_color_texture: Option<TextureRef>,
    pub metallic: f32,
    /// Perceptual roughness; GGX alpha is its square.
    pub roughness: f32,
    /// G roughness, B metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    pub normal_texture: Option<TextureRef>,
    pub normal_scale: f32,
    /// Emitted radiance per channel, `KHR_materials_emissive_strength` included. Front side only unless double-sided.
    pub emission: Vec3,
    pub emission_texture: Option<TextureRef>,
    pub alpha_mode: AlphaMode,
    pub double_sided: bool,
    /// The camera looks through the back ([`Scene::cull_backs`](super::Scene::cull_backs)). Everything else meets it.
    pub culled: bool,
    /// Index of refraction (`KHR_materials_ior`, 1.5 by default), at least 1.
    pub ior: f32,
    /// `KHR_materials_specular`: strength (texture: A) and colour (texture: RGB, sRGB) of the dielectric reflection.
    pub specular: f32,
    pub specular_texture: Option<TextureRef>,
    pub specular_color: Vec3,
    pub specular_color_texture: Option<TextureRef>,
    /// `KHR_materials_transmission`: share of the non-reflected light that passes (texture: R).
    pub transmission: f32,
    pub transmission_texture: Option<TextureRef>,
    /// `KHR_materials_volume`: thin-walled (no refraction) where false, the boundary of a volume where true.
    pub volume: bool,
    /// Distance in scene units at which white light has become `attenuation_color`; infinite without attenuation.
    pub attenuation_distance: f32,
    pub attenuation_color: Vec3,
    /// `KHR_materials_unlit`: the surface radiates its base colour and reflects nothing.
    pub unlit: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    #[default]
    Opaque,
    /// Opaque where alpha is at least the cutoff, absent elsewhere.
    Mask { cutoff: f32 },
    /// Present with probability alpha.
    Blend,
}

/// A texture in a material slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into `Scene::textures`.
    pub texture: u32,
    /// Which of `Mesh::uvs`, 0 or 1.
    pub uv_set: u32,
    /// `KHR_texture_transform`, identity without it: uv' = transform * uv.
    pub transform: Affine2,
}

impl Default for Material {
    /// glTF's defaults: white, metallic 1, roughness 1.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec3::ONE,
            alpha: 1.0,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Vec3::ZERO,
            emission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            culled: false,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: Vec3::ONE,
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            volume: false,
            attenuation_distance: f32::INFINITY,
            attenuation_color: Vec3::ONE,
            unlit: false,
        }
    }
}

impl Material {
    /// A matte surface: no metal, no dielectric reflection.
    pub fn lambert(name: &str, base_color: Vec3) -> Self {
        Self { name: name.into(), base_color, metallic: 0.0, specular: 0.0, ..Self::default() }
    }

    /// The textures in use, each slot in turn.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.emission_texture,
            &self.specular_texture,
            &self.specular_color_texture,
            &self.transmission_texture,
        ]
        .into_iter()
        .flatten()
    }

    /// The slots of those that [`Self::textures`] lists.
    pub fn slots_mut(&mut self) -> [&mut Option<TextureRef>; 7] {
        [
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.normal_texture,
            &mut self.emission_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.transmission_texture,
        ]
    }

    /// True where the surface only scatters by Lambert's law, whatever its textures hold.
    pub fn is_lambert(&self) -> bool {
        self.metallic == 0.0 && self.specular == 0.0 && self.transmission == 0.0
    }

    /// True where there is nothing beyond Lambert's law to evaluate: an unlit surface does not even scatter.
    pub fn is_plain(&self) -> bool {
        self.unlit || self.is_lambert()
    }

    /// True where every lobe is narrower than rounding lets a density be computed for: a mirror, smooth glass, or
    /// a refracting surface whose index hardly differs from its surroundings'. Only a pure metal or a pure
    /// transmitter can be; in a mixture or under a texture the roughness is raised to the narrowest finite lobe
    /// instead (`shaders/lib/surface.wgsl` has the same limits).
    pub fn is_delta(&self) -> bool {
        let metal = self.metallic == 1.0;
        let transmitter =
            self.metallic == 0.0 && self.transmission == 1.0 && self.transmission_texture.is_none();
        let alpha = self.roughness * self.roughness;
        let narrow = f64::from(alpha) < MIN_ALPHA
            || (transmitter && self.volume && alpha * (self.ior - 1.0) < MIN_REFRACTED_SPREAD);
        self.metallic_roughness_texture.is_none() && (metal || transmitter) && narrow
    }
}

/// Narrowest finite refracted lobe, as alpha * |ior - 1|: about its half angle in radians.
pub const MIN_REFRACTED_SPREAD: f32 = 2e-4;
