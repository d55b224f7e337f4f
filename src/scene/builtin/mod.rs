//! Built-in scenes, as code: the ones with a known answer that tests are made of, and small classics to look at.
//!
//! `halfway render NAME` takes these names where it takes a file. All surfaces are Lambert unless said otherwise.

pub mod closed;
pub mod rooms;
pub mod shapes;

use glam::Vec3;

use crate::scene::{Camera, Material, Mesh, Scene};

/// Makes a scene with its default parameters.
type Maker = fn() -> Scene;

/// The built-in scenes: name, maker.
const SCENES: &[(&str, Maker)] =
    &[("furnace-box", || closed::furnace_box(0.5, 1.0)), ("cornell", rooms::cornell)];

/// The names that [`builtin`] knows, in the order in which they are shown to users.
pub fn names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|&(name, _)| name)
}

/// The built-in scene of that name, `None` for a name that is not in [`names`].
pub fn builtin(name: &str) -> Option<Scene> {
    SCENES.iter().find(|&&(known, _)| known == name).map(|&(_, make)| make())
}

/// A scene under construction: keeps meshes and materials together.
struct Stage {
    scene: Scene,
}

impl Stage {
    fn new(name: &str, resolution: [u32; 2]) -> Self {
        Self { scene: Scene { name: name.into(), resolution: Some(resolution), ..Scene::default() } }
    }

    /// Adds a material and returns its index.
    fn material(&mut self, material: Material) -> u32 {
        self.scene.materials.push(material);
        self.scene.materials.len() as u32 - 1
    }

    /// Adds a Lambert material that emits nothing.
    fn lambert(&mut self, name: &str, base_color: [f32; 3]) -> u32 {
        self.material(Material::lambert(name, base_color.into()))
    }

    /// Adds a black material that emits `radiance` from its front.
    fn lamp(&mut self, name: &str, radiance: [f32; 3]) -> u32 {
        self.material(Material { emission: radiance.into(), ..Material::lambert(name, Vec3::ZERO) })
    }

    fn add(&mut self, name: &str, material: u32, mesh: Mesh) {
        self.scene.meshes.push(Mesh { name: name.into(), material, ..mesh });
    }

    fn camera(&mut self, camera: Camera) {
        self.scene.cameras.push(camera);
    }
}
