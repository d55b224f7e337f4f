//! Meshes that are kept once and shown in many places: the same pictures as of copies.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Affine2, DAffine3, DMat3, DVec3, EulerRot, Vec2, Vec3, Vec4};
use halfway::accel::{Accel, arranged};
use halfway::device::layout::{Hit, NO_TRIANGLE};
use halfway::device::scene::{DeviceScene, SceneMemory};
use halfway::device::shader::{SOURCES, stitch, stitch_text};
use halfway::device::{Context, Feature, Features, Kernel, PagedBuffer};
use halfway::film::Picture;
use halfway::integrator::{Bdpt, Connections, LightTracing, LvcBpt, Method, SpcBpt};
use halfway::render::{RenderOptions, Renderer, SeenLayers};
use halfway::scene::builtin::shapes;
use halfway::scene::gltf::{LoadOptions, load_slice};
use halfway::scene::{
    AlphaMode, Filter, Image, Instance, Instancing, Material, Mesh, Scene, SceneFeatures, Texture,
    TextureRef, Wrap, worth_keeping,
};
use halfway::subspace::Settings;
use halfway::training::Training;

use serde_json::json;

use crate::gltf_file::GltfFile;
use crate::gpu;
use crate::judge::{grey, horizontal, lamp, scene};
use crate::random::Stream;
use crate::shots::{options, render};
use crate::traversal::{self, Ray, tracing};

const LVCBPT: Method =
    Method::LvcBpt(LvcBpt { light_paths: Some(100), connections: Connections::even(2), light_tracing: true });

/// Methods that between them compile all that depends on instances.
fn methods() -> [Method; 4] {
    let spcbpt = SpcBpt { light_paths: Some(100), connections: Connections::even(2), light_tracing: false };
    [Method::Path, Method::Bdpt(Bdpt { light_tracing: false }), LVCBPT, Method::SpcBpt(spcbpt)]
}

fn instances(transforms: impl IntoIterator<Item = DAffine3>) -> Vec<Instance> {
    let numbered = transforms.into_iter().enumerate();
    numbered.map(|(i, transform)| Instance { transform, name: Arc::from(format!("{i}")) }).collect()
}

/// A body whose coordinates have few digits, so that whatever moves it by few digits is exact.
pub fn pebble() -> Mesh {
    let mut mesh = shapes::icosphere(DVec3::ZERO, 1.0, 2);
    mesh.positions.iter_mut().for_each(|p| *p = (*p * 64.0).round() / 64.0);
    mesh.uvs[0] = Some(mesh.positions.iter().map(|p| Vec2::new(p.x as f32, p.y as f32)).collect());
    mesh.colors =
        Some(mesh.positions.iter().map(|p| Vec4::new(0.5 + 0.5 * p.z as f32, 0.8, 0.7, 1.0)).collect());
    mesh
}

/// Bodies over a floor under a lamp, in places that are moved by `place`.
pub fn room(body: Mesh, material: Material, place: impl Fn(u32) -> DAffine3) -> Scene {
    // One triangle, since lights are numbered in the order of the tree.
    let mut above = horizontal(1.5, 3.0, false);
    above.triangles.truncate(1);
    let mut scene = scene([(grey(0.5), horizontal(8.0, -1.0, true)), (lamp(6.0), above), (material, body)]);
    scene.meshes[2].instances = instances((0..9).map(place));
    for mesh in &mut scene.meshes {
        mesh.uvs[0].get_or_insert_with(|| vec![Vec2::ZERO; mesh.positions.len()]);
    }
    scene.cameras.push(shapes::looking_at("above", DVec3::new(0.5, 2.5, 4.0), DVec3::ZERO, 45.0));
    scene.images.push(Image {
        name: "squares".into(),
        width: 2,
        height: 2,
        texels: vec![[255, 200, 90, 255], [30, 60, 90, 0], [200, 200, 200, 100], [90, 120, 200, 255]],
    });
    scene.textures.push(Texture { image: 0, wrap: [Wrap::Repeat; 2], filter: Filter::Nearest });
    scene
}

