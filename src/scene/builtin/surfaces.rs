//! Scenes about what surfaces do: gloss, metal, glass, and normals that are not the triangle's.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3, Vec4};

use super::shapes;
use super::stage::Stage;
use crate::scene::{Filter, Image, Material, Scene};

/// A row of seven balls on a checkerboard: matte, plastic, three metals of growing roughness, smooth and rough glass;
/// a lamp above, a dim sky around.
pub fn spheres() -> Scene {
    let mut stage = Stage::new("spheres", [224, 96]);
    stage.checkered_floor(10.0);
    let metal = |name: &str, base_color: [f32; 3], roughness: f32| Material {
        name: name.into(),
        base_color: base_color.into(),
        roughness,
        ..Material::default()
    };
    let plastic = Material { metallic: 0.0, ..metal("plastic", [0.7, 0.06, 0.05], 0.25) };
    for (i, material) in [
        Material::lambert("matte", Vec3::new(0.2, 0.35, 0.6)),
        plastic,
        metal("polished gold", [1.0, 0.77, 0.34], 0.05),
        metal("satin copper", [0.96, 0.64, 0.54], 0.3),
        metal("brushed steel", [0.56, 0.57, 0.58], 0.6),
        glass("glass", 0.0, 1.5),
        glass("frosted glass", 0.3, 1.5),
    ]
    .into_iter()
    .enumerate()
    {
        let name = material.name.clone();
        let material = stage.material(material);
        let center = DVec3::new(1.1 * (i as f64 - 3.0), 0.5, 0.0);
        stage.add(&name, material, shapes::smooth_sphere(center, 0.5, 4));
    }
    let lamp = stage.lamp("lamp", [7.0, 6.4, 5.6]);
    let lamp_corner = DVec3::new(-2.0, 3.5, -0.2);
    stage.add("lamp", lamp, shapes::quad(lamp_corner, DVec3::X * 4.0, DVec3::Z * 1.2));
    stage.sky([0.25, 0.3, 0.4], [0.1, 0.1, 0.1]);
    stage.camera(shapes::looking_at("front", DVec3::new(0.0, 1.7, 8.0), DVec3::new(0.0, 0.5, 0.0), 24.0));
    stage.scene
}

/// A slab of clear glass of index `ior`, 0.35 thick, over a checkerboard under a uniform sky of radiance 1. What leaves
/// a parallel slab has the radiance that entered it, less the reflected share; nothing depends on `ior` squared.
pub fn glass_slab(ior: f32) -> Scene {
    let mut stage = Stage::new("glass-slab", [96, 96]);
    stage.checkered_floor(4.0);
    let material = stage.material(glass("glass", 0.0, ior));
    let slab = shapes::cuboid(DVec3::new(-0.9, 0.25, -0.9), DVec3::new(0.9, 0.6, 0.9));
    stage.add("slab", material, shapes::turned(slab, DVec3::ZERO, 20.0));
    stage.sky([1.0; 3], [1.0; 3]);
    stage.camera(shapes::looking_at("above", DVec3::new(0.0, 3.0, 3.0), DVec3::new(0.0, 0.2, 0.0), 42.0));
    stage.scene
}

/// A clear dielectric with a volume inside; perceptual roughness.
fn glass(name: &str, roughness: f32, ior: f32) -> Material {
    Material {
        name: name.into(),
        metallic: 0.0,
        roughness,
        transmission: 1.0,
        volume: true,
        ior,
        ..Material::default()
    }
}

/// Waves per unit length of [`bumpy_plane`].
const WAVES: f64 = 3.0;

/// The unit normal of a surface whose height has slope at most `slope` along x and along z; +y where it is flat.
fn wave_normal(slope: f64, x: f64, z: f64) -> DVec3 {
    let along = |at: f64| slope * (TAU * WAVES * at).cos();
    DVec3::new(-along(x), 1.0, -along(z)).normalize()
}

/// A flat floor of 2 x 2 units that shades like waves of slope `slope`, under a low lamp: shading normals far from the
/// geometric one. The left half has its normals at the vertices, the right half has them in a normal map.
pub fn bumpy_plane(slope: f64) -> Scene {
    let mut stage = Stage::new("bumpy-plane", [96, 96]);
    let plain = stage.lambert("vertex normals", [0.7, 0.7, 0.7]);
    let mut left = shapes::grid(DVec3::new(-1.0, 0.0, -1.0), DVec3::Z * 2.0, DVec3::X, [96, 48]);
    left.normals = Some(left.positions.iter().map(|p| wave_normal(slope, p.x, p.z).as_vec3()).collect());
    stage.add("left half", plain, left);

    let map = stage.texture(wave_map(slope), Filter::Linear);
    let mapped = Material { normal_texture: Some(map), ..Material::lambert("normal map", Vec3::splat(0.7)) };
    let mapped = stage.material(mapped);
    // u along x and v along z, so that the tangent is +x and the bitangent, which glTF has against v, is -z.
    let mut right = shapes::flipped(shapes::quad(DVec3::new(0.0, 0.0, -1.0), DVec3::X, DVec3::Z * 2.0));
    let uvs = right.positions.iter().map(|p| DVec2::new(p.x, p.z + 1.0) * WAVES);
    right.uvs[0] = Some(uvs.map(|uv| uv.as_vec2()).collect());
    right.normals = Some(vec![Vec3::Y; 4]);
    right.tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    stage.add("right half", mapped, right);

    let lamp = stage.lamp("lamp", [14.0, 12.0, 9.0]);
    let lamp_corner = DVec3::new(-0.8, 0.4, -1.5);
    stage.add("lamp", lamp, shapes::quad(lamp_corner, DVec3::X * 1.6, DVec3::new(0.0, 0.35, -0.2)));
    stage.camera(shapes::looking_at("front", DVec3::new(0.0, 1.7, 2.3), DVec3::new(0.0, 0.0, 0.1), 45.0));
    stage.scene
}

/// One wave along u and v as a tangent-space normal map; green is against v, as glTF has it.
fn wave_map(slope: f64) -> Image {
    let size = 64;
    let encode = |value: f64| ((value * 0.5 + 0.5) * 255.0).round() as u8;
    let texels = (0..size * size)
        .map(|i| {
            let at = |k: u32| (f64::from(k) + 0.5) / f64::from(size) / WAVES;
            let normal = wave_normal(slope, at(i % size), at(i / size));
            [encode(normal.x), encode(-normal.z), encode(normal.y), 255]
        })
        .collect();
    Image { name: "waves".into(), width: size, height: size, texels }
}
