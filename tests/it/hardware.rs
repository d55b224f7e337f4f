//! Rays by the driver's ray queries: they find what kernels find, but for rounding at edges. Software devices have them, too,
//! so that all of this is tested without a GPU.

use std::path::Path;

use glam::{DVec3, Vec3};
use halfway::accel::{Accel, arranged};
use halfway::device::layout::{Camera, Hit, NO_TRIANGLE};
use halfway::device::scene::{DeviceScene, Tracing};
use halfway::device::{Context, DeviceChoice, Feature, Traversal};
use halfway::film::Attribute;
use halfway::film::merge::{Merged, merge};
use halfway::integrator::{Connections, LvcBpt, Method, PcBpt};
use halfway::render::rays::{RaySet, RayTracer, TestRay, further_rays, primary_rays};
use halfway::render::tracing::settle;
use halfway::render::{Budget, RenderOptions, Renderer, maker, take_up};
use halfway::scene::builtin::{builtin, closed, shapes};
use halfway::scene::gltf::{LoadOptions, load};
use halfway::scene::{AlphaMode, Material, Scene, SceneFeatures};

use crate::checkpoint::keeping;
use crate::culling::house;
use crate::determinism::assert_same;
use crate::emissive_alpha::lamp_of;
use crate::gpu;
use crate::instances::{difference, oblique, pebble, room, textured};
use crate::judge::{grey, scene};
use crate::random::Stream;
use crate::shots::{Shot, options, try_render_on};
use crate::traversal::uv_sphere;

/// Of the picture whose rays are compared; and where rays are cheap.
const SIZE: [u32; 2] = [160, 160];
const LARGE: [u32; 2] = [512, 512];

/// The same device, asked to trace by what it does not trace by otherwise.
fn tracing_by(context: &Context, traversal: Traversal) -> Context {
    let mut other = context.clone();
    other.traversal = traversal;
    other
}

/// A scene on a device, with what traces it both ways.
struct Both {
    accel: Accel,
    device_scene: DeviceScene,
    scene: Scene,
}

impl Both {
    fn new(context: &Context, scene: &Scene) -> Self {
        let scene = arranged(scene).into_owned();
        let accel = Accel::build(&scene).expect("a BVH");
        let features = SceneFeatures::of(&scene);
        // What kernels need is there, too, as long as nothing is settled.
        let open = tracing_by(context, Traversal::Auto);
        let device_scene = DeviceScene::new(&open, &scene, &accel, features).expect("a scene on the device");
        assert_eq!(device_scene.tracing, Tracing::Open);
        Self { accel, device_scene, scene }
    }

    fn tracer(&self, context: &Context, more: &[Feature], rays: usize) -> RayTracer {
        RayTracer::new(context, &self.device_scene, more, rays as u64).expect("kernels that trace")
    }

    fn primary(&self) -> RaySet {
        let size = if self.accel.triangles.len() < 100 { LARGE } else { SIZE };
        let [width, height] = size;
        primary_rays(&Camera::new(&self.device_scene.unit, &self.scene.cameras[0], width, height), size)
    }
}

/// What is different between two answers to the same rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Differences {
    rays: usize,
    /// Another triangle, or none on one side.
    triangles: usize,
    /// Of those the ones that are of another mesh; and those at another place, so that they are no neighbours.
    meshes: usize,
    places: usize,
    /// The same triangle, at another place.
    bits: usize,
    shadows: usize,
}

impl Differences {
    fn add(&mut self, accel: &Accel, ours: &[Hit], theirs: &[Hit], what: &str) {
        self.rays += ours.len();
        let mesh = |hit: &Hit| (hit.triangle != NO_TRIANGLE).then(|| accel.triangle_at(hit.triangle).mesh);
        for (index, (a, b)) in ours.iter().zip(theirs).enumerate() {
            let far = (a.t - b.t).abs() > 1e-5 * (1.0 + a.t.abs());
            self.triangles += usize::from(a.triangle != b.triangle);
            self.meshes += usize::from(mesh(a) != mesh(b));
            self.places += usize::from(a.triangle != b.triangle && far);
            self.bits += usize::from(a.triangle == b.triangle && a != b);
            if a.triangle != b.triangle && far {
                println!("  {what} {index}: {a:?} by kernels, {b:?} by ray queries");
            }
        }
    }
}

