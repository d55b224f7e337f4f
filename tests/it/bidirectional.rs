//! The bidirectional integrators against closed forms and the path tracer (C-05, C-08, C-11, C-12, C-14, N-10), and
//! what only they can get wrong.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use glam::{DVec3, Vec3};
use halfway::integrator::{
    Bdpt, Connections, LightTracing, LvcBpt, Method, PcBpt, RecordWeights, RisBpt, Strategy, View,
};
use halfway::render::{RenderOptions, Renderer};
use halfway::scene::builtin::{builtin, closed, shapes};
use halfway::scene::{Material, Mesh, PunctualLight, Scene};

use crate::closed_forms::pipe_of_mirrors;
use crate::determinism::assert_same;
use crate::gpu;
use crate::judge::{grey, horizontal, lamp, scene};
use crate::shots::{options, render};
use crate::stats::{Moments, assert_equal_tiles, tile_means};

const BDPT: Method = Method::Bdpt(Bdpt { light_tracing: false });
const BDPT_T1: Method = Method::Bdpt(Bdpt { light_tracing: true });
const LIGHT: Method = Method::Light(LightTracing { light_paths: None });

fn lvcbpt(light_paths: u32, connections: u32, light_tracing: bool) -> Method {
    Method::LvcBpt(LvcBpt {
        light_paths: Some(light_paths),
        connections: Connections::even(connections),
        light_tracing,
    })
}

pub fn shown(name: &str) -> Scene {
    builtin(name).expect("a built-in scene")
}

/// Pictures from different seeds: eye and light paths are new in each, and what pixels share is in the spread of
/// the means.
pub fn renders(
    scene: &Scene,
    options: &RenderOptions,
    seeds: impl IntoIterator<Item = u64>,
) -> Vec<Vec<DVec3>> {
    let mut renderer = Renderer::new(gpu::context(), scene, options.clone()).expect("a renderer");
    renders_of(scene, &mut renderer, options, seeds)
}

/// The same of a renderer that was made of the scene with these options.
fn renders_of(
    scene: &Scene,
    renderer: &mut Renderer,
    options: &RenderOptions,
    seeds: impl IntoIterator<Item = u64>,
) -> Vec<Vec<DVec3>> {
    let pictures = seeds.into_iter().map(|seed| {
        renderer.restart(seed, options.strategy).expect("a restart");
        renderer.run(|_| false).expect("a render");
        let picture = renderer.picture().expect("a picture");
        assert_eq!(renderer.report().expect("a report").non_finite, 0, "{}, seed {seed}", scene.name);
        picture.rgb.iter().map(|&rgb| Vec3::from(rgb).as_dvec3()).collect()
    });
    pictures.collect()
}

/// The Cornell box by path tracing, 16 pictures of 128 samples per pixel, which several tests compare with.
pub fn cornell_by_path() -> &'static [Vec<DVec3>] {
    static PICTURES: OnceLock<Vec<Vec<DVec3>>> = OnceLock::new();
    PICTURES.get_or_init(|| {
        let scene = builtin("cornell").expect("a built-in scene");
        renders(&scene, &options(SIZE, 128), 100..116)
    })
}

pub fn mean(picture: &[DVec3]) -> f64 {
    picture.iter().map(|pixel| pixel.element_sum() / 3.0).sum::<f64>() / picture.len() as f64
}

/// Radiance after 0, 1, ... scatterings in the picture's mean: see [`closed::plates`].
const PLATES: [f64; 5] = [1.0, 0.099_912_448, 0.010_113_269, 0.001_024_130, 0.000_103_711];

fn plates_options(method: Method) -> RenderOptions {
    RenderOptions {
        view: View { max_depth: Some(5), ..options([64, 64], 4).view },
        method,
        camera: 1,
        ..options([64, 64], 4)
    }
}

/// Every way to find a path, on its own: any factor that is wrong in a geometry term, a density, the camera's
/// importance or the scale of a splat shows.
#[test]
fn c05_every_strategy_alone_is_right() {
    assert_strategies_alone_are_right(BDPT_T1, 5, 12);
    assert_strategies_alone_are_right(lvcbpt(4096, 2, true), 4, 12);
}

