//! `--integrator auto`: what it chooses, and that the picture is the chosen integrator's.

use std::time::Duration;

use halfway::film::Picture;
use halfway::integrator::method::{Given, PATH, PCBPT, SPCBPT};
use halfway::integrator::{Method, View};
use halfway::render::{Automatic, Budget, Prepared, RenderOptions, TimeLimit, Uploaded, for_surfaces};
use halfway::scene::builtin::builtin;
use halfway::scene::{Filter, Image, Material, Repeated, Scene, Texture, TextureRef, Wrap};

use crate::command::Case;
use crate::gpu;
use crate::shots::{options, render};

/// 3072 pixels: a thousand samples of each are worth a pilot.
const SIZE: [u32; 2] = [64, 48];

fn scene(name: &str) -> Scene {
    builtin(name).expect("a built-in scene")
}

fn choose(scene: &Scene, options: &RenderOptions) -> Automatic {
    let uploaded = Uploaded::new(gpu::context(), scene, None).unwrap();
    Automatic::choose(&uploaded, scene, &scene.cameras[0], options).unwrap()
}

fn names(automatic: &Automatic) -> (&'static str, String) {
    let said =
        automatic.choices.iter().map(|choice| format!("{} {}: {}", choice.what, choice.value, choice.reason));
    (automatic.method.name(), said.collect::<Vec<_>>().join("; "))
}

/// Light that is hard to find is worth learning, an easy picture is not; and no clock has a say.
#[test]
fn auto_learns_where_that_pays() {
    let automatic = choose(&scene("door"), &options(SIZE, 1024));
    let (name, said) = names(&automatic);
    assert_eq!(name, "spcbpt", "{said}");
    assert!(said.contains("a pilot expects"), "{said}");
    let again = choose(&scene("door"), &options(SIZE, 1024));
    assert_eq!(automatic.choices, again.choices);
    let (name, said) = names(&choose(&scene("cornell"), &options(SIZE, 1024)));
    assert_eq!(name, "path", "{said}");
    let (name, said) = names(&choose(&scene("cornell"), &options(SIZE, 1 << 24)));
    assert_eq!(name, "path", "clean in the end: {said}");
    // An hour has room for what is learnt in seconds.
    let budget = Budget { time: Some(TimeLimit::Total(Duration::from_secs(3600))), ..Budget::default() };
    let view = View { width: 640, height: 360, ..View::default() };
    let (name, said) =
        names(&choose(&scene("door"), &RenderOptions { view, budget, ..RenderOptions::default() }));
    assert_eq!(name, "spcbpt", "{said}");
}

/// A denoised picture meets a goal sooner than the picture does: less is worth learning.
#[test]
fn auto_knows_that_a_denoised_picture_is_there_sooner() {
    let budget = Budget { error: Some(0.12), ..Budget::default() };
    for (halves, integrator) in [(false, "spcbpt"), (true, "path")] {
        let options = RenderOptions { budget, halves, ..options(SIZE, 1) };
        let (name, said) = names(&choose(&scene("door"), &options));
        assert_eq!(name, integrator, "{said}");
    }
}

/// Short renders are not held up.
#[test]
fn auto_has_no_pilot_where_time_is_short() {
    let second = Budget { time: Some(TimeLimit::Total(Duration::from_millis(900))), ..Budget::default() };
    for options in [options(SIZE, 64), RenderOptions { budget: second, ..options([640, 360], 1) }] {
        let automatic = choose(&scene("door"), &options);
        assert_eq!(names(&automatic).0, "path");
        assert_eq!(automatic.pilot, Duration::ZERO);
    }
}

#[test]
fn auto_traces_light_where_caustics_may_be() {
    let method = |light_tracing| (SPCBPT.make)(&Given { light_tracing, ..Given::default() });
    assert_eq!(Automatic::without_end(&scene("spheres")).method, method(true));
    assert_eq!(Automatic::without_end(&scene("cornell")).method, method(false));
    let mut dark = scene("cornell");
    dark.materials.iter_mut().for_each(|material| material.emission = glam::Vec3::ZERO);
    let automatic = Automatic::without_end(&dark);
    assert_eq!(automatic.method, Method::Path, "{:?}", automatic.choices);
}

