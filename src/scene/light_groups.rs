//! A scene's lights by name, and the scene with some of them alone.

use super::{Material, Scene};

/// Lights of one name: they go on and off together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightGroup {
    pub name: String,
    lights: Vec<Light>,
}

/// A thing that emits, by its place in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Light {
    /// All surfaces of a material.
    Material(usize),
    Punctual(usize),
    Environment,
}

impl LightGroup {
    /// All groups of a scene: surfaces by the names of their materials, other lights by their own, and the environment. What
    /// has no name is called by its number.
    pub fn of(scene: &Scene) -> Vec<Self> {
        let is_used = |index: usize| {
            let shown = |mesh: &super::Mesh| mesh.material as usize == index && !mesh.triangles.is_empty();
            scene.meshes.iter().any(shown)
        };
        let materials = scene.materials.iter().enumerate();
        let materials = materials.filter(|&(index, material)| emits(material) && is_used(index));
        let materials = materials
            .map(|(index, material)| (named(&material.name, "material", index), Light::Material(index)));
        let punctual = scene.lights.iter().enumerate();
        let punctual =
            punctual.map(|(index, light)| (named(&light.name, "light", index), Light::Punctual(index)));
        let environment = scene.environment.iter().map(|_| ("environment".to_owned(), Light::Environment));
        let mut groups: Vec<Self> = Vec::new();
        for (name, light) in materials.chain(punctual).chain(environment) {
            match groups.iter_mut().find(|group| group.name == name) {
                Some(group) => group.lights.push(light),
                None => groups.push(Self { name, lights: vec![light] }),
            }
        }
        groups
    }

    /// The scene with no other light; all else is as it was.
    pub fn alone(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        for (index, material) in scene.materials.iter_mut().enumerate() {
            if !self.lights.contains(&Light::Material(index)) {
                material.emission = glam::Vec3::ZERO;
                if material.unlit {
                    material.base_color = glam::Vec3::ZERO;
                }
            }
        }
        let mut index = 0;
        scene.lights.retain(|_| {
            index += 1;
            self.lights.contains(&Light::Punctual(index - 1))
        });
        if !self.lights.contains(&Light::Environment) {
            scene.environment = None;
        }
        scene
    }
}

fn emits(material: &Material) -> bool {
    let radiance = if material.unlit { material.base_color } else { material.emission };
    radiance.max_element() > 0.0
}

fn named(name: &str, kind: &str, index: usize) -> String {
    if name.is_empty() { format!("{kind} {index}") } else { name.to_owned() }
}