/// The strategies of paths of up to `longest` edges, from so many seeds.
pub fn assert_strategies_alone_are_right(method: Method, longest: u32, seeds: u64) {
    let mut renderer =
        Renderer::new(gpu::context(), &shown("plates"), plates_options(method)).expect("a renderer");
    for length in 1..=longest {
        for s in 0..=length {
            let t = length + 1 - s;
            if s == 1 && t == 1 {
                continue;
            }
            let strategy = Some(Strategy { s, t, weighted: false });
            let runs: Moments = (0..seeds)
                .map(|seed| {
                    renderer.restart(seed, strategy).expect("a restart");
                    renderer.run(|_| false).expect("a render");
                    let picture = renderer.picture().expect("a picture");
                    picture.rgb.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / 4096.0
                })
                .collect();
            let expected = PLATES[length as usize - 1];
            let what = format!("{}, s = {s}, t = {t}", method.name());
            println!("{what}: {:.5} +- {:.5} of it", runs.mean / expected, runs.standard_error() / expected);
            runs.assert_mean(&what, expected, [1e-5, 0.01, 0.04, 0.12, 0.4][length as usize - 1]);
        }
    }
}

/// The weighted pictures of all strategies are the picture (C-14).
#[test]
fn c14_strategies_add_up() {
    let records = PcBpt { light_paths: Some(20), light_tracing: true, ..PcBpt::default() };
    let risbpt = |weights| Method::RisBpt(RisBpt { records, weights });
    let [nabata, simple] = [RecordWeights::Nabata, RecordWeights::Simple].map(risbpt);
    for method in [BDPT_T1, BDPT, lvcbpt(100, 3, true), nabata, simple] {
        let options = RenderOptions {
            view: View { max_depth: Some(4), ..options([16, 12], 8).view },
            method,
            ..options([16, 12], 8)
        };
        let mut renderer =
            Renderer::new(gpu::context(), &shown("three-lights"), options).expect("a renderer");
        let mut picture = |strategy| -> Vec<Vec3> {
            renderer.restart(3, strategy).expect("a restart");
            renderer.run(|_| false).expect("a render");
            renderer.picture().expect("a picture").rgb.iter().map(|&rgb| rgb.into()).collect()
        };
        let whole = picture(None);
        let mut sum = vec![DVec3::ZERO; whole.len()];
        for length in 1..=4u32 {
            for s in 0..=length {
                let strategy = Some(Strategy { s, t: length + 1 - s, weighted: true });
                for (sum, pixel) in sum.iter_mut().zip(picture(strategy)) {
                    *sum += pixel.as_dvec3();
                }
            }
        }
        for (sum, whole) in sum.iter().zip(&whole) {
            let whole = whole.as_dvec3();
            assert!((*sum - whole).abs().max_element() <= 1e-5 * whole.max_element(), "{sum} is not {whole}");
        }
    }
}

/// Pictures that are compared.
pub const SIZE: [u32; 2] = [48, 48];

/// The path tracer's pictures of a scene, from 10 seeds, made once for all tests.
fn path_renders(scene: &Scene) -> Arc<Vec<Vec<DVec3>>> {
    static KNOWN: Mutex<BTreeMap<String, Arc<Vec<Vec<DVec3>>>>> = Mutex::new(BTreeMap::new());
    let mut known = KNOWN.lock().expect("no test panics in here");
    let made = || Arc::new(renders(scene, &options(SIZE, 32), 100..110));
    Arc::clone(known.entry(scene.name.clone()).or_insert_with(made))
}

/// Tile means of independent renders of two methods, by Welch's test over all tiles.
#[track_caller]
pub fn assert_same_as_path(scene: &Scene, method: Method, samples: u32) {
    assert_options_same_as_path(scene, &RenderOptions { method, ..options(SIZE, samples) });
}

/// As [`assert_same_as_path`]; the options are for pictures of [`SIZE`].
#[track_caller]
pub fn assert_options_same_as_path(scene: &Scene, options: &RenderOptions) {
    let mut renderer = Renderer::new(gpu::context(), scene, options.clone()).expect("a renderer");
    assert_renderer_same_as_path(scene, &mut renderer, options);
}

/// The same, of such a renderer.
#[track_caller]
pub fn assert_renderer_same_as_path(scene: &Scene, renderer: &mut Renderer, options: &RenderOptions) {
    let method = options.method;
    let path = path_renders(scene);
    let found = renders_of(scene, renderer, options, 0..10);
    let tiles = |pictures: &[Vec<DVec3>]| -> Vec<Vec<f64>> {
        pictures.iter().map(|picture| tile_means(picture, SIZE, 12)).collect()
    };
    let [a, b]: [Moments; 2] = [&found, &*path].map(|pictures| pictures.iter().map(|p| mean(p)).collect());
    let error = a.standard_error().hypot(b.standard_error()) / b.mean;
    println!("{}, {method:?}: {:.5} +- {error:.5} of path", scene.name, a.mean / b.mean);
    assert!((a.mean / b.mean - 1.0).abs() < 5.0 * error, "{}: {method:?}", scene.name);
    assert_equal_tiles(&format!("{}, {method:?}", scene.name), &tiles(&found), &tiles(&path));
}

