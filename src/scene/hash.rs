//! A scene's content as one number: what a saved model, a reference or a measurement was made of.
//!
//! Every field is put in behind its own name, and only where it differs from what it is by default. So a field that is
//! added later leaves alone the hash of scenes that do not use it, and what was learnt of them stays valid.

use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};

use super::{
    AlphaMode, Camera, Environment, Filter, Image, Instance, LightKind, Material, Mesh, Projection,
    PunctualLight, Scene, Texture, TextureRef, Wrap,
};
use crate::math::fnv::Fnv;

/// Raise it with a field's name, default or meaning: all hashes change then.
const HASH_VERSION: u64 = 1;

impl Scene {
    /// A hash of everything that pictures depend on but a placed camera, equal on all machines (FNV-1a, eight bytes at a
    /// time). Names do not count, nor does the size that a file asks for: the command line has the last word on that.
    pub fn content_hash(&self) -> u64 {
        let Self {
            name: _,
            meshes,
            materials,
            images,
            textures,
            lights,
            cameras: _,
            camera_placed: _,
            environment,
            variants: _,
            resolution: _,
            middle: _,
            repeated: _,
            warnings: _,
        } = self;
        let mut hash = Fnv::default();
        hash.bytes(&HASH_VERSION.to_le_bytes());
        list(&mut hash, "meshes", meshes);
        list(&mut hash, "materials", materials);
        list(&mut hash, "images", images);
        list(&mut hash, "textures", textures);
        list(&mut hash, "lights", lights);
        list(&mut hash, "cameras", self.own_cameras());
        list(&mut hash, "environment", environment.as_slice());
        hash.0
    }
}

/// Nothing where there are none.
fn list<T: Hashed>(hash: &mut Fnv, name: &str, all: &[T]) {
    if !all.is_empty() {
        hash.bytes(name.as_bytes());
        hash.bytes(&(all.len() as u64).to_le_bytes());
        all.iter().for_each(|one| one.put(hash));
    }
}

/// What a hash is made of.
trait Hashed {
    /// Puts it in, with what tells where it ends.
    fn put(&self, hash: &mut Fnv);
}

/// A field under its name, where it is not what it is by default.
fn field<T: Hashed + PartialEq>(hash: &mut Fnv, name: &str, value: &T, default: &T) {
    if value != default {
        hash.bytes(name.as_bytes());
        value.put(hash);
    }
}

/// Structs, field by field. What stands after the semicolon does not count; a field that stands nowhere does not compile.
macro_rules! fields {
    ($($type:ident { $($field:ident),*; $($ignored:ident),* } by default $default:expr;)*) => {$(
        impl Hashed for $type {
            fn put(&self, hash: &mut Fnv) {
                let default: Self = $default;
                let Self { $($field,)* $($ignored: _,)* } = self;
                $(field(hash, stringify!($field), $field, &default.$field);)*
                hash.bytes(b";");
            }
        }
    )*};
}

fields! {
    Mesh { material, positions, normals, tangents, uvs, colors, triangles, instances; name } by default Mesh::default();
    Material {
        base_color, alpha, base_color_texture, metallic, roughness, metallic_roughness_texture, normal_texture,
        normal_scale, emission, emission_texture, alpha_mode, double_sided, culled, ior, specular, specular_texture,
        specular_color, specular_color_texture, transmission, transmission_texture, volume, attenuation_distance,
        attenuation_color, unlit;
        name
    } by default Material::default();
    TextureRef { texture, uv_set, transform; }
        by default TextureRef { texture: 0, uv_set: 0, transform: Affine2::IDENTITY };
    Image { width, height, texels; name } by default Image::default();
    Texture { image, wrap, filter; }
        by default Texture { image: 0, wrap: [Wrap::default(); 2], filter: Filter::default() };
    PunctualLight { kind, intensity, position, direction; name } by default PunctualLight {
        name: String::new(),
        kind: LightKind::Point,
        intensity: Vec3::ZERO,
        position: DVec3::ZERO,
        direction: Vec3::ZERO,
    };
    Camera { position, right, up, forward, projection; name } by default Camera {
        name: String::new(),
        position: DVec3::ZERO,
        right: Vec3::ZERO,
        up: Vec3::ZERO,
        forward: Vec3::ZERO,
        projection: Projection::Perspective { yfov: 0.0 },
    };
    Environment { width, height, texels, scale, rotation; name } by default Environment::default();
}

