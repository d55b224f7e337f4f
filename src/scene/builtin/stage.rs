//! What built-in scenes are put together with.

use glam::{Affine2, DVec3, Vec3};

use super::shapes;
use crate::scene::{Camera, Environment, Filter, Image, Material, Mesh, Scene, Texture, TextureRef, Wrap};

/// A scene under construction: keeps meshes and materials together.
pub struct Stage {
    pub scene: Scene,
}

impl Stage {
    pub fn new(name: &str, resolution: [u32; 2]) -> Self {
        Self { scene: Scene { name: name.into(), resolution: Some(resolution), ..Scene::default() } }
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.scene.materials.push(material);
        self.scene.materials.len() as u32 - 1
    }

    /// Adds a Lambert material that emits nothing.
    pub fn lambert(&mut self, name: &str, base_color: [f32; 3]) -> u32 {
        self.material(Material::lambert(name, base_color.into()))
    }

    /// Adds a black material that emits `radiance` from its front.
    pub fn lamp(&mut self, name: &str, radiance: [f32; 3]) -> u32 {
        self.material(Material { emission: radiance.into(), ..Material::lambert(name, Vec3::ZERO) })
    }

    pub fn add(&mut self, name: &str, material: u32, mesh: Mesh) {
        self.scene.meshes.push(Mesh { name: name.into(), material, ..mesh });
    }

    /// Adds a picture and the way it is sampled; returns a reference to it through the first texture coordinates.
    pub fn texture(&mut self, image: Image, filter: Filter) -> TextureRef {
        let texture = Texture { image: self.scene.images.len() as u32, wrap: [Wrap::Repeat; 2], filter };
        self.scene.images.push(image);
        self.scene.textures.push(texture);
        let texture = self.scene.textures.len() as u32 - 1;
        TextureRef { texture, uv_set: 0, transform: Affine2::IDENTITY }
    }

    /// Adds a floor of `size` x `size` units around the origin at y = 0, a checkerboard of 8 x 8 fields.
    pub fn checkered_floor(&mut self, size: f64) {
        let shade = |i: u32| if (i % 8 + i / 8).is_multiple_of(2) { 214 } else { 72 };
        let texels = (0..64).map(|i| [shade(i), shade(i), shade(i), 255]).collect();
        let board =
            self.texture(Image { name: "checker".into(), width: 8, height: 8, texels }, Filter::Nearest);
        let material = self.material(Material {
            base_color_texture: Some(board),
            ..Material::lambert("checker", Vec3::ONE)
        });
        let corner = DVec3::new(-size / 2.0, 0.0, -size / 2.0);
        self.add("floor", material, shapes::quad(corner, DVec3::Z * size, DVec3::X * size));
    }

    /// Surrounds the scene with radiance that fades from `top` overhead to `bottom` underneath, row by row.
    pub fn sky(&mut self, top: [f32; 3], bottom: [f32; 3]) {
        let (width, height) = (4, 8);
        let row = |y: u32| {
            let share = y as f32 / (height - 1) as f32;
            Vec3::from(top).lerp(bottom.into(), share).to_array()
        };
        let texels = (0..height).flat_map(|y| [row(y); 4]).collect();
        let name = "sky".into();
        self.scene.environment = Some(Environment { name, width, height, texels, scale: 1.0, rotation: 0.0 });
    }

    pub fn camera(&mut self, camera: Camera) {
        self.scene.cameras.push(camera);
    }
}