#[test]
fn c08_bdpt_agrees_with_path() {
    for name in ["cornell", "three-lights"] {
        assert_same_as_path(&shown(name), BDPT, 4);
    }
}

#[test]
fn c08_bdpt_with_light_tracing_agrees_with_path() {
    for name in ["door", "glass-slab"] {
        assert_same_as_path(&shown(name), BDPT_T1, 4);
    }
}

#[test]
fn c08_lvcbpt_agrees_with_path() {
    assert_same_as_path(&shown("bumpy-plane"), lvcbpt(600, 2, false), 4);
}

#[test]
fn c08_lvcbpt_with_light_tracing_agrees_with_path() {
    for name in ["cornell", "three-lights", "spheres"] {
        assert_same_as_path(&shown(name), lvcbpt(1200, 1, true), 4);
    }
}

/// Roulette is in all densities: whatever its cap, pictures differ by noise alone.
#[test]
fn c08_any_roulette_agrees_with_path() {
    for roulette_cap in [0.02, 1.0] {
        let method = lvcbpt(600, 2, true);
        let options = RenderOptions {
            view: View { roulette_cap, ..options(SIZE, 4).view },
            method,
            ..options(SIZE, 4)
        };
        assert_options_same_as_path(&shown("cornell"), &options);
    }
}

/// Rows of mirrors longer than roulette passes like any others: weights take eye paths and light paths for as likely to end
/// there.
#[test]
fn c08_a_pipe_of_mirrors_agrees_with_path() {
    for method in [BDPT_T1, lvcbpt(600, 1, true)] {
        assert_same_as_path(&pipe_of_mirrors(40.0), method, 4);
    }
}

/// Light tracing alone: only it sees the light's side of the BSDF everywhere. Bent normals (C-11) and several kinds
/// of light.
#[test]
fn c11_light_tracing_agrees_with_path() {
    for name in ["bumpy-plane", "cornell"] {
        assert_same_as_path(&shown(name), LIGHT, 16);
    }
    // Half of this scene's lights are delta lights, and a sky.
    assert_same_as_path(&shown("three-lights"), LIGHT, 64);
}

/// Light that goes on from a bent normal: the ceiling is lit by the floor alone, whose normals lean.
#[test]
fn c11_light_goes_on_from_bent_normals() {
    let leaning = Mesh { normals: Some(vec![Vec3::new(0.6, 0.8, 0.0); 4]), ..horizontal(2.0, 0.0, true) };
    let mut scene = scene([
        (grey(0.8), leaning),
        (grey(0.8), horizontal(2.0, 1.0, false)),
        (lamp(4.0), horizontal(0.8, 0.5, false)),
    ]);
    scene.name = "leaning floor".into();
    scene.cameras.push(shapes::looking_at("up", DVec3::new(0.9, 0.3, 0.9), DVec3::Y, 70.0));
    assert_same_as_path(&scene, LIGHT, 32);
}

/// A spot alone, from its own side: a density of its cone that is off makes it brighter or darker.
#[test]
fn c11_light_of_a_spot_agrees_with_path() {
    let mut scene = scene([(grey(0.5), horizontal(2.0, 0.0, true))]);
    scene.name = "spot".into();
    scene.lights.push(PunctualLight {
        name: "spot".into(),
        kind: halfway::scene::LightKind::Spot { inner: 0.2, outer: 0.5 },
        intensity: Vec3::ONE,
        position: DVec3::Y,
        direction: Vec3::NEG_Y,
    });
    scene.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 2.0, 0.5), DVec3::ZERO, 30.0));
    assert_same_as_path(&scene, LIGHT, 16);
}