pub fn textured(material: Material) -> Material {
    let reference = TextureRef { texture: 0, uv_set: 0, transform: Affine2::from_scale(Vec2::splat(2.5)) };
    Material { base_color_texture: Some(reference), ..material }
}

/// Moved and scaled along the axes by few digits: the order of vertices stays what it is.
fn exact(i: u32) -> DAffine3 {
    let (x, z) = (f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0);
    let scale = [DVec3::new(0.25, 0.375, 0.25), DVec3::splat(0.25), DVec3::new(0.25, 0.125, 0.3125)];
    DAffine3::from_translation(DVec3::new(x, -0.5 + 0.125 * f64::from(i), z))
        * DAffine3::from_scale(scale[i as usize % 3])
}

/// Turned, stretched and sheared, and every other one is a mirror image.
pub fn oblique(i: u32) -> DAffine3 {
    let turn = DMat3::from_euler(EulerRot::XYZ, 0.7 * f64::from(i), 1.1, 0.3 * f64::from(i));
    let mirror = if i.is_multiple_of(2) { -1.0 } else { 1.0 };
    let stretch =
        DMat3::from_cols(DVec3::new(0.3 * mirror, 0.0, 0.0), DVec3::new(0.1, 0.2, 0.0), DVec3::Z * 0.4);
    DAffine3 { matrix3: turn * stretch, translation: exact(i).translation * 1.1 }
}

fn copies(scene: &Scene) -> Scene {
    let copies = scene.with_copies(|_, _| true).into_owned();
    assert!(scene.has_instances() && !copies.has_instances());
    assert_eq!(scene.triangle_count(), copies.triangle_count());
    copies
}

fn pictures(scene: &Scene, method: Method, size: [u32; 2], samples: u32) -> [Picture; 2] {
    let settings = Settings { subspaces: Some(24), ..Settings::default() };
    let training = Training { paths: Some(2000), settings, ..Training::default() };
    let options = RenderOptions { method, training, ..options(size, samples) };
    [scene.clone(), copies(scene)].map(|scene| render(&scene, options.clone()).picture)
}

/// Share of values that differ by more than rounding, and by how much the means do.
pub fn difference([a, b]: &[Picture; 2]) -> (f64, f64) {
    let pairs = || a.rgb.as_flattened().iter().zip(b.rgb.as_flattened());
    let apart = pairs().filter(|(a, b)| (*a - *b).abs() > 1e-4 * a.abs().max(b.abs())).count();
    let sum = |picture: &Picture| picture.rgb.as_flattened().iter().map(|&x| f64::from(x)).sum::<f64>();
    (apart as f64 / pairs().count() as f64, sum(a) / sum(b) - 1.0)
}

/// Where transforms are exact, so are pictures: bit for bit those of copies, by all kinds of methods.
#[test]
fn r13_instances_are_copies_bit_for_bit() {
    let masked = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.3 }, ..textured(grey(0.8)) };
    let mut scene = room(pebble(), masked, exact);
    scene.cull_backs();
    for method in methods() {
        let [shared, copied] = pictures(&scene, method, [24, 24], 8);
        let differ = shared.rgb.iter().zip(&copied.rgb).filter(|(a, b)| a != b).count();
        println!("{}: {differ} of {} pixels differ", method.name(), shared.rgb.len());
        assert!(differ == 0, "{}: {differ} pixels differ", method.name());
    }
}