/// Compares rays of all three kinds.
fn differences(context: &Context, scene: &Scene) -> Differences {
    let both = Both::new(context, scene);
    let primary = both.primary();
    let [ours, theirs] =
        [&[][..], &[Feature::RayQuery]].map(|more| both.tracer(context, more, primary.rays.len()));
    let hits = |tracer: &RayTracer, set: &RaySet| tracer.hits(context, set).expect("hits");
    let mut found = Differences::default();
    let first = hits(&ours, &primary);
    found.add(&both.accel, &first, &hits(&theirs, &primary), "primary");
    let [bounce, shadow] = further_rays(&both.accel, &primary, &first);
    found.add(&both.accel, &hits(&ours, &bounce), &hits(&theirs, &bounce), "bounce");
    let shadows = |tracer: &RayTracer| tracer.occluded(context, &shadow).expect("hits");
    let [ours, theirs] = [shadows(&ours), shadows(&theirs)];
    found.rays += ours.len();
    found.shadows = ours.iter().zip(&theirs).filter(|(a, b)| a != b).count();
    println!("{}: {found:?}", scene.name);
    found
}

fn file(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    let mut scene = load(&path, &LoadOptions::default()).expect("a scene");
    scene.name = name.into();
    scene
}

/// Of so many rays one may be found to meet something else: at edges, and where surfaces cross.
const ONE_DIFFERS: usize = 10_000;

#[track_caller]
fn assert_same_hits(scenes: impl IntoIterator<Item = Scene>, check: impl Fn(&Differences) -> bool) {
    let Some(context) = gpu::hardware() else { return };
    for scene in scenes {
        let found = differences(context, &scene);
        assert!(found.rays > 1000, "{}: {found:?}", scene.name);
        assert!((found.places + found.shadows) * ONE_DIFFERS <= found.rays, "{}: {found:?}", scene.name);
        // What is hit is measured by one rule, whoever finds it.
        assert!(found.bits * ONE_DIFFERS <= found.rays, "{}: {found:?}", scene.name);
        assert!(check(&found), "{}: {found:?}", scene.name);
    }
}

#[test]
fn n29_ray_queries_find_what_kernels_find() {
    let names = ["cornell", "door", "spheres", "glass-slab", "furnace-sphere", "many-lights", "three-lights"];
    assert_same_hits(names.map(|name| builtin(name).expect("a built-in scene")), |_| true);
}

/// Surfaces that all but touch, and those in one plane: the driver cannot tell which is nearer, so kernels do.
#[test]
fn n29_ray_queries_find_what_is_in_front() {
    let files =
        ["right/t69_thin_gap_4e-05.gltf", "right/t69_thin_gap_1e-06.gltf", "extremes/plates_2^-20.glb"];
    let lying = ["extremes/coplanar_emitters.glb", "extremes/coplanar_one_lamp_below_ceiling.glb"];
    let scenes = files.into_iter().chain(lying).map(|name| file(&format!("tests/cases/{name}")));
    assert_same_hits(scenes, |found| found.meshes == 0);
}

/// Turned, stretched and mirrored, also where a mesh lies in several pages of the device.
#[test]
fn n29_ray_queries_find_instances() {
    let Some(context) = gpu::hardware() else { return };
    let scene = room(pebble(), grey(0.7), oblique);
    assert!(arranged(&scene).has_instances());
    for context in [context.clone(), context.with_page_bytes(64 * 48)] {
        let found = differences(&context, &scene);
        assert!((found.triangles + found.bits + found.shadows) * 1000 <= found.rays, "{found:?}");
    }
}

