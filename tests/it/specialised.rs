//! Kernels hold what the scene requires and nothing else: too much changes nothing (S-01), too little is seen (S-02),
//! what is required follows from the scene (S-03), and from no number in it (S-05).

use glam::{Affine2, DAffine3, DVec3, Vec2, Vec3, Vec4};
use halfway::accel::Accel;
use halfway::device::Feature;
use halfway::device::scene::DeviceScene;
use halfway::integrator::{Connections, LvcBpt, METHODS, Method, SpcBpt, View};
use halfway::render::{RenderOptions, Renderer};
use halfway::scene::builtin::{builtin, shapes};
use halfway::scene::{
    AlphaMode, Environment, Filter, Image, LightKind, Material, Mesh, PunctualLight, Scene, SceneFeatures,
    Texture, TextureRef, Wrap,
};
use halfway::subspace::Settings;
use halfway::training::Training;

use crate::bidirectional::renders;
use crate::gpu;
use crate::instances::{pebble, room};
use crate::judge::{grey, lamp, scene};
use crate::shots::{assert_same_light, options, render, try_render};
use crate::stats::{assert_equal_tiles, tile_means};

const SIZE: [u32; 2] = [16, 16];

/// The switch of a feature of scenes.
fn switch(features: &mut SceneFeatures, feature: Feature) -> &mut bool {
    feature.switch(features).expect("a feature of scenes")
}

/// Kernels for everything there is.
pub fn everything() -> SceneFeatures {
    let mut features = SceneFeatures::default();
    for feature in Feature::of_scenes() {
        *switch(&mut features, feature) = feature != Feature::LambertOnly;
    }
    features
}

/// Values of two pictures that are further apart than rounding takes them, as a share, and by how much their means
/// differ.
fn difference(general: &[[f32; 3]], special: &[[f32; 3]]) -> (f64, f64) {
    let pairs = || general.iter().flatten().zip(special.iter().flatten());
    let differ = pairs().filter(|&(a, b)| (a - b).abs() > 1e-4 * a.abs().max(b.abs())).count();
    let sum = |rgb: &[[f32; 3]]| rgb.iter().flatten().map(|&c| f64::from(c)).sum::<f64>();
    (differ as f64 / pairs().count() as f64, sum(general) / sum(special) - 1.0)
}

#[test]
fn s01_general_kernels_make_the_same_picture() {
    for name in ["cornell", "three-lights", "spheres", "bumpy-plane", "glass-slab"] {
        let scene = builtin(name).expect("a built-in scene");
        let special = render(&scene, options(SIZE, 64)).picture;
        let general = RenderOptions { features: Some(everything()), ..options(SIZE, 64) };
        let general = render(&scene, general).picture;
        let (share, mean) = difference(&general.rgb, &special.rgb);
        println!(
            "{name}: {:.2} % of the values differ by more than 1e-4, means by {mean:.1e}",
            100.0 * share
        );
        if share <= 1e-3 {
            assert!(mean.abs() <= 1e-5, "{name}: means differ by {mean:e}");
        } else {
            // Rounding sent some paths another way; then only statistics can tell, with samples of their own.
            let again = RenderOptions {
                view: View { seed: 1, ..options(SIZE, 256).view },
                features: Some(everything()),
                ..options(SIZE, 256)
            };
            let special = render(&scene, options(SIZE, 256)).picture;
            assert_same_light(name, &render(&scene, again).picture, &special);
        }
    }
}