/// Plain data as its bytes; long lists eight bytes at a time.
macro_rules! plain {
    ($($type:ty),*) => {$(
        impl Hashed for $type {
            fn put(&self, hash: &mut Fnv) {
                hash.bytes(bytemuck::bytes_of(self));
            }
        }

        impl Hashed for Vec<$type> {
            fn put(&self, hash: &mut Fnv) {
                hash.bytes(bytemuck::cast_slice(self));
            }
        }
    )*};
}

plain!(f32, u32, Vec2, Vec3, Vec4, DVec3, [u32; 3], [u8; 4], [f32; 3]);

impl Hashed for Vec<Instance> {
    fn put(&self, hash: &mut Fnv) {
        self.iter().for_each(|Instance { transform, name: _ }| {
            hash.bytes(bytemuck::cast_slice(&transform.to_cols_array()));
        });
    }
}

impl Hashed for bool {
    fn put(&self, hash: &mut Fnv) {
        hash.bytes(&[u8::from(*self)]);
    }
}

impl Hashed for Affine2 {
    fn put(&self, hash: &mut Fnv) {
        hash.bytes(bytemuck::bytes_of(&self.to_cols_array()));
    }
}

impl<T: Hashed> Hashed for Option<T> {
    fn put(&self, hash: &mut Fnv) {
        self.is_some().put(hash);
        self.iter().for_each(|value| value.put(hash));
    }
}

impl<T: Hashed> Hashed for [T; 2] {
    fn put(&self, hash: &mut Fnv) {
        self.iter().for_each(|value| value.put(hash));
    }
}

impl Hashed for Wrap {
    fn put(&self, hash: &mut Fnv) {
        (*self as u32).put(hash);
    }
}

impl Hashed for Filter {
    fn put(&self, hash: &mut Fnv) {
        (*self as u32).put(hash);
    }
}

impl Hashed for AlphaMode {
    fn put(&self, hash: &mut Fnv) {
        match self {
            Self::Opaque => hash.bytes(b"opaque"),
            Self::Mask { cutoff } => {
                hash.bytes(b"mask");
                cutoff.put(hash);
            }
            Self::Blend => hash.bytes(b"blend"),
        }
    }
}

impl Hashed for LightKind {
    fn put(&self, hash: &mut Fnv) {
        match self {
            Self::Point => hash.bytes(b"point"),
            Self::Spot { inner, outer } => {
                hash.bytes(b"spot");
                inner.put(hash);
                outer.put(hash);
            }
            Self::Directional => hash.bytes(b"directional"),
        }
    }
}

impl Hashed for Projection {
    fn put(&self, hash: &mut Fnv) {
        match self {
            Self::Perspective { yfov } => {
                hash.bytes(b"perspective");
                yfov.put(hash);
            }
            Self::Orthographic { xmag, ymag } => {
                hash.bytes(b"orthographic");
                xmag.put(hash);
                ymag.put(hash);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As a material with one field more would be hashed.
    fn with_clearcoat(material: &Material, clearcoat: f32) -> u64 {
        let mut hash = Fnv::default();
        field(&mut hash, "clearcoat", &clearcoat, &0.0);
        material.put(&mut hash);
        hash.0
    }

    #[test]
    fn a_new_field_leaves_those_alone_that_do_not_use_it() {
        let material = Material::lambert("white", Vec3::ONE);
        let mut before = Fnv::default();
        material.put(&mut before);
        assert_eq!(with_clearcoat(&material, 0.0), before.0);
        assert_ne!(with_clearcoat(&material, 0.5), before.0);
    }
}