/// A rough slab of glass: light is refracted twice on its way, and power is not squeezed as radiance is (C-12).
#[test]
fn c12_light_through_rough_glass() {
    let glass = Material {
        metallic: 0.0,
        transmission: 1.0,
        volume: true,
        roughness: 0.5,
        ior: 1.6,
        base_color: Vec3::splat(0.9),
        ..Material::default()
    };
    let slab = shapes::cuboid(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.4));
    let back = shapes::quad(DVec3::new(-1.5, -1.5, -0.6), DVec3::X * 3.0, DVec3::Y * 3.0);
    let mut scene = scene([(glass.clone(), slab.clone()), (lamp(1.0), back)]);
    scene.name = "rough slab".into();
    scene.cameras.push(shapes::looking_at("front", DVec3::Z * 3.0, DVec3::ZERO, 20.0));
    assert_same_as_path(&scene, LIGHT, 64);
    // From inside the glass.
    scene.name = "inside rough glass".into();
    scene.cameras =
        vec![shapes::looking_at("inside", DVec3::new(0.1, 0.0, 0.3), DVec3::new(0.1, 0.0, -1.0), 60.0)];
    assert_same_as_path(&scene, BDPT_T1, 8);
}

/// A lamp between a floor and a ceiling that shines on both.
pub fn double_sided_lamp() -> Scene {
    let both = Material { double_sided: true, ..lamp(2.0) };
    let floor = Material { double_sided: true, ..grey(0.6) };
    let mut scene = scene([
        (both, horizontal(0.6, 0.0, true)),
        (grey(0.7), horizontal(3.0, -0.6, true)),
        (floor, horizontal(3.0, 0.9, true)),
    ]);
    scene.name = "double-sided lamp".into();
    scene.cameras.push(shapes::looking_at("side", DVec3::new(0.2, 0.25, 2.5), DVec3::ZERO, 50.0));
    scene
}

#[test]
fn c08_a_double_sided_lamp_agrees_with_path() {
    assert_same_as_path(&double_sided_lamp(), LIGHT, 32);
    assert_same_as_path(&double_sided_lamp(), BDPT_T1, 4);
    assert_same_as_path(&double_sided_lamp(), lvcbpt(1200, 1, true), 4);
}

/// A picture that light paths alone make is as bright at its border as in its middle.
#[test]
fn light_tracing_fills_the_border() {
    let options = RenderOptions { method: LIGHT, ..options(SIZE, 16) };
    let pictures = renders(&closed::furnace_box(0.5, 1.0), &options, 0..48);
    let border = |index: usize| {
        let (x, y) = (index % 48, index / 48);
        x == 0 || y == 0 || x == 47 || y == 47
    };
    for (what, at_border) in [("border", true), ("middle", false)] {
        let part: Moments = pictures
            .iter()
            .map(|picture| {
                let pixels = picture.iter().enumerate().filter(|(index, _)| border(*index) == at_border);
                let pixels: Moments = pixels.map(|(_, pixel)| pixel.x).collect();
                pixels.mean
            })
            .collect();
        part.assert_mean(what, 2.0, 1e-2);
    }
}

/// Plates that come ever closer: steps off a surface and distances along rays are far below 2^-24 of the plates' size,
/// which is the rounding of positions. There, weights of connections to the camera see that rounding; beyond it nothing is
/// right any more, but all is finite.
#[test]
fn n10_plates_that_almost_touch() {
    for exponent in [1, 8, 12, 16, 20, 24, 30] {
        let distance = 2f64.powi(-exponent);
        let mut scene = shown("plates");
        for (mesh, side) in scene.meshes.iter_mut().zip([-0.5, 0.5]) {
            mesh.positions.iter_mut().for_each(|position| position.z = side * distance);
        }
        for method in [Method::Path, BDPT_T1, lvcbpt(300, 2, false)] {
            let pictures =
                renders(&scene, &RenderOptions { camera: 1, method, ..options([32, 32], 4) }, 0..8);
            let means: Moments = pictures.iter().map(|picture| mean(picture)).collect();
            println!("2^-{exponent}, {}: {:.5} +- {:.5}", method.name(), means.mean, means.standard_error());
            let is_resolved = matches!(exponent, 8..=12 | 20) || (exponent == 24 && method != BDPT_T1);
            if is_resolved {
                // Light leaves by the edges: a share of about twice the distance.
                let open = 4.0 * distance;
                assert!((means.mean - 2.0).abs() < 5.0 * means.standard_error() + open, "2^-{exponent}");
            }
        }
    }
}

/// The cache grows to what it has to hold, and nothing is lost by it.
#[test]
fn cache_grows() {
    // A light path has about 20 vertices here; the cache begins with room for a few.
    let scene = closed::furnace_box(0.95, 1.0);
    let options = RenderOptions { method: lvcbpt(5_000, 2, false), ..options([8, 8], 16) };
    let shot = render(&scene, options.clone());
    let a_path = shot.report.rays.light_vertices as f64 / (16.0 * 5_000.0);
    println!("{a_path} vertices a light path");
    assert!((15.0..25.0).contains(&a_path));
    let means: Moments = renders(&scene, &options, 0..8).iter().map(|picture| mean(picture)).collect();
    means.assert_mean("furnace", 20.0, 1e-2);
}