/// A light path that rounding sends another way gives other light vertices to every pixel, so the same seed makes the
/// same picture only where there are none; else the means of independent renders have to agree. Microfacets and glass,
/// which take minutes to compile into every kernel, are forced on one scene only.
#[test]
fn s01_general_bidirectional_kernels_make_the_same_picture() {
    let method = Method::LvcBpt(LvcBpt {
        light_paths: Some(100),
        connections: Connections::even(2),
        light_tracing: true,
    });
    // Everything but microfacets and glass, whose kernels take minutes to compile on a software device.
    for name in ["cornell", "bumpy-plane"] {
        let scene = builtin(name).expect("a built-in scene");
        let mut features = everything();
        features.lambert_only = true;
        for name in [Feature::Transmission, Feature::RoughTransmission, Feature::Absorption] {
            *switch(&mut features, name) = false;
        }
        let special = RenderOptions { method, ..options(SIZE, 16) };
        let general = RenderOptions { features: Some(features.consistent()), ..special.clone() };
        let special = renders(&scene, &special, 0..32);
        // The first seed is the same.
        let general = renders(&scene, &general, (0..1).chain(100..131));
        let first = |pictures: &[Vec<DVec3>]| -> Vec<[f32; 3]> {
            pictures[0].iter().map(|rgb| rgb.as_vec3().to_array()).collect()
        };
        let (share, mean) = difference(&first(&general), &first(&special));
        println!(
            "{name}: {:.2} % of the values differ by more than 1e-4, means by {mean:.1e}",
            100.0 * share
        );
        let tiles = |pictures: &[Vec<DVec3>]| -> Vec<Vec<f64>> {
            pictures[1..].iter().map(|picture| tile_means(picture, SIZE, 8)).collect()
        };
        assert!(share > 1e-3 || mean.abs() <= 1e-5, "{name}: means differ by {mean:e}");
        assert_equal_tiles(name, &tiles(&general), &tiles(&special));
    }
}

/// The form of light vertices for Lambert's law against the general one: the same paths with the same weights. (The
/// weights one by one, of both forms and against the judge's: `c06`.)
#[test]
fn s01_lambert_vertices_make_the_same_picture() {
    for (name, method) in [
        (
            "cornell",
            Method::SpcBpt(SpcBpt {
                light_paths: Some(100),
                connections: Connections::even(2),
                light_tracing: true,
            }),
        ),
        (
            "door",
            Method::SpcBpt(SpcBpt {
                light_paths: Some(100),
                connections: Connections::even(2),
                light_tracing: false,
            }),
        ),
        (
            "three-lights",
            Method::LvcBpt(LvcBpt {
                light_paths: Some(100),
                connections: Connections::even(2),
                light_tracing: true,
            }),
        ),
    ] {
        let scene = builtin(name).expect("a built-in scene");
        let settings = Settings { subspaces: Some(24), ..Settings::default() };
        let training = Training { paths: Some(4000), settings, ..Training::default() };
        let options = RenderOptions { method, training, ..options(SIZE, 8) };
        let mut renderer = Renderer::new(gpu::context(), &scene, options.clone()).expect("a renderer");
        renderer.run(|_| false).expect("a render");
        let special = renderer.picture().expect("a picture").rgb;
        let features = SceneFeatures { lambert_only: false, ..SceneFeatures::of(&scene) };
        let general = RenderOptions { features: Some(features), model: renderer.model.clone(), ..options };
        let general = render(&scene, general).picture.rgb;
        let (share, mean) = difference(&general, &special);
        println!(
            "{name}: {:.2} % of the values differ by more than 1e-4, means by {mean:.1e}",
            100.0 * share
        );
        assert!(share <= 1e-2 && mean.abs() <= 1e-5, "{name}: {share}, {mean:e}");
    }
}

/// A sky that fades from 1 overhead to 0 underneath.
fn fading_sky() -> Environment {
    let texels = vec![[1.0; 3], [0.0; 3]];
    Environment { name: String::new(), width: 1, height: 2, texels, scale: 1.0, rotation: 0.0 }
}

fn floor() -> Mesh {
    shapes::quad(DVec3::new(-1.0, 0.0, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0)
}

/// A floor under a light from straight above, seen from above at an angle.
fn under_the_sun(material: Material, mesh: Mesh) -> Scene {
    let mut scene = scene([(material, mesh)]);
    scene.lights.push(PunctualLight {
        name: "sun".into(),
        kind: LightKind::Directional,
        intensity: Vec3::ONE,
        position: DVec3::ZERO,
        direction: Vec3::NEG_Y,
    });
    scene.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 3.0, 1.0), DVec3::ZERO, 20.0));
    scene
}