/// Closed surfaces stay closed but for rays that are aimed exactly at an edge or at a vertex: drivers may let some of these
/// through, as Mesa's software driver does. How many is counted; no ray goes through the middle of a triangle.
#[test]
fn n05_watertight_by_ray_queries() {
    let Some(context) = gpu::hardware() else { return };
    let mut stream = Stream::new(5);
    for center in [DVec3::ZERO, DVec3::new(148_376.0, 1234.0, -223_423.0)] {
        let mut sphere = scene([(grey(0.5), uv_sphere(center, 2.0, 60, 60))]);
        sphere.cameras.push(shapes::looking_at("inside", center, center + DVec3::X, 60.0));
        let both = Both::new(context, &sphere);
        let middle = both.device_scene.unit.point(center);
        let rays = (0..100_000).map(|index| {
            let pick = stream.word() as usize % both.accel.triangles.len();
            let [a, b, c] = both.accel.triangles[pick].vertices;
            let target = match index % 3 {
                0 => [a, b, c][index / 3 % 3],
                1 => 0.5 * ([a, b, c][index / 3 % 3] + [b, c, a][index / 3 % 3]),
                _ => a + (b - a) * stream.f32() * 0.5 + (c - a) * stream.f32() * 0.5,
            };
            let aside = 0.1 * (2.0 * Vec3::new(stream.f32(), stream.f32(), stream.f32()) - 1.0);
            let origin = if index % 2 == 0 { middle } else { middle + aside };
            let direction = target - origin;
            TestRay { origin: origin.to_array(), direction: direction.to_array(), t_max: f32::MAX }
        });
        let rays: Vec<TestRay> = rays.collect();
        let tracer = both.tracer(context, &[Feature::RayQuery], rays.len());
        let closest = RaySet { name: "closest", rays: rays.clone(), any_hit: false };
        let any = RaySet { name: "any", rays, any_hit: true };
        let hits = tracer.hits(context, &closest).expect("hits");
        let met = tracer.occluded(context, &any).expect("hits");
        // Aimed at a vertex, at the middle of an edge, and anywhere.
        let mut leaks = [[0; 2]; 3];
        for (index, (hit, met)) in hits.iter().zip(met).enumerate() {
            leaks[index % 3][0] += usize::from(hit.triangle == NO_TRIANGLE);
            leaks[index % 3][1] += usize::from(!met);
        }
        let [vertices, edges, anywhere] = leaks;
        println!(
            "sphere at {center}, {} rays: leaks at {vertices:?} vertices, {edges:?} edges, {anywhere:?}",
            hits.len()
        );
        assert!(anywhere.iter().all(|&leaks| leaks <= 3), "{anywhere:?}");
        assert!(vertices.iter().chain(&edges).all(|&leaks| leaks * 3 * 50 <= hits.len()), "{leaks:?}");
    }
}

/// Drivers may make anything of rays that are none.
#[test]
fn rays_that_are_not_finite_meet_nothing() {
    let Some(context) = gpu::hardware() else { return };
    let both = Both::new(context, &builtin("cornell").expect("a built-in scene"));
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let mut rays = Vec::new();
    for (bad, axis) in bad.into_iter().flat_map(|bad| (0..3).map(move |axis| (bad, axis))) {
        for part in 0..2 {
            let mut numbers = [[0.0, 0.0, 0.1], [0.3, 0.2, -1.0]];
            numbers[part][axis] = bad;
            rays.push(TestRay { origin: numbers[0], direction: numbers[1], t_max: f32::MAX });
        }
    }
    rays.push(TestRay { origin: [0.0; 3], direction: [0.0; 3], t_max: 1.0 });
    let end = |t_max| TestRay { origin: [0.0; 3], direction: [0.0, -1.0, 0.0], t_max };
    rays.extend([0.0, -1.0, f32::NAN].map(end));
    let tracer = both.tracer(context, &[Feature::RayQuery], rays.len());
    let closest = RaySet { name: "closest", rays: rays.clone(), any_hit: false };
    let first_ends = rays.len() - 3;
    let hits = tracer.hits(context, &closest).expect("hits");
    assert!(hits[..first_ends].iter().all(|hit| hit.triangle == NO_TRIANGLE), "{hits:?}");
    let any = RaySet { name: "any", rays, any_hit: true };
    assert!(tracer.occluded(context, &any).expect("hits").iter().all(|met| !met));
}

