//! The same seed gives the same picture, bit for bit, however the work was cut (N-19).

use halfway::film::{Picture, Region};
use halfway::integrator::{LightTracing, Method, View};
use halfway::render::{Budget, RenderOptions, Renderer};
use halfway::scene::Scene;
use halfway::scene::builtin::builtin;

use crate::gpu;

fn options(width: u32, height: u32, samples: u32) -> RenderOptions {
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    RenderOptions {
        view: View { width, height, ..View::default() },
        budget,
        first_hit_layers: true,
        ..RenderOptions::default()
    }
}

fn render(scene: &Scene, options: RenderOptions) -> Picture {
    let mut renderer = Renderer::new(gpu::context(), scene, options).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    renderer.picture().expect("a picture")
}

/// Every channel of a picture by its full name, as bits.
fn channels(picture: &Picture) -> Vec<(String, Vec<u32>)> {
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
    let rgb = (0..3).map(|c| {
        let values: Vec<f32> = picture.rgb.iter().map(|rgb| rgb[c]).collect();
        (["R", "G", "B"][c].to_string(), bits(&values))
    });
    let layers = picture.layers.iter().flat_map(|layer| {
        layer.channels.iter().map(move |(name, values)| (layer.full_name(name), bits(values)))
    });
    rgb.chain(layers).collect()
}

#[track_caller]
pub fn assert_same(found: &Picture, expected: &Picture, what: &str) {
    assert_eq!((found.width, found.height), (expected.width, expected.height));
    for ((name, found), (_, expected)) in channels(found).iter().zip(channels(expected)) {
        let differing = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "{what}: {differing} of {} pixels differ in {name}", found.len());
    }
}

/// The part of a picture.
fn part(picture: &Picture, region: &Region) -> Picture {
    let cut = |index: u32| {
        let (column, row) = (index % region.width, index / region.width);
        ((region.y + row * region.stride) * picture.width + region.x + column * region.stride) as usize
    };
    let mut cropped = picture.clone();
    (cropped.width, cropped.height) = (region.width, region.height);
    cropped.rgb = (0..region.pixels()).map(|index| picture.rgb[cut(index)]).collect();
    for (_, values) in cropped.layers.iter_mut().flat_map(|layer| &mut layer.channels) {
        *values = (0..region.pixels()).map(|index| values[cut(index)]).collect();
    }
    cropped
}

/// Between them they have every kind of light, textures, glass, and rough lobes.
fn scenes() -> [Scene; 2] {
    ["spheres", "three-lights"].map(|name| builtin(name).expect("a built-in scene"))
}

#[test]
fn n19_the_same_seed_gives_the_same_picture() {
    for scene in scenes() {
        let first = render(&scene, options(40, 30, 8));
        assert_same(&render(&scene, options(40, 30, 8)), &first, &scene.name);
        let other = render(
            &scene,
            RenderOptions { view: View { seed: 1, ..options(40, 30, 8).view }, ..options(40, 30, 8) },
        );
        assert!(channels(&other) != channels(&first), "{}: the seed does nothing", scene.name);
    }
}

#[test]
fn n19_a_crop_is_a_part_of_the_whole() {
    for scene in scenes() {
        let whole = render(&scene, options(40, 30, 8));
        for region in [Region::new(7, 11, 13, 9), Region::new(39, 29, 1, 1)] {
            let crop = render(
                &scene,
                RenderOptions {
                    view: View { crop: Some(region), ..options(40, 30, 8).view },
                    ..options(40, 30, 8)
                },
            );
            assert_same(&crop, &part(&whole, &region), &format!("{} {region:?}", scene.name));
        }
    }
}

/// Some of a picture's pixels, from the eye's paths and from the lights'.
#[test]
fn n19_a_lattice_is_a_part_of_the_whole() {
    let lattice = Region::lattice(40, 30, 4);
    assert_eq!(lattice, Region { x: 2, y: 2, width: 10, height: 7, stride: 4 });
    assert_eq!(lattice.hull(), Region::new(2, 2, 37, 25));
    assert_eq!(Region::lattice(40, 30, 1), Region::whole(40, 30));
    assert_eq!(Region::lattice(3, 1, 8), Region { x: 2, y: 0, width: 1, height: 1, stride: 8 });
    let scene = builtin("three-lights").expect("a built-in scene");
    for method in [Method::Path, Method::Light(LightTracing { light_paths: Some(2000) })] {
        let options =
            RenderOptions { method, first_hit_layers: method == Method::Path, ..options(40, 30, 8) };
        let whole = render(&scene, options.clone());
        let found =
            render(&scene, RenderOptions { view: View { crop: Some(lattice), ..options.view }, ..options });
        let expected = part(&whole, &lattice);
        assert_same(&found, &expected, method.name());
        assert_eq!(whole.part(&lattice).rgb, expected.rgb);
        assert!(expected.rgb.iter().filter(|rgb| rgb[0] > 0.0).count() > 40, "{}: too dark", method.name());
    }
}

/// More pixels than a batch holds on a software device: the batches are cut between pixels.
#[test]
fn n19_batches_of_pixels_do_not_show() {
    let scene = builtin("cornell").expect("a built-in scene");
    let options = RenderOptions {
        view: View { max_depth: Some(3), ..options(1030, 256, 2).view },
        first_hit_layers: false,
        ..options(1030, 256, 2)
    };
    let whole = render(&scene, options.clone());
    // Around pixel 262144, where the first batch of 2^18 paths ends.
    for region in [Region::new(0, 250, 1030, 6), Region::new(500, 253, 300, 3)] {
        let crop = render(
            &scene,
            RenderOptions { view: View { crop: Some(region), ..options.clone().view }, ..options.clone() },
        );
        assert_same(&crop, &part(&whole, &region), &format!("{region:?}"));
    }
}

/// A render that is interrupted and taken up again ends where the uninterrupted one does.
#[test]
fn n19_runs_can_be_continued() {
    let scene = builtin("cornell").expect("a built-in scene");
    let options = RenderOptions { first_hit_layers: false, ..options(24, 24, 100) };
    let whole = render(&scene, options.clone());
    for stops in [[20, 64], [63, 65]] {
        let mut renderer = Renderer::new(gpu::context(), &scene, options.clone()).expect("a renderer");
        for stop in stops {
            renderer.run(|progress| progress.samples >= stop).expect("a render");
        }
        renderer.run(|_| false).expect("a render");
        assert_same(&renderer.picture().expect("a picture"), &whole, &format!("stops at {stops:?}"));
    }
}