/// A slab between the camera and a lamp that fills the view.
fn before_a_lamp(material: Material) -> Scene {
    let slab = shapes::cuboid(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.5));
    let back = shapes::quad(DVec3::new(-2.0, -2.0, -1.0), DVec3::X * 4.0, DVec3::Y * 4.0);
    let mut scene = scene([(material, slab), (lamp(1.0), back)]);
    scene.cameras.push(shapes::looking_at("front", DVec3::Z * 3.0, DVec3::ZERO, 20.0));
    scene
}

fn glass(roughness: f32) -> Material {
    Material { metallic: 0.0, transmission: 1.0, volume: true, roughness, ..Material::default() }
}

/// A floor whose left half is black, by a texture through one of the two sets of coordinates.
fn half_black(uv_set: u32) -> Scene {
    let mut mesh = floor();
    if uv_set == 1 {
        mesh.uvs.swap(0, 1);
    }
    let texture = TextureRef { texture: 0, uv_set, transform: Affine2::IDENTITY };
    let material = Material { base_color_texture: Some(texture), ..grey(0.8) };
    with_picture(under_the_sun(material, mesh), 2, vec![[0, 0, 0, 255], [255; 4]])
}

fn with_picture(mut scene: Scene, width: u32, texels: Vec<[u8; 4]>) -> Scene {
    scene.images.push(Image { name: "picture".into(), width, height: 1, texels });
    scene.textures.push(Texture { image: 0, wrap: [Wrap::Clamp; 2], filter: Filter::Nearest });
    scene
}

/// The least scene for each switch, what must be on for it, and the switch that is turned the wrong way.
fn cases() -> Vec<(Feature, Vec<Feature>, Scene)> {
    use Feature::*;
    let mut glossy = scene([(Material { roughness: 0.3, ..Material::default() }, floor())]);
    glossy.environment = Some(fading_sky());
    glossy.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 3.0, 1.0), DVec3::ZERO, 20.0));
    let mut matte = glossy.clone();
    matte.materials[0] = grey(0.5);

    let coloured =
        Material { ior: 1.0, attenuation_distance: 0.25, attenuation_color: Vec3::splat(0.5), ..glass(0.0) };
    // Its back is turned to the camera.
    let mut wall = before_a_lamp(Material { culled: true, ..grey(0.5) });
    wall.meshes[0] = Mesh {
        material: 0,
        ..shapes::flipped(shapes::quad(DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0))
    };
    let absent = Material { alpha: 0.25, alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..grey(0.5) };

    let tilted = Vec3::new(0.6, 0.8, 0.0);
    let bent = Mesh { normals: Some(vec![tilted; 4]), ..floor() };
    let map = TextureRef { texture: 0, uv_set: 0, transform: Affine2::IDENTITY };
    let dull = Material { metallic_roughness_texture: Some(map), roughness: 0.5, ..Material::default() };
    let bare = Material { specular_texture: Some(map), metallic: 0.0, roughness: 0.5, ..Material::default() };
    let dim_glass = before_a_lamp(Material { transmission_texture: Some(map), ..glass(0.4) });
    let mapped = Material { normal_texture: Some(map), ..grey(0.5) };
    let mapped_floor = Mesh { tangents: Some(vec![Vec4::new(0.0, 0.0, 1.0, 1.0); 4]), ..floor() };
    let mapped = with_picture(under_the_sun(mapped, mapped_floor), 1, vec![[204, 128, 230, 255]]);
    let painted = Mesh { colors: Some(vec![Vec4::new(0.1, 0.1, 0.1, 1.0); 4]), ..floor() };
    let mut panel = scene([(lamp(1.0), floor())]);
    panel.cameras = glossy.cameras.clone();
    let mut screen = panel.clone();
    screen.materials[0].emission_texture = Some(map);
    let unlit = Material { unlit: true, ..grey(0.25) };
    let mut poster = scene([(unlit, floor())]);
    poster.cameras = glossy.cameras.clone();

    vec![
        (LambertOnly, vec![Environment], glossy),
        (Transmission, vec![Transmission, AreaLights], before_a_lamp(glass(0.0))),
        (RoughTransmission, vec![Transmission, RoughTransmission, AreaLights], before_a_lamp(glass(0.4))),
        (Absorption, vec![Transmission, Absorption, AreaLights], before_a_lamp(coloured)),
        (Alpha, vec![LambertOnly, Alpha, AreaLights], before_a_lamp(absent)),
        (Culling, vec![LambertOnly, Culling, AreaLights], wall),
        (Textures, vec![LambertOnly, Textures, Uv0, PunctualLights], half_black(0)),
        (
            MetallicRoughnessTexture,
            vec![Textures, MetallicRoughnessTexture, Uv0, PunctualLights],
            with_picture(under_the_sun(dull, floor()), 1, vec![[255, 255, 0, 255]]),
        ),
        (
            SpecularTexture,
            vec![Textures, SpecularTexture, Uv0, PunctualLights],
            with_picture(under_the_sun(bare, floor()), 1, vec![[255, 255, 255, 0]]),
        ),
        (
            TransmissionTexture,
            vec![Transmission, RoughTransmission, Textures, TransmissionTexture, Uv0, AreaLights],
            with_picture(dim_glass, 1, vec![[128, 0, 0, 255]]),
        ),
        (
            EmissionTexture,
            vec![LambertOnly, Textures, EmissionTexture, Uv0, AreaLights],
            with_picture(screen, 1, vec![[128, 128, 128, 255]]),
        ),
        (Uv0, vec![LambertOnly, Textures, Uv0, PunctualLights], half_black(0)),
        (Uv1, vec![LambertOnly, Textures, Uv1, PunctualLights], half_black(1)),
        (Normals, vec![LambertOnly, Normals, PunctualLights], under_the_sun(grey(0.5), bent)),
        (NormalMap, vec![LambertOnly, Textures, NormalMap, Uv0, PunctualLights], mapped),
        (VertexColors, vec![LambertOnly, VertexColors, PunctualLights], under_the_sun(grey(0.5), painted)),
        (AreaLights, vec![LambertOnly, AreaLights], panel),
        (Unlit, vec![LambertOnly, AreaLights, Unlit], poster),
        (PunctualLights, vec![LambertOnly, PunctualLights], under_the_sun(grey(0.5), floor())),
        (Environment, vec![LambertOnly, Environment], matte),
    ]
}