/// Rough metal and glaze bring light to others as well, be they said by factors or by textures; matter of other kinds does not.
#[test]
fn auto_traces_light_where_surfaces_are_glossy() {
    let traces = |material: Material, texel: Option<[u8; 4]>| {
        let mut scene = scene("cornell");
        scene.images.push(Image {
            name: "half".into(),
            width: 2,
            height: 1,
            texels: texel.map_or(vec![], |texel| vec![[255, 255, 0, 255], texel]),
        });
        scene.textures.push(Texture { image: 0, wrap: [Wrap::Repeat; 2], filter: Filter::Nearest });
        let slot = TextureRef { texture: 0, uv_set: 0, transform: glam::Affine2::IDENTITY };
        let used = scene.meshes[0].material as usize;
        scene.materials[used] =
            Material { metallic_roughness_texture: texel.map(|_| slot), name: "it".into(), ..material };
        let (method, choice) = for_surfaces(&scene, (SPCBPT.make)(&Given::default()));
        assert_eq!(method.plan().to_camera, choice.is_some());
        choice.is_some_and(|choice| choice.reason.contains("\"it\""))
    };
    let metal = |roughness| Material { roughness, ..Material::default() };
    let glaze = |roughness| Material { metallic: 0.0, ..metal(roughness) };
    assert!(traces(metal(0.5), None) && !traces(metal(0.55), None));
    assert!(traces(glaze(0.25), None) && !traces(glaze(0.3), None));
    let glass = |roughness| Material { transmission: 1.0, ..glaze(roughness) };
    assert!(traces(glass(0.4), None) && !traces(glass(0.6), None));
    assert!(!traces(Material { specular: 0.0, ..glaze(0.1) }, None), "Lambert");
    assert!(!traces(Material { unlit: true, ..metal(0.1) }, None), "unlit");
    // G is roughness, B metal.
    assert!(traces(metal(1.0), Some([0, 100, 255, 255])) && !traces(metal(1.0), Some([0, 150, 255, 255])));
    assert!(!traces(metal(1.0), Some([0, 100, 9, 255])), "hardly any metal");
    assert!(traces(metal(0.6), Some([0, 100, 9, 255])), "a glaze");
    assert!(!traces(metal(1.0), Some([0, 0, 0, 255])), "padding");
}

/// Whoever names an integrator has light tracing by itself where caustics may be, unless told otherwise.
#[test]
fn a_named_integrator_traces_light_where_caustics_may_be() {
    let case = Case::new();
    let picture = |scene: &str, more: &str, said: bool| {
        let run = case.run(&format!("render builtin:{scene} -i lvcbpt --size 28x12 --spp 8 {more} -o a.exr"));
        run.assert(0, &[]);
        assert_eq!(run.said.contains("chosen: light tracing on"), said, "{scene} {more}: {}", run.said);
        case.picture("a.exr").rgb
    };
    let by_itself = picture("spheres", "", true);
    assert_eq!(by_itself, picture("spheres", "--light-tracing", false));
    assert_ne!(by_itself, picture("spheres", "--no-light-tracing", false));
    assert_eq!(picture("cornell", "", false), picture("cornell", "--no-light-tracing", false));
    case.refuse("render DIR/a.glb -i lvcbpt --light-tracing --no-light-tracing", &["cannot be used with"]);
    let records = (PCBPT.make)(&Given::default());
    assert_eq!(for_surfaces(&scene("spheres"), records).0, records, "its light paths are too few");
}

/// What was chosen for the scene is told beside what was chosen for the render.
#[test]
fn auto_tells_what_became_of_repeated_meshes() {
    let mut scene = scene("cornell");
    scene.repeated.push(Repeated {
        mesh: "leaf".into(),
        triangles: 10,
        places: 20_000,
        as_instances: false,
        reason: "they emit".into(),
    });
    let prepared = Prepared::automatic(gpu::context(), &scene, options(SIZE, 1)).unwrap();
    let told: Vec<&str> = prepared.report().choices.iter().map(|choice| &*choice.what).collect();
    assert_eq!(told, ["mesh", "integrator"]);
}

/// The pilot leaves no trace in the picture.
#[test]
fn n19_auto_is_bit_for_bit_what_it_chose() {
    let scene = scene("cornell");
    let options = options(SIZE, 700);
    let mut renderer =
        Prepared::automatic(gpu::context(), &scene, options.clone()).unwrap().renderer().unwrap();
    renderer.run(|_| false).unwrap();
    let report = renderer.report().unwrap();
    assert!(report.choices.iter().any(|choice| choice.what == "integrator" && choice.value == PATH.name));
    let picture: Picture = renderer.picture().unwrap();
    assert_eq!(picture, render(&scene, RenderOptions { method: Method::Path, ..options }).picture);
}

/// It is the default, says so once and before it renders, and files name the integrator that it chose.
#[test]
fn auto_is_the_default() {
    let case = Case::new();
    let run = case.run("render builtin:cornell --size 8x8 --spp 2 -o a.exr");
    run.assert(0, &["chosen: integrator path (so short a render"]);
    let places = |part| run.said.match_indices(part).map(|(at, _)| at).collect::<Vec<_>>();
    let (chosen, end) = (places("chosen: integrator"), places("2 spp in"));
    assert_eq!((chosen.len(), end.len()), (1, 1), "{}", run.said);
    assert!(chosen < end, "{}", run.said);
    case.run("render builtin:cornell --size 8x8 --spp 2 -o b.exr -i path").assert(0, &[]);
    case.run("render builtin:cornell --size 8x8 --spp 2 -o c.exr -i auto").assert(0, &[]);
    let (a, b, c) = (case.picture("a.exr"), case.picture("b.exr"), case.picture("c.exr"));
    assert_eq!(a.rgb, b.rgb);
    assert_eq!(a.rgb, c.rgb);
    assert_eq!(a.attribute("integrator"), b.attribute("integrator"));
}
