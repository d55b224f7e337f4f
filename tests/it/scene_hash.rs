//! The hash of a scene's content: every field counts, and none but those.

use glam::{Affine2, DAffine3, DVec3, Vec2, Vec3, Vec4};
use halfway::scene::{
    AlphaMode, Camera, Environment, Filter, Image, Instance, LightKind, Material, Mesh, Projection,
    PunctualLight, Scene, Texture, TextureRef, Warning, Wrap,
};

/// What a change does.
type Change = fn(&mut Scene);

fn reference(texture: u32) -> TextureRef {
    TextureRef { texture, uv_set: 1, transform: Affine2::from_scale(Vec2::splat(2.0)) }
}

/// Every field is something else than by default.
fn scene() -> Scene {
    let material = Material {
        name: "material".into(),
        base_color: Vec3::new(0.5, 0.25, 0.125),
        alpha: 0.5,
        base_color_texture: Some(reference(1)),
        metallic: 0.5,
        roughness: 0.5,
        metallic_roughness_texture: Some(reference(2)),
        normal_texture: Some(reference(3)),
        normal_scale: 0.5,
        emission: Vec3::new(1.0, 2.0, 3.0),
        emission_texture: Some(reference(4)),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        culled: true,
        double_sided: true,
        ior: 1.25,
        specular: 0.5,
        specular_texture: Some(reference(5)),
        specular_color: Vec3::new(0.5, 0.25, 0.125),
        specular_color_texture: Some(reference(6)),
        transmission: 0.5,
        transmission_texture: Some(reference(7)),
        volume: true,
        attenuation_distance: 2.0,
        attenuation_color: Vec3::new(0.5, 0.25, 0.125),
        unlit: true,
    };
    let mesh = Mesh {
        name: "mesh".into(),
        material: 1,
        positions: vec![DVec3::X, DVec3::Y, DVec3::Z],
        normals: Some(vec![Vec3::X, Vec3::Y, Vec3::Z]),
        tangents: Some(vec![Vec4::X, Vec4::Y, Vec4::Z]),
        uvs: [Some(vec![Vec2::X, Vec2::Y, Vec2::ONE]), Some(vec![Vec2::ONE, Vec2::X, Vec2::Y])],
        colors: Some(vec![Vec4::ONE, Vec4::X, Vec4::Y]),
        triangles: vec![[0, 1, 2], [2, 1, 0]],
        instances: vec![Instance {
            transform: DAffine3::from_scale(DVec3::splat(2.0)),
            name: "place".into(),
        }],
    };
    let image = Image { name: "image".into(), width: 2, height: 1, texels: vec![[1, 2, 3, 4], [5, 6, 7, 8]] };
    let texture = Texture { image: 1, wrap: [Wrap::Mirror, Wrap::Clamp], filter: Filter::Nearest };
    let light = PunctualLight {
        name: "light".into(),
        kind: LightKind::Spot { inner: 0.25, outer: 0.5 },
        intensity: Vec3::new(1.0, 2.0, 3.0),
        position: DVec3::new(1.0, 2.0, 3.0),
        direction: Vec3::Y,
    };
    let camera = Camera {
        name: "camera".into(),
        position: DVec3::new(1.0, 2.0, 3.0),
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        projection: Projection::Orthographic { xmag: 2.0, ymag: 1.0 },
    };
    let environment = Environment {
        name: "environment".into(),
        width: 2,
        height: 1,
        texels: vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
        scale: 2.0,
        rotation: 0.5,
    };
    Scene {
        name: "scene".into(),
        meshes: vec![mesh.clone(), mesh],
        materials: vec![material.clone(), material],
        images: vec![image.clone(), image],
        textures: vec![texture, texture],
        lights: vec![light.clone(), light],
        cameras: vec![camera.clone(), camera],
        camera_placed: false,
        variants: Vec::new(),
        environment: Some(environment),
        resolution: Some([2, 1]),
        middle: None,
        repeated: Vec::new(),
        warnings: vec![Warning::new("a part", "it is odd", "it is left out")],
    }
}

fn changed(change: Change) -> u64 {
    let mut scene = scene();
    change(&mut scene);
    scene.content_hash()
}