#[test]
fn s02_a_feature_wrongly_off_is_seen() {
    for (name, _, scene) in cases() {
        let right = render(&scene, options(SIZE, 64)).channel(0);
        let mut features = SceneFeatures::of(&scene);
        let wrong = switch(&mut features, name);
        *wrong = !*wrong;
        let options = RenderOptions { features: Some(features), ..options(SIZE, 64) };
        match try_render(&scene, options) {
            Ok(shot) => {
                let wrong = shot.channel(0);
                let z = right.z(wrong).abs();
                println!("{name}: {right:?} against {wrong:?} without, z = {z:.1}");
                assert!(right.mean > 0.0 && z > 10.0, "{name} makes no difference: {right:?}, {wrong:?}");
            }
            Err(error) => println!("{name}: refused, {error}"),
        }
    }
}

/// A scene whose only emitter has no area is black by every method, also where the features say that it emits.
#[test]
fn s03_an_emitter_without_area_is_no_light() {
    let point = shapes::quad(DVec3::ONE, DVec3::ZERO, DVec3::ZERO);
    let line = shapes::quad(DVec3::ONE, DVec3::X, 2.0 * DVec3::X);
    let mut dark = scene([(grey(0.5), floor()), (lamp(1.0), point), (lamp(1.0), line)]);
    dark.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 3.0, 1.0), DVec3::ZERO, 20.0));
    let features = SceneFeatures::of(&dark);
    assert!(!features.lights(), "{features:?}");
    let forced = SceneFeatures { area_lights: true, ..features };
    for descriptor in METHODS {
        for features in [None, Some(forced)] {
            let options =
                RenderOptions { method: descriptor.default_method(), features, ..options([4, 4], 1) };
            let shot = render(&dark, options);
            assert_eq!(shot.report.lights, 0, "{}", descriptor.name);
            assert!(shot.picture.rgb.iter().flatten().all(|&c| c == 0.0), "{}", descriptor.name);
        }
    }
}