/// Where they are not, pictures differ by rounding: normals, tangents and fronts are those of copies.
#[test]
fn r13_turned_and_mirrored_instances_look_as_copies() {
    let mut smooth = shapes::smooth_sphere(DVec3::ZERO, 1.0, 2);
    let normals = smooth.normals.clone().unwrap();
    let tangent =
        |n: &Vec3| n.cross(Vec3::new(0.3, 0.9, 0.2)).normalize().extend(if n.x > 0.0 { 1.0 } else { -1.0 });
    smooth.tangents = Some(normals.iter().map(tangent).collect());
    smooth.uvs[0] = Some(smooth.positions.iter().map(|p| Vec2::new(p.x as f32, p.y as f32)).collect());
    let map = TextureRef { texture: 0, uv_set: 0, transform: Affine2::IDENTITY };
    let mapped = Material { normal_texture: Some(map), normal_scale: 0.5, ..grey(0.8) };
    let one_sided = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.3 }, ..textured(grey(0.8)) };
    for (name, body, material) in [
        ("flat", pebble(), one_sided),
        ("smooth", Mesh { tangents: None, ..smooth.clone() }, grey(0.8)),
        ("mapped", smooth, mapped),
    ] {
        let mut scene = room(body, material, oblique);
        if name == "flat" {
            scene.cull_backs();
        }
        for method in [Method::Path, LVCBPT] {
            let pictures = pictures(&scene, method, [20, 20], 8);
            let (share, mean) = difference(&pictures);
            println!(
                "{name}, {}: {:.2} % of the values differ, means by {mean:.1e}",
                method.name(),
                100.0 * share
            );
            assert!(share < 0.02 && mean.abs() < 2e-3, "{name}, {}: {share} {mean:e}", method.name());
        }
    }
}

/// What rays of a scene meet.
fn trace(scene: &Scene, accel: &Accel, rays: &[Ray], any: bool) -> Vec<Hit> {
    let context = gpu::context();
    let device = DeviceScene::new(context, scene, accel, SceneFeatures::of(scene)).expect("a device scene");
    let text = tracing(rays.len());
    let any = if any { &[Feature::AnyHit][..] } else { &[] };
    let stitched = stitch_text("test kernel", &text, device.kernel_features().with(any)).expect("directives");
    let kernel =
        Kernel::from_stitched(context, "test kernel", &stitched, &device.constants).expect("a kernel");
    let mut buffers = device.buffers.clone();
    buffers.upload(context, "rays", rays).expect("upload");
    let bytes = (rays.len() * size_of::<Hit>()) as u64;
    buffers.create(context, "found", bytes).expect("create");
    let bound = kernel.bind(context, &buffers).expect("all buffers named");
    let mut encoder = context.device.create_command_encoder(&Default::default());
    bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), rays.len() as u32);
    context.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&buffers.read(context, "found", bytes).expect("read"))
}

/// Nothing leaks out of instances: rays from inside aimed at vertices, edges and faces, for closest and for any hit, in
/// places near and far, turned and stretched; and what they meet is the triangle that they were aimed at, as the host has it.
#[test]
fn n05_instances_are_closed() {
    for (size, far) in [(1.0, 0.0), (1e-3, 1.0), (1.0, 100.0)] {
        let place = |i: u32| {
            let DAffine3 { matrix3, translation } = oblique(i);
            let away = DVec3::new(f64::from(i) * 3.0, 1.0, -f64::from(i * i));
            DAffine3 { matrix3: matrix3 * size, translation: translation * size + far * away }
        };
        let mut scene = traversal::scene([shapes::icosphere(DVec3::new(7.0, -3.0, 2.0), 1.0, 3)]);
        scene.meshes[0].instances = instances((0..9).map(place));
        let accel = Accel::build(&scene).expect("a BVH");
        assert_eq!(accel.numbers().count(), 9 * 1280);
        let mut stream = Stream::new(3);
        let (mut rays, mut targets) = (Vec::new(), Vec::new());
        for instance in &accel.instances.list {
            let inside = instance.point(Vec3::ZERO);
            for index in 0..6000 {
                let number = instance.first_number + stream.word() % instance.triangles;
                let [a, b, c] = accel.triangle_at(number).vertices;
                let u = stream.vec2();
                let target = match index % 3 {
                    0 => a,
                    1 => 0.5 * (b + c),
                    _ => a + (b - a) * u.x + (c - a) * (1.0 - u.x) * u.y,
                };
                rays.push(Ray::new(inside, target - inside));
                targets.push((index % 3 == 2).then_some(number));
            }
        }
        let closest = trace(&scene, &accel, &rays, false);
        let misses = closest.iter().filter(|hit| hit.triangle == NO_TRIANGLE).count();
        let any_misses =
            trace(&scene, &accel, &rays, true).iter().filter(|hit| hit.triangle == NO_TRIANGLE).count();
        let others =
            closest.iter().zip(&targets).filter(|(hit, target)| target.is_some_and(|t| t != hit.triangle));
        let others = others.count();
        println!(
            "size {size}, far {far}: {} rays, {misses} and {any_misses} misses, {others} other triangles",
            rays.len()
        );
        assert_eq!([misses, any_misses], [0, 0]);
        // A target a rounding from an edge may be its neighbour's; of the smallest triangles rounding is a hundredth.
        assert!(others < rays.len() / if size == 1.0 && far == 0.0 { 1000 } else { 20 }, "{others}");
    }
}

