//! Devices that bind little at once: what is larger lies in pages, and nothing of that shows.

use halfway::device::Context;
use halfway::film::Picture;
use halfway::integrator::{Bdpt, LightTracing, LvcBpt, Method, View};
use halfway::render::{Budget, PictureMemory, RenderError, RenderOptions, Renderer};
use halfway::scene::Scene;
use halfway::scene::builtin::{builtin, closed};

use crate::determinism::assert_same;
use crate::gpu;

/// A film of 64x48 pixels takes 144 KiB.
const SIZE: (u32, u32) = (64, 48);
const BINDING: u64 = 56 << 10;

fn options(method: Method) -> RenderOptions {
    RenderOptions {
        view: View { width: SIZE.0, height: SIZE.1, max_depth: Some(12), ..View::default() },
        budget: Budget { samples: Some(9), ..Budget::default() },
        method,
        first_hit_layers: true,
        ..RenderOptions::default()
    }
}

fn render(context: &Context, scene: &Scene, method: Method) -> (Renderer, Picture) {
    let mut renderer = Renderer::new(context, scene, options(method)).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    let picture = renderer.picture().expect("a picture");
    (renderer, picture)
}

/// Film, layers and what light paths bring to the camera in three pages.
#[test]
fn r08_a_picture_larger_than_a_binding_is_the_same() {
    let scene = builtin("cornell").expect("a built-in scene");
    for method in [Method::Path, Method::Light(LightTracing::default())] {
        let paged = assert_pages_do_not_show(&scene, method);
        assert!(paged.rgb.iter().filter(|rgb| rgb[1] > 0.0).count() > 1000, "{} is dark", method.name());
    }
}

/// Light paths of a batch of bidirectional path tracing that no buffer holds: batches are halved.
#[test]
fn r08_light_paths_that_find_no_room_are_traced_in_parts() {
    assert_pages_do_not_show(&closed::furnace_box(0.95, 1.0), Method::Bdpt(Bdpt { light_tracing: true }));
}

/// Light paths that one buffer cannot hold are fewer, and that is said; the picture is as bright.
#[test]
fn r08_a_small_cache_has_fewer_light_paths() {
    let scene = builtin("cornell").expect("a built-in scene");
    let method = Method::LvcBpt(LvcBpt::default());
    let small = gpu::context().with_small_bindings(BINDING);
    let means = [gpu::context(), &small].map(|context| {
        let (renderer, picture) = render(context, &scene, method);
        let choices = renderer.report().expect("a report").choices;
        let paths = choices.iter().find(|choice| choice.what == "light paths at a time").expect("a choice");
        (paths.reason.contains("one buffer has room for"), picture.rgb.iter().map(|rgb| rgb[1]).sum::<f32>())
    });
    assert_eq!(means.map(|(capped, _)| capped), [false, true]);
    let ratio = means[1].1 / means[0].1;
    assert!((ratio - 1.0).abs() < 0.05, "{ratio} times as bright");
}

fn assert_pages_do_not_show(scene: &Scene, method: Method) -> Picture {
    let small = gpu::context().with_small_bindings(BINDING);
    let (_, whole) = render(gpu::context(), scene, method);
    let (renderer, paged) = render(&small, scene, method);
    let pages = renderer.buffers().filter(|(name, _)| name.starts_with("film page")).count();
    assert_eq!(pages, 3, "{}", method.name());
    assert!(renderer.buffers().all(|(_, buffer)| buffer.size() <= BINDING));
    let per_pixel = ["film page", "splats page", "first_hits page"];
    let found = renderer.buffers().filter(|(name, _)| per_pixel.iter().any(|kind| name.starts_with(kind)));
    let foretold = PictureMemory::of(&options(method)).device;
    assert_eq!(found.map(|(_, buffer)| buffer.size()).sum::<u64>(), foretold, "{}", method.name());
    assert_same(&paged, &whole, method.name());
    paged
}

/// Before the scene is built, which would take long: a picture that no memory holds.
#[test]
fn r08_a_picture_that_does_not_fit_is_refused_at_once() {
    let scene = builtin("cornell").expect("a built-in scene");
    let view = View::sized(60_000, 60_000);
    let options = RenderOptions { view, ..options(Method::Path) };
    let error = Renderer::new(gpu::context(), &scene, options).err().expect("a refusal");
    assert!(matches!(error, RenderError::PictureTooLarge { .. }), "{error}");
    assert!(error.to_string().contains("--crop"), "{error}");
}
