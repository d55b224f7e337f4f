//! What a scene requires of the kernels: a pure function of the scene. What is false here is not in the text of a kernel,
//! has no buffer and costs nothing. `device::features` says what each switch costs.

use std::collections::BTreeSet;

use serde::Serialize;

use super::{AlphaMode, Material, Mesh, Scene, TextureRef};

/// One switch for each part of the kernels that a scene may do without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SceneFeatures {
    /// Every surface scatters by Lambert's law alone: no microfacets, no table of their albedo.
    pub lambert_only: bool,
    /// Some surface transmits light.
    pub transmission: bool,
    /// Some surface transmits through a finite lobe.
    pub rough_transmission: bool,
    /// Some volume absorbs.
    pub absorption: bool,
    /// Masked or blended surfaces.
    pub alpha: bool,
    pub textures: bool,
    /// Textures beside that of the base colour, each where it changes anything.
    pub metallic_roughness_texture: bool,
    pub specular_texture: bool,
    pub transmission_texture: bool,
    pub emission_texture: bool,
    /// The camera looks through the backs of some surfaces.
    pub culling: bool,
    /// Interpolated shading normals.
    pub normals: bool,
    pub normal_map: bool,
    pub vertex_colors: bool,
    pub uv0: bool,
    pub uv1: bool,
    /// Surfaces that emit, of some area.
    pub area_lights: bool,
    /// Unlit surfaces, which emit their base colour.
    pub unlit: bool,
    /// Point, spot and directional lights.
    pub punctual_lights: bool,
    pub environment: bool,
}

impl SceneFeatures {
    /// Reads the features off the materials that meshes use, the lights and the environment.
    pub fn of(scene: &Scene) -> Self {
        let used: BTreeSet<u32> =
            scene.meshes.iter().filter(|mesh| !mesh.triangles.is_empty()).map(|mesh| mesh.material).collect();
        let materials: Vec<&Material> = used.iter().map(|&index| &scene.materials[index as usize]).collect();
        let any = |test: fn(&Material) -> bool| materials.iter().any(|material| test(material));
        let slots: Vec<&TextureRef> = materials.iter().flat_map(|material| material.textures()).collect();
        let transmission = any(|m| m.transmission > 0.0 && !m.unlit);
        let normal_map = any(|m| m.normal_texture.is_some());
        Self {
            lambert_only: materials.iter().all(|m| m.is_plain()),
            transmission,
            rough_transmission: transmission && any(|m| m.transmission > 0.0 && !m.unlit && !m.is_delta()),
            absorption: any(|m| m.volume && m.transmission > 0.0 && m.attenuation_distance.is_finite()),
            alpha: any(|m| m.alpha_mode != AlphaMode::Opaque),
            culling: any(|m| m.culled),
            textures: !slots.is_empty(),
            metallic_roughness_texture: any(|m| !m.is_plain() && m.metallic_roughness_texture.is_some()),
            specular_texture: any(|m| {
                !m.is_plain() && (m.specular_texture.is_some() || m.specular_color_texture.is_some())
            }),
            transmission_texture: transmission && any(|m| !m.is_plain() && m.transmission_texture.is_some()),
            emission_texture: any(|m| {
                !m.unlit && m.emission.max_element() > 0.0 && m.emission_texture.is_some()
            }),
            normals: scene.meshes.iter().any(|mesh| mesh.normals.is_some()),
            normal_map,
            vertex_colors: scene.meshes.iter().any(|mesh| mesh.colors.is_some()),
            uv0: slots.iter().any(|slot| slot.uv_set == 0),
            uv1: slots.iter().any(|slot| slot.uv_set == 1),
            area_lights: scene.meshes.iter().any(|mesh| emits(scene, mesh)),
            unlit: any(|m| m.unlit),
            punctual_lights: !scene.lights.is_empty(),
            environment: scene.environment.is_some(),
        }
    }

    /// With what goes together: the nearest set of features that a scene may have.
    pub fn consistent(mut self) -> Self {
        self.transmission |= self.rough_transmission;
        self.lambert_only &= !self.transmission;
        self.metallic_roughness_texture &= !self.lambert_only;
        self.specular_texture &= !self.lambert_only;
        self.transmission_texture &= self.transmission;
        self.textures |= self.normal_map
            | self.metallic_roughness_texture
            | self.specular_texture
            | self.transmission_texture
            | self.emission_texture
            | self.uv0
            | self.uv1;
        self.uv0 |= self.textures && !self.uv1;
        self
    }

    /// Something in the scene can be sampled as a light.
    pub fn lights(&self) -> bool {
        self.area_lights || self.punctual_lights || self.environment
    }
}

/// The mesh sends out light. What has no area sends out none.
fn emits(scene: &Scene, mesh: &Mesh) -> bool {
    let material = &scene.materials[mesh.material as usize];
    let radiance = if material.unlit { material.base_color } else { material.emission };
    let has_area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
        (b - a).cross(c - a).length() > 0.0
    };
    radiance.max_element() > 0.0 && mesh.triangles.iter().any(has_area)
}