/// Instances in pages of a few hundred bytes.
#[test]
fn r12_instances_are_the_same_in_pages() {
    let mut scene = room(pebble(), textured(grey(0.8)), exact);
    // Few triangles in many places, of two meshes.
    let part = |first: usize, count: usize| {
        let triangles = scene.meshes[2].triangles[first..first + count].to_vec();
        let lifted = |i: u32| DAffine3::from_translation(DVec3::Y * f64::from(i / 9)) * exact(i % 9);
        let places = (0..27).map(|i| lifted(i + 27 * u32::from(first > 0)));
        Mesh { triangles, instances: instances(places), ..scene.meshes[2].clone() }
    };
    let parts = [part(0, 12), part(60, 17)];
    scene.meshes.splice(2.., parts);
    let memory = SceneMemory::of(&scene, &SceneFeatures::of(&scene));
    let page_bytes = (8..).map(|bits| 1u64 << bits).find(|&bytes| memory.pages(bytes).extra() <= 15).unwrap();
    let pages = memory.pages(page_bytes);
    assert!(pages.of(PagedBuffer::Instances) > 1 && pages.of(PagedBuffer::Triangles) > 1, "{page_bytes}");
    let rgb = |context: &Context| {
        let mut renderer = Renderer::new(context, &scene, options([16, 16], 2)).unwrap();
        renderer.run(|_| false).unwrap();
        renderer.picture().unwrap().rgb
    };
    assert!(
        rgb(gpu::context()) == rgb(&gpu::context().with_page_bytes(page_bytes)),
        "pages make another picture"
    );

    let accel = Accel::build(&scene).unwrap();
    let device = DeviceScene::new(gpu::context(), &scene, &accel, SceneFeatures::of(&scene)).unwrap();
    for &(buffer, foretold) in memory.buffers.iter().filter(|(buffer, _)| *buffer != PagedBuffer::Nodes) {
        let have = device.buffers.get(buffer.name()).unwrap().size();
        assert_eq!(have, foretold.max(16).next_multiple_of(16), "{buffer:?}");
    }
}

/// On a device that binds little at once: the film of 64x48 pixels and what light paths bring to it are in pages.
#[test]
fn r08_instances_are_the_same_where_little_is_bound() {
    let scene = room(pebble(), textured(grey(0.8)), exact);
    let method = Method::Light(LightTracing { light_paths: None });
    let rgb = |context: &Context| {
        let options = RenderOptions { method, ..options([64, 48], 2) };
        let mut renderer = Renderer::new(context, &scene, options).unwrap();
        renderer.run(|_| false).unwrap();
        renderer.picture().unwrap().rgb
    };
    let whole = rgb(gpu::context());
    assert!(whole.iter().filter(|rgb| rgb[1] > 0.0).count() > 500);
    assert!(whole == rgb(&gpu::context().with_small_bindings(56 << 10)), "pages make another picture");
}