/// The least of everything: one light path, one connection, one pixel, one surface, no light at all.
#[test]
fn r07_smallest_settings() {
    let methods = [BDPT, BDPT_T1, LIGHT, lvcbpt(1, 1, false), lvcbpt(1, 1, true)];
    for method in methods {
        render(&shown("three-lights"), RenderOptions { method, ..options([1, 1], 4) });
        let mut dark = shown("cornell");
        dark.materials.iter_mut().for_each(|material| material.emission = Vec3::ZERO);
        let picture = render(&dark, RenderOptions { method, ..options([4, 4], 4) }).picture;
        assert!(picture.rgb.iter().flatten().all(|&value| value == 0.0), "{method:?}");
        for max_depth in [1, 2] {
            let options = RenderOptions {
                view: View { max_depth: Some(max_depth), ..options([8, 8], 64).view },
                method,
                ..options([8, 8], 64)
            };
            let shot = render(&closed::furnace_box(0.5, 1.0), options);
            if method != LIGHT {
                let expected = [1.0, 1.5][max_depth as usize - 1];
                let mean = shot.channel(0).mean;
                assert!((mean - expected).abs() < 0.2, "{method:?}, depth {max_depth}: {mean}");
            }
        }
    }
    // One light path a picture is enough, if there are many pictures.
    assert_same_as_path(&shown("cornell"), lvcbpt(1, 1, false), 64);
}

/// The same seed, the same picture, although the queues and the cache fill in another order every time.
#[test]
fn n19_bidirectional_renders_repeat() {
    for method in [BDPT_T1, lvcbpt(200, 3, true), LIGHT] {
        let scene = shown("three-lights");
        let once = || {
            render(
                &scene,
                RenderOptions {
                    view: View { seed: 9, ..options([24, 16], 8).view },
                    method,
                    ..options([24, 16], 8)
                },
            )
            .picture
            .rgb
        };
        assert_eq!(once(), once(), "{method:?}");
    }
}

/// Light paths stay for all samples that share them, and are traced once: pictures and counts do not depend on how many
/// samples are rendered at once.
#[test]
fn n19_samples_may_be_rendered_one_by_one() {
    let scene = shown("three-lights");
    for method in [BDPT_T1, lvcbpt(200, 3, true), LIGHT] {
        let options = RenderOptions { method, ..options([24, 16], 19) };
        let whole = render(&scene, options.clone());
        let mut renderer = Renderer::new(gpu::context(), &scene, options).expect("a renderer");
        for samples in [1, 1, 3, 2, 1, 5, 3, 3] {
            assert_eq!(renderer.step(samples).expect("samples"), samples);
        }
        let picture = renderer.picture().expect("a picture");
        assert_same(&picture, &whole.picture, method.name());
        assert_eq!(renderer.report().expect("a report").rays, whole.report.rays, "{}", method.name());
    }
}

/// Counts of rays and vertices are those of the paths: exact, and the same every time.
#[test]
fn rays_are_counted() {
    let mut floor = scene([(grey(0.5), horizontal(1.0, 0.0, true))]);
    floor.lights.push(PunctualLight {
        name: "sun".into(),
        kind: halfway::scene::LightKind::Directional,
        intensity: Vec3::ONE,
        position: DVec3::ZERO,
        direction: Vec3::NEG_Y,
    });
    floor.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 2.0, 0.5), DVec3::ZERO, 20.0));
    let options = RenderOptions {
        view: View { max_depth: Some(3), ..options([8, 8], 4).view },
        method: lvcbpt(50, 2, false),
        ..options([8, 8], 4)
    };
    // Four samples have the light paths of a group.
    let rays = render(&floor, options).report.rays;
    // Each light path stores the sun, and sends one ray; those that meet the floor store that and end there: there
    // is no room for another vertex but an eye's. Each eye path sees the floor and may bounce once.
    assert_eq!(rays.light_closest_hit, 400);
    assert!((400..=800).contains(&rays.light_vertices));
    let eye = rays.closest_hit - rays.light_closest_hit;
    assert!((256..=512).contains(&eye), "{eye}");
    // Two connections of each eye vertex; the floor does not see itself, so only those to the sun are tested.
    let tested = rays.occlusion - rays.light_occlusion;
    assert!(rays.light_occlusion == 0 && tested <= 512 && tested > 100, "{tested}");
}