/// What is there on this device is what its traversal needs.
#[test]
fn there_is_only_what_the_traversal_needs() {
    let scene = builtin("cornell").expect("a built-in scene");
    let accel = Accel::build(&scene).expect("a BVH");
    let on = |context: &Context| {
        DeviceScene::new(context, &scene, &accel, SceneFeatures::of(&scene)).expect("a scene on the device")
    };
    let compute = Context::new(&DeviceChoice::Auto).expect("a device");
    assert!(!compute.ray_queries());
    let by_kernels = on(&compute);
    assert_eq!(by_kernels.traversal(), Traversal::Compute);
    assert!(by_kernels.buffers.bindable("scene_structure").is_err());
    // Software devices are not even asked.
    let auto = Context::tracing(&DeviceChoice::Auto, Traversal::Auto).expect("a device");
    assert!(!(auto.is_cpu() && auto.ray_queries()));
    let Some(context) = gpu::hardware() else { return };
    let by_hardware = on(context);
    assert_eq!(by_hardware.traversal(), Traversal::Hardware);
    assert!(by_hardware.buffers.get("nodes").is_err());
    // A trial settles what is open, and takes away what the other would need.
    let mut open = on(&tracing_by(context, Traversal::Auto));
    let choice = settle(context, &mut open, &scene, &accel).expect("a trial").expect("a choice");
    println!("{choice:?}");
    assert!(choice.reason.contains("times as fast"), "{choice:?}");
    let is_hardware = open.traversal() == Traversal::Hardware;
    assert_eq!(choice.value, if is_hardware { "hardware" } else { "compute" });
    assert_eq!(open.buffers.get("nodes").is_err(), is_hardware);
    assert_eq!(open.buffers.bindable("scene_structure").is_ok(), is_hardware);
}

/// Pictures of a scene by kernels and by ray queries: the share of values that differ, and by how much the means do.
fn pictures(context: &Context, scene: &Scene, options: &RenderOptions) -> (f64, f64) {
    let compute = tracing_by(context, Traversal::Compute);
    let [a, b] = [&compute, context].map(|context| {
        let shot = try_render_on(context, scene, options.clone()).expect("a picture");
        let expected =
            if context.traversal == Traversal::Hardware { Traversal::Hardware } else { Traversal::Compute };
        assert_eq!(shot.report.traversal, expected);
        shot.picture
    });
    let (share, mean) = difference(&[a, b]);
    println!("{}, {}: {share:.5} differ, means by {mean:.1e}", scene.name, options.method.name());
    (share, mean)
}

/// The same numbers decide which masked and blended surfaces are there, and whose backs are.
#[test]
fn n29_pictures_with_holes_are_the_same() {
    let Some(context) = gpu::hardware() else { return };
    let mut backs = house(grey(0.8));
    backs.cull_backs();
    backs.name = "backs".into();
    let holes = |alpha_mode| textured(Material { alpha_mode, ..grey(0.7) });
    let [mut masked, mut blended] = [AlphaMode::Mask { cutoff: 0.5 }, AlphaMode::Blend]
        .map(|alpha_mode| room(pebble(), holes(alpha_mode), oblique));
    (masked.name, blended.name) = ("masked".into(), "blended".into());
    let mut lamp = lamp_of(AlphaMode::Blend, 0.25, [255, 100]);
    lamp.cameras = vec![shapes::looking_at("lamp", DVec3::new(0.5, 0.2, 2.0), DVec3::Y * 0.5, 45.0)];
    lamp.name = "lamp".into();
    let options = options([32, 32], 8);
    for scene in [backs, masked, blended, lamp] {
        let features = SceneFeatures::of(&scene);
        assert!(features.alpha || features.culling);
        let (share, mean) = pictures(context, &scene, &options);
        assert!(share <= 0.002 && mean.abs() < 1e-3, "{}: {share} {mean:e}", scene.name);
    }
}