/// Layers for compositing, and what the host asks of a scene, are those of copies.
#[test]
fn instances_have_names_places_and_bounds() {
    let scene = room(pebble(), textured(grey(0.8)), exact);
    let copied = copies(&scene);
    assert_eq!(scene.bounds(), copied.bounds());
    let (origin, down) = (DVec3::new(0.1, 4.0, 0.05), DVec3::new(0.0, -1.0, 0.01));
    assert!(scene.distance_along(origin, down).is_some());
    assert_eq!(scene.distance_along(origin, down), copied.distance_along(origin, down));
    let seen = SeenLayers { alpha: true, position: true, uv: true, ids: true };
    let options = RenderOptions { seen, ..options([16, 16], 4) };
    let [shared, copied] = [&scene, &copied].map(|scene| render(scene, options.clone()).picture);
    assert!(shared.layers.len() > 3, "{}", shared.layers.len());
    for (a, b) in shared.layers.iter().zip(&copied.layers) {
        assert!(a == b, "{}", a.name);
    }
}

/// Which of its places a mesh is still shown in by instances.
fn kept(scene: &Scene, mesh: &str) -> Vec<String> {
    let arranged = arranged(scene);
    let named = arranged.meshes.iter().filter(|other| other.name == mesh);
    named.flat_map(|mesh| &mesh.instances).map(|instance| instance.name.to_string()).collect()
}

/// What lies in another surface becomes a copy, since it is decided for single triangles which is in front; the others stay.
#[test]
fn instances_in_the_plane_of_others_are_copies() {
    let cube =
        |name: &str| Mesh { name: name.into(), ..shapes::cuboid(DVec3::splat(-0.25), DVec3::splat(0.25)) };
    let at = |x: f64, y: f64| DAffine3::from_translation(DVec3::new(x, y, 0.0));
    let mut scene = room(cube("cube"), grey(0.8), |_| DAffine3::IDENTITY);
    let turned = at(3.0, 1.0) * DAffine3::from_rotation_y(0.3);
    // On the floor; apart; face to face with the next; turned, so that only its top shares a plane, but no area, with others.
    scene.meshes[2].instances =
        instances([at(-2.0, -0.75), at(0.0, 0.0), at(1.0, 1.0), at(1.5, 1.0), turned]);
    assert_eq!(kept(&scene, "cube"), ["1", "4"]);
    assert_eq!(arranged(&scene).triangle_count(), scene.triangle_count());
    assert!(arranged(&scene).repeated[0].reason.contains("3 of its instances"));
    // All but touching: a millionth above the floor.
    scene.meshes[2].instances = instances([at(-2.0, -0.75 + 1e-5), at(0.0, 0.0)]);
    assert_eq!(kept(&scene, "cube"), ["1"]);
    // Faces that stand twice.
    let mut double = cube("cube");
    double.triangles.extend(double.triangles.clone().iter().map(|&[a, b, c]| [a, c, b]));
    double.instances = instances([at(0.0, 0.0), turned]);
    scene.meshes[2] = Mesh { material: 2, ..double };
    assert_eq!(kept(&scene, "cube"), [""; 0]);
    // Nothing to do.
    let apart = room(pebble(), grey(0.8), oblique);
    assert!(matches!(arranged(&apart), Cow::Borrowed(_)));
}