#[test]
fn every_field_counts() {
    let changes: &[Change] = &[
        |_| {},
        |scene| scene.meshes[1].material = 0,
        |scene| scene.meshes[1].positions[2].z = 2.0,
        |scene| scene.meshes[1].normals = None,
        |scene| scene.meshes[1].normals.as_mut().unwrap()[0] = Vec3::NEG_X,
        |scene| scene.meshes[1].tangents = None,
        |scene| scene.meshes[1].tangents.as_mut().unwrap()[0] = Vec4::W,
        |scene| scene.meshes[1].uvs[0] = None,
        |scene| scene.meshes[1].uvs[1] = None,
        |scene| scene.meshes[1].uvs.swap(0, 1),
        |scene| scene.meshes[1].colors = None,
        |scene| scene.meshes[1].colors.as_mut().unwrap()[0] = Vec4::ZERO,
        |scene| scene.meshes[1].triangles[1] = [1, 2, 0],
        |scene| scene.meshes[1].instances.clear(),
        |scene| scene.meshes[1].instances[0].transform.translation.x = 1.0,
        |scene| drop(scene.meshes.pop()),
        |scene| scene.materials[1].base_color.z = 0.5,
        |scene| scene.materials[1].alpha = 1.0,
        |scene| scene.materials[1].base_color_texture = None,
        |scene| scene.materials[1].metallic = 1.0,
        |scene| scene.materials[1].roughness = 1.0,
        |scene| scene.materials[1].metallic_roughness_texture = None,
        |scene| scene.materials[1].normal_texture = None,
        |scene| scene.materials[1].normal_scale = 1.0,
        |scene| scene.materials[1].emission = Vec3::ZERO,
        |scene| scene.materials[1].emission_texture = None,
        |scene| scene.materials[1].alpha_mode = AlphaMode::Opaque,
        |scene| scene.materials[1].alpha_mode = AlphaMode::Blend,
        |scene| scene.materials[1].alpha_mode = AlphaMode::Mask { cutoff: 0.25 },
        |scene| scene.materials[1].culled = false,
        |scene| scene.materials[1].double_sided = false,
        |scene| scene.materials[1].ior = 1.5,
        |scene| scene.materials[1].specular = 1.0,
        |scene| scene.materials[1].specular_texture = None,
        |scene| scene.materials[1].specular_color = Vec3::ONE,
        |scene| scene.materials[1].specular_color_texture = None,
        |scene| scene.materials[1].transmission = 0.0,
        |scene| scene.materials[1].transmission_texture = None,
        |scene| scene.materials[1].volume = false,
        |scene| scene.materials[1].attenuation_distance = f32::INFINITY,
        |scene| scene.materials[1].attenuation_color = Vec3::ONE,
        |scene| scene.materials[1].unlit = false,
        |scene| scene.materials[1].normal_texture.as_mut().unwrap().texture = 0,
        |scene| scene.materials[1].normal_texture.as_mut().unwrap().uv_set = 0,
        |scene| scene.materials[1].normal_texture.as_mut().unwrap().transform = Affine2::IDENTITY,
        |scene| scene.materials.swap_remove(0).name.clear(),
        |scene| (scene.images[1].width, scene.images[1].height) = (1, 2),
        |scene| scene.images[1].texels[1][3] = 0,
        |scene| scene.textures[1].image = 0,
        |scene| scene.textures[1].wrap = [Wrap::Clamp, Wrap::Mirror],
        |scene| scene.textures[1].filter = Filter::Linear,
        |scene| scene.lights[1].kind = LightKind::Point,
        |scene| scene.lights[1].kind = LightKind::Directional,
        |scene| scene.lights[1].kind = LightKind::Spot { inner: 0.125, outer: 0.5 },
        |scene| scene.lights[1].kind = LightKind::Spot { inner: 0.25, outer: 0.75 },
        |scene| scene.lights[1].intensity.x = 2.0,
        |scene| scene.lights[1].position.x = 2.0,
        |scene| scene.lights[1].direction = Vec3::X,
        |scene| scene.cameras[1].position.x = 2.0,
        |scene| scene.cameras[1].right = Vec3::NEG_X,
        |scene| scene.cameras[1].up = Vec3::NEG_Y,
        |scene| scene.cameras[1].forward = Vec3::Z,
        |scene| scene.cameras[1].projection = Projection::Perspective { yfov: 1.0 },
        |scene| scene.cameras[1].projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0 },
        |scene| scene.cameras[1].projection = Projection::Orthographic { xmag: 2.0, ymag: 2.0 },
        |scene| {
            (scene.environment.as_mut().unwrap().width, scene.environment.as_mut().unwrap().height) = (1, 2)
        },
        |scene| scene.environment.as_mut().unwrap().texels[1][2] = 0.0,
        |scene| scene.environment.as_mut().unwrap().scale = 1.0,
        |scene| scene.environment.as_mut().unwrap().rotation = 0.0,
        |scene| scene.environment = None,
    ];
    let hashes: Vec<u64> = changes.iter().map(|change| changed(*change)).collect();
    for (index, hash) in hashes.iter().enumerate() {
        let same = hashes[..index].iter().position(|other| other == hash);
        assert_eq!(same, None, "change {index} is not told from another one");
    }
}

#[test]
fn what_pictures_do_not_depend_on_does_not_count() {
    let changes: &[Change] = &[
        |scene| scene.name.clear(),
        |scene| scene.meshes[1].name.clear(),
        |scene| scene.meshes[1].instances[0].name = "".into(),
        |scene| scene.materials[1].name.clear(),
        |scene| scene.images[1].name.clear(),
        |scene| scene.lights[1].name.clear(),
        |scene| scene.cameras[1].name.clear(),
        |scene| scene.environment.as_mut().unwrap().name.clear(),
        |scene| scene.resolution = None,
        |scene| scene.variants = vec!["night".into()],
        |scene| scene.warnings.clear(),
        |scene| _ = scene.place_camera(scene.cameras[0].clone()),
    ];
    for (index, change) in changes.iter().enumerate() {
        assert_eq!(changed(*change), changed(|_| {}), "change {index}");
    }
}

/// Saved models name the hash. Where this number has to change, raise the version in `src/scene/hash.rs`, and say in the
/// change that saved models are refused.
#[test]
fn the_hash_stays_what_it_is() {
    let without_instances = changed(|scene| scene.meshes.iter_mut().for_each(|mesh| mesh.instances.clear()));
    assert_eq!(format!("{without_instances:016x}"), "1fc070dc6d0a9a1a");
}