/// Light that is nothing in f32 beside the strongest is left out, whatever its kind.
#[test]
fn s03_light_that_is_too_weak_for_f32_is_left_out() {
    let panel = shapes::quad(DVec3::new(-1.0, 2.0, -1.0), DVec3::X, DVec3::Z);
    let mut strong = scene([(grey(0.5), floor()), (lamp(1e30), panel)]);
    strong.environment = Some(Environment { scale: 1e-30, ..fading_sky() });
    strong.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 3.0, 1.0), DVec3::ZERO, 20.0));
    let shot = render(&strong, options([4, 4], 16));
    assert_eq!(shot.report.lights, 2, "the panel's triangles alone");
}

#[test]
fn s03_features_follow_from_the_scene() {
    use Feature::*;
    let on = |scene: &Scene| -> Vec<Feature> {
        let mut features = SceneFeatures::of(scene);
        Feature::of_scenes().filter(|&feature| *switch(&mut features, feature)).collect()
    };
    let cases = cases();
    for (name, expected, scene) in &cases {
        assert_eq!(on(scene), *expected, "{name}");
    }
    let mut covered: Vec<Feature> = cases.iter().map(|(feature, ..)| *feature).collect();
    covered.sort_unstable();
    assert_eq!(covered, Feature::of_scenes().collect::<Vec<_>>(), "every switch has its scene");

    for (name, expected) in [
        ("cornell", vec![LambertOnly, AreaLights]),
        ("furnace-sphere", vec![LambertOnly, AreaLights]),
        ("glass-slab", vec![Transmission, Textures, Uv0, Environment]),
        ("spheres", vec![Transmission, RoughTransmission, Textures, Normals, Uv0, AreaLights, Environment]),
        ("three-lights", vec![LambertOnly, Normals, AreaLights, PunctualLights, Environment]),
        ("bumpy-plane", vec![LambertOnly, Textures, Normals, NormalMap, Uv0, AreaLights]),
    ] {
        assert_eq!(on(&builtin(name).expect("a built-in scene")), expected, "{name}");
    }

    // What no triangle uses is not required.
    let mut unused = scene([(grey(0.5), floor())]);
    unused.materials.extend([glass(0.5), lamp(1.0), Material { unlit: true, ..grey(1.0) }]);
    unused.meshes.push(Mesh { material: 1, ..Mesh::default() });
    assert_eq!(on(&unused), [LambertOnly]);
    // Lamps that are off, volumes that absorb nothing, lambertian textures.
    assert_eq!(on(&scene([(lamp(0.0), floor())])), [LambertOnly]);
    assert_eq!(on(&scene([(glass(0.0), floor())])), [Transmission]);
    assert_eq!(on(&Scene::default()), [LambertOnly]);
    let mut mesh = floor();
    mesh.uvs[0] = Some(vec![Vec2::ZERO; 4]);
    assert_eq!(on(&scene([(grey(0.5), mesh)])), [LambertOnly], "coordinates that no texture reads");
}

/// Scenes that require the same have the same kernels: none is compiled again where a light is turned up, or where there is
/// more of what was there before.
#[test]
fn s05_no_number_of_a_scene_is_compiled() {
    let compiled_with = |scene: &Scene| {
        let accel = Accel::build(scene).expect("a tree");
        let device = DeviceScene::new(gpu::context(), scene, &accel, SceneFeatures::of(scene));
        let device = device.expect("a device scene");
        (device.kernel_features(), device.constants)
    };
    let mut instanced = room(pebble(), grey(0.5), |i| DAffine3::from_translation(DVec3::X * f64::from(i)));
    instanced.name = "instances".into();
    for scene in [builtin("three-lights").expect("a built-in scene"), instanced] {
        let mut other = scene.clone();
        other.lights.iter_mut().for_each(|light| light.intensity *= 3.0);
        if let Some(environment) = &mut other.environment {
            environment.scale *= 0.3;
            (environment.width, environment.height) = (4, 2);
            environment.texels = (0..8).map(|i| [0.1 + i as f32, 0.2, 0.3]).collect();
        }
        for mesh in &scene.meshes {
            let mut moved = mesh.clone();
            moved.positions.iter_mut().for_each(|position| *position += DVec3::splat(7.0));
            other.meshes.push(moved);
        }
        assert_eq!(compiled_with(&other), compiled_with(&scene), "{}", scene.name);
    }
}