/// All kernels that trace: of camera and light paths, of connections to light vertices, to the camera and to records.
#[test]
fn n29_pictures_by_all_kinds_of_rays_are_the_same() {
    let Some(context) = gpu::hardware() else { return };
    let scene = builtin("cornell").expect("a built-in scene");
    let connections = Connections::even(2);
    for method in [
        Method::Path,
        Method::LvcBpt(LvcBpt { light_paths: Some(200), connections, light_tracing: true }),
        Method::PcBpt(PcBpt { light_paths: Some(40), ..PcBpt::default() }),
    ] {
        let (share, mean) = pictures(context, &scene, &RenderOptions { method, ..options([32, 32], 8) });
        assert!(share <= 0.01 && mean.abs() < 1e-3, "{}: {share} {mean:e}", method.name());
    }
}

/// Closed forms by ray queries alone, and the same picture each time.
#[test]
fn n29_ray_queries_meet_closed_forms() {
    let Some(context) = gpu::hardware() else { return };
    let options = options([16, 16], 256);
    let sphere = closed::furnace_sphere(0.5, 1.0, 3);
    let render = || try_render_on(context, &sphere, options.clone()).expect("a picture");
    let shot: Shot = render();
    shot.channel(0).assert_mean("furnace", 2.0, 1e-2);
    assert_same(&render().picture, &shot.picture, "the same seed");
}

/// Files name what traced; a render goes on by its own, portions of both make one picture.
#[test]
fn r06_a_render_goes_on_by_its_own_traversal() {
    let Some(context) = gpu::hardware() else { return };
    let compute = tracing_by(context, Traversal::Compute);
    let scene = builtin("cornell").expect("a built-in scene");
    let options = options([16, 16], 64);
    let folder = tempfile::tempdir().expect("a folder");
    let portion = |context: &Context, first: u32| {
        let end = first + 64;
        let budget = Budget { samples: Some(end), ..Budget::default() };
        let options = RenderOptions { budget, ..options.clone() };
        let keeping = keeping(&scene, &options, Some(end));
        let mut renderer = Renderer::new(context, &scene, options).expect("a renderer");
        renderer.begin_at(first);
        renderer.run(|_| false).expect("a render");
        let saved = renderer.saved(&keeping, Vec::new()).expect("a state");
        let path = folder.path().join(format!("{first}.part"));
        saved.save(&path).expect("a file");
        (path, saved, keeping)
    };
    let (first, by_hardware, keeping) = portion(context, 0);
    let (second, by_kernels, _) = portion(&compute, 64);
    assert_eq!(maker(&by_hardware.header.devices[0]).1, Traversal::Hardware);
    assert_eq!(maker(&by_kernels.header.devices[0]).1, Traversal::Compute);
    let said = |(name, value): &(String, Attribute)| {
        name == "device" && *value == Attribute::Text(by_hardware.header.devices[0].clone())
    };
    assert!(by_hardware.header.metadata.iter().any(said), "{:?}", by_hardware.header.metadata);
    take_up(&first, &by_hardware, &keeping, &mut options.clone()).expect("the same picture");
    let go_on = |context: &Context| {
        let mut renderer = Renderer::new(context, &scene, options.clone()).expect("a renderer");
        renderer.go_on_from(&first, by_hardware.clone())
    };
    go_on(context).expect("the same traversal");
    let refused = go_on(&compute).expect_err("another traversal").to_string();
    assert!(refused.contains("rays were traced by hardware there, by kernels here"), "{refused}");
    let Merged { saved, .. } = merge(&[first, second], None, false).expect("one picture");
    assert_eq!(saved.header.devices.len(), 2);
}