/// Small things that are instances have their shadows on wide grounds, as copies have (N-27).
#[test]
fn n27_instances_stand_on_wide_grounds() {
    let mut scene = room(pebble(), grey(0.5), exact);
    let reach = 3e6;
    let ground =
        shapes::quad(DVec3::new(-reach, -1.0, -reach), 2.0 * reach * DVec3::Z, 2.0 * reach * DVec3::X);
    scene.meshes[0] = Mesh { material: 0, uvs: scene.meshes[0].uvs.clone(), ..ground };
    let shared = arranged(&scene);
    let copied = copies(&scene);
    let cut = arranged(&copied);
    assert!(shared.has_instances() && shared.triangle_count() > scene.triangle_count() + 20);
    assert!(shared.triangle_count() <= cut.triangle_count());
    let pictures = pictures(&scene, Method::Path, [16, 16], 64);
    let (share, mean) = difference(&pictures);
    println!("{share} {mean:e}");
    assert!(share < 0.01 && mean.abs() < 1e-3, "{share} {mean}");
}

/// Where instances take much less than copies, the loader keeps them; names are those of nodes.
#[test]
fn the_loader_keeps_instances_where_that_saves() {
    let mut file = GltfFile::triangle();
    let translations = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
    let extension = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translations}}});
    file.json["nodes"] = json!([
        {"mesh": 0, "name": "many", "translation": [10, 0, 0], "extensions": extension},
        {"mesh": 0, "name": "one", "scale": [-1, 1, 1]},
        {"mesh": 0, "name": "none", "scale": [0, 1, 1]},
    ]);
    let scene = |instancing| {
        load_slice(&file.gltf(), None, &LoadOptions { instancing, ..LoadOptions::default() }).unwrap()
    };
    for instancing in [Instancing::Auto, Instancing::Never] {
        assert_eq!(scene(instancing).meshes.len(), 4);
    }
    let always = scene(Instancing::Always);
    // What has no inverse is a copy.
    assert_eq!((always.meshes[0].name.as_str(), always.meshes[0].instances.len()), ("none", 0));
    let names: Vec<&str> = always.meshes[1].instances.iter().map(|instance| &*instance.name).collect();
    assert_eq!(names, ["many", "many", "one"]);
    assert_eq!(always.meshes[1].instances[1].transform.translation, DVec3::new(10.0, 0.0, 5.0));
    assert_eq!(always.triangle_count(), 4);
    let copied = copies(&always);
    let sorted = |scene: &Scene| {
        let mut all: Vec<String> =
            scene.meshes.iter().map(|m| format!("{:?} {:?}", m.positions, m.triangles)).collect();
        all.sort();
        all
    };
    assert_eq!(sorted(&copied), sorted(&scene(Instancing::Never)));
    assert!(worth_keeping(768, 10_000).is_ok());
    assert!(worth_keeping(768, 100).unwrap_err().contains("faster"));
    assert!(worth_keeping(2, 1_000_000).unwrap_err().contains("faster in copies"));

    // Lights are triangles.
    file.json["materials"] = json!([{"emissiveFactor": [1, 1, 1]}]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let options = LoadOptions { instancing: Instancing::Always, ..LoadOptions::default() };
    let lamps = load_slice(&file.gltf(), None, &options).unwrap();
    assert!(!lamps.has_instances());
}

/// What a scene does not need costs nothing: without instances the text of a kernel has nothing of them.
#[test]
fn s03_kernels_without_instances_know_none() {
    let mut features = SceneFeatures::default();
    for feature in Feature::of_scenes() {
        *feature.switch(&mut features).unwrap() = feature != Feature::LambertOnly;
    }
    let features = Features::from(features).with(&[Feature::Coincident]);
    let mut differ = 0;
    for (name, _) in
        SOURCES.iter().filter(|(name, _)| !name.starts_with("lib/instance") && *name != "lib/two_levels")
    {
        let [without, with] = [features, features.with(&[Feature::Instances])]
            .map(|features| stitch(name, features).unwrap().code);
        let code = without.lines().filter(|line| !line.trim_start().starts_with("//"));
        let of_instances =
            |line: &&str| line.to_lowercase().contains("instance") || line.contains("stored_triangle");
        assert_eq!(code.clone().find(of_instances), None, "{name}");
        differ += u32::from(without != with);
    }
    assert!(differ > 20, "{differ}");
}
