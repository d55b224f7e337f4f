//! Renders that are kept on disk and go on from there: the picture is that of a render that was never stopped, bit for bit
//! and of portions that are merged.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use halfway::film::checkpoint::SavedRender;
use halfway::film::merge::{Merged, merge};
use halfway::film::sums::{FilmSums, PixelSums};
use halfway::film::{Layer, Picture};
use halfway::integrator::{
    Bdpt, Connections, LightTracing, LvcBpt, Method, PcBpt, RecordWeights, RisBpt, SpcBpt, View,
};
use halfway::render::{Budget, Keeping, Origin, RenderOptions, Renderer, picture_of, take_up};
use halfway::scene::Scene;
use halfway::scene::builtin::builtin;
use halfway::training::{Training, When};
use rayon::prelude::*;

use crate::gpu;
use crate::random::Stream;

const SIZE: [u32; 2] = [24, 16];

fn options(method: Method, samples: u32) -> RenderOptions {
    let training = Training { when: Some(When::First), ..Training::default() }.with_rounds(1);
    RenderOptions {
        view: View::sized(SIZE[0], SIZE[1]),
        method,
        training,
        budget: Budget { samples: Some(samples), ..Budget::default() },
        ..RenderOptions::default()
    }
}

pub fn keeping(scene: &Scene, options: &RenderOptions, end: Option<u32>) -> Keeping {
    let origin = Origin {
        method: options.method,
        seed: options.view.seed,
        scene_hash: scene.content_hash(),
        device: gpu::context().describe(),
        command_line: "halfway render".into(),
    };
    let picture = picture_of(origin.scene_hash, &scene.cameras[0], options);
    Keeping { picture, origin, command: Vec::new(), folder: String::new(), end }
}

/// All that samples say of a picture, as bits.
fn bits(picture: &Picture) -> BTreeMap<String, Vec<u32>> {
    let rgb = (0..3).map(|c| (c.to_string(), picture.rgb.iter().map(|rgb| rgb[c].to_bits()).collect()));
    let layers = picture.layers.iter().flat_map(|layer| {
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
        layer.channels.iter().map(move |(name, values)| (layer.full_name(name), bits(values)))
    });
    rgb.chain(layers).collect()
}

#[track_caller]
fn assert_same(found: &Picture, expected: &Picture, what: &str) {
    assert!(bits(found) == bits(expected), "{what}: other bits");
}

/// Renders up to `stops`, one after the other, each by a renderer of its own that goes on from the last one's file.
fn in_parts(scene: &Scene, options: &RenderOptions, stops: &[u32], path: &Path) -> (Picture, Option<f64>) {
    let mut last = None;
    for stop in stops {
        let mut options = options.clone();
        let keeping = keeping(scene, &options, None);
        let saved = path.exists().then(|| SavedRender::read(path).expect("a whole file"));
        if let Some(saved) = &saved {
            take_up(path, saved, &keeping, &mut options).expect("the same render");
        }
        let mut renderer = Renderer::new(gpu::context(), scene, options).expect("a renderer");
        if let Some(saved) = saved {
            renderer.go_on_from(path, saved).expect("a place to go on from");
        }
        renderer.run(|progress| progress.samples >= *stop).expect("a render");
        renderer.saved(&keeping, Vec::new()).expect("a state").save(path).expect("a writable file");
        let report = renderer.report().expect("a report");
        assert_eq!(report.samples, renderer.samples());
        last = Some((renderer.picture().expect("a picture"), report.estimated_error));
    }
    last.expect("a stop")
}

fn whole(scene: &Scene, options: &RenderOptions) -> (Picture, Option<f64>) {
    let mut renderer = Renderer::new(gpu::context(), scene, options.clone()).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    (renderer.picture().expect("a picture"), renderer.report().expect("a report").estimated_error)
}

/// Every integrator, learning first included; stops within a group, within a block of 64 samples, and at its end.
#[test]
fn r06_a_render_goes_on_bit_for_bit() {
    let scene = builtin("cornell").expect("a built-in scene");
    let folder = tempfile::tempdir().unwrap();
    let connections = Connections::even(2);
    let records = PcBpt { light_paths: Some(50), ..PcBpt::default() };
    let [nabata, simple] = [RecordWeights::Nabata, RecordWeights::Simple]
        .map(|weights| Method::RisBpt(RisBpt { records, weights }));
    for (index, (method, stops)) in [
        (Method::Path, &[5, 72, 128][..]),
        (Method::Bdpt(Bdpt { light_tracing: true }), &[64, 128]),
        // Stops within a group, whose light paths are traced again.
        (Method::LvcBpt(LvcBpt { light_paths: None, connections, light_tracing: true }), &[5, 72, 128]),
        (Method::SpcBpt(SpcBpt { light_paths: None, connections, light_tracing: false }), &[5, 72, 128]),
        (Method::Light(LightTracing { light_paths: None }), &[64, 128]),
        // Its samples share nothing, and each is an iteration; what weights know is no sample's.
        (nabata, &[5, 20]),
        (simple, &[5, 20]),
    ]
    .into_iter()
    .enumerate()
    {
        let options = options(method, stops[stops.len() - 1]);
        let expected = whole(&scene, &options);
        let path = folder.path().join(index.to_string());
        let found = in_parts(&scene, &options, stops, &path);
        assert_same(&found.0, &expected.0, method.name());
        assert_eq!(found.1, expected.1, "{}: the estimated error", method.name());
    }
}

/// Another scene, size, setting or device is refused, with what is different.
#[test]
fn r06_another_render_is_not_gone_on_with() {
    let scene = builtin("cornell").expect("a built-in scene");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint");
    let options = options(Method::Path, 8);
    let here = keeping(&scene, &options, None);
    let mut renderer = Renderer::new(gpu::context(), &scene, options.clone()).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    let saved = renderer.saved(&here, Vec::new()).expect("a state");
    let refused = |keeping: &Keeping| {
        take_up(&path, &saved, keeping, &mut options.clone()).expect_err("another render").to_string()
    };
    for (view, phrases) in [
        (View { seed: 1, ..options.view }, ["seed 0 there, 1 here"].as_slice()),
        (View { width: 32, ..options.view }, &["size 24x16 there, 32x16 here", "part"]),
        (View { max_depth: Some(3), ..options.view }, &["maximum depth none there, 3 here"]),
    ] {
        let said = refused(&keeping(&scene, &RenderOptions { view, ..options.clone() }, None));
        phrases.iter().for_each(|phrase| assert!(said.contains(phrase), "'{phrase}' not in {said}"));
    }
    let other = builtin("spheres").expect("a built-in scene");
    assert!(refused(&keeping(&other, &options, None)).contains("scene "));
    assert!(refused(&keeping(&scene, &options, Some(64))).contains("no portion there"));
    let mut moved = scene.clone();
    moved.cameras[0].position.x += 1e-9;
    assert!(refused(&keeping(&moved, &options, None)).contains("camera "));
    let device = Origin { device: "a faster one".into(), ..here.origin.clone() };
    assert!(refused(&Keeping { origin: device, ..here }).contains("a faster one here"));
}

/// What a file holds is what was put into it, and no damaged byte is believed.
#[test]
fn r06_files_are_whole_or_refused() {
    let scene = builtin("cornell").expect("a built-in scene");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint");
    let options = options(Method::Path, 77);
    let mut renderer = Renderer::new(gpu::context(), &scene, options.clone()).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    let layers = vec![Layer {
        name: "a layer".into(),
        channels: vec![("Z".into(), (0..SIZE[0] * SIZE[1]).map(|i| i as f32).collect())],
    }];
    let mut saved = renderer.saved(&keeping(&scene, &options, None), layers).expect("a state");
    // What a render that learns meanwhile has.
    saved.film.sums.settle();
    saved.film.sums.weigh_earlier(0.3);
    saved.model = Some(vec![1, 2, 3]);
    saved.save(&path).expect("a writable file");
    assert!(SavedRender::read(&path).expect("a whole file") == saved);
    let bytes = std::fs::read(&path).unwrap();
    let mut stream = Stream::new(6);
    for _ in 0..200 {
        let mut damaged = bytes.clone();
        let at = stream.word() as usize % bytes.len();
        match stream.word() % 2 {
            0 => damaged[at] ^= 1 << (stream.word() % 8),
            _ => damaged.truncate(at),
        }
        std::fs::write(&path, &damaged).unwrap();
        assert!(SavedRender::read(&path).is_err(), "byte {at} of {}", bytes.len());
    }
}

/// Sums do not depend on the order of their terms, however far these are apart.
#[test]
fn r11_sums_are_exact() {
    let mut stream = Stream::new(11);
    let blocks: Vec<Vec<PixelSums>> = (0..40)
        .map(|_| {
            let mut value = || f64::from(stream.f32() * 2f32.powi((stream.word() % 160) as i32 - 80));
            let mut pixel = || PixelSums {
                sum: std::array::from_fn(|_| value()),
                sum_sq: std::array::from_fn(|_| value()),
                count: 64,
                groups: 8,
                non_finite: 0,
            };
            (0..600).map(|_| pixel()).collect()
        })
        .collect();
    let sums = |order: &mut dyn Iterator<Item = usize>| {
        let mut sums = FilmSums::new(600, 1);
        order.for_each(|block| sums.add(blocks[block].par_iter().copied()));
        sums
    };
    // Or this test would show nothing.
    let plain = |pixel: usize, order: &mut dyn Iterator<Item = usize>| {
        order.map(|block| blocks[block][pixel].sum[0]).fold(0.0, |sum: f64, value| sum + value)
    };
    assert!((0..600).any(|pixel| plain(pixel, &mut (0..40)) != plain(pixel, &mut (0..40).rev())));
    let forwards = sums(&mut (0..40));
    assert_same_sums(&sums(&mut (0..40).rev()), &forwards);
    let mut parts = sums(&mut (20..40));
    parts.add_sums(&sums(&mut (0..20)));
    assert_same_sums(&parts, &forwards);
}

/// To the last bit of f64.
#[track_caller]
fn assert_same_sums(found: &FilmSums, expected: &FilmSums) {
    let bits = |pixel: PixelSums| {
        let counts = [pixel.count, pixel.groups, pixel.non_finite];
        (pixel.sum.map(f64::to_bits), pixel.sum_sq.map(f64::to_bits), counts)
    };
    assert!(found.rounded().map(bits).eq(expected.rounded().map(bits)), "other sums");
}

/// Portions of a render, each by a renderer of its own.
struct Portions<'a> {
    scene: &'a Scene,
    options: RenderOptions,
    folder: &'a Path,
}

impl Portions<'_> {
    fn render(&self, first: u32, end: u32) -> PathBuf {
        self.render_until(first, end, end)
    }

    /// Stops before the end.
    fn render_until(&self, first: u32, end: u32, stop: u32) -> PathBuf {
        let options = RenderOptions {
            budget: Budget { samples: Some(end), ..Budget::default() },
            ..self.options.clone()
        };
        let keeping = keeping(self.scene, &options, Some(end));
        let mut renderer = Renderer::new(gpu::context(), self.scene, options).expect("a renderer");
        renderer.begin_at(first);
        renderer.run(|progress| progress.samples >= stop - first).expect("a render");
        let path = self.folder.join(format!("{first}-{end}.part"));
        renderer.saved(&keeping, Vec::new()).expect("a state").save(&path).expect("a writable file");
        path
    }
}

fn picture_from(merged: Merged) -> Picture {
    let scale = 2f64.powi(merged.saved.header.radiance_exponent);
    merged.saved.film.into_sums().picture(scale)
}

fn refusal(paths: &[PathBuf], samples: Option<std::ops::Range<u32>>) -> String {
    merge(paths, samples, false).err().expect("no merge").to_string()
}

/// Cuts anywhere between groups, in any order, and merged in two steps.
#[test]
fn r11_merged_portions_are_one_render() {
    let scene = builtin("cornell").expect("a built-in scene");
    let folder = tempfile::tempdir().unwrap();
    let options = options(Method::Path, 208);
    let mut renderer = Renderer::new(gpu::context(), &scene, options.clone()).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    let expected = renderer.picture().expect("a picture");
    let sums = renderer.film_state().expect("a state").into_sums();
    let portions = Portions { scene: &scene, options, folder: folder.path() };
    let cuts = [0, 8, 24, 64, 72, 128, 200, 208];
    let mut paths: Vec<PathBuf> = cuts.windows(2).map(|cut| portions.render(cut[0], cut[1])).collect();
    paths.swap(0, 4);
    let merged = merge(&paths, Some(0..208), false).expect("a picture");
    assert_same_sums(&merged.saved.film.clone().into_sums(), &sums);
    assert_same(&picture_from(merged), &expected, "all at once");
    paths.swap(0, 4);
    let steps: Vec<PathBuf> = [&paths[..3], &paths[3..6], &paths[6..]]
        .iter()
        .enumerate()
        .map(|(step, paths)| {
            let path = folder.path().join(format!("step {step}"));
            merge(paths, None, false).expect("a portion").saved.save(&path).expect("a writable file");
            path
        })
        .collect();
    let merged = merge(&steps, Some(0..208), false).expect("a picture");
    let spp = merged.saved.header.metadata.iter().find(|(name, _)| name == "spp").expect("spp").1.clone();
    assert_eq!(spp, halfway::film::Attribute::Number(208.0));
    assert_same(&picture_from(merged), &expected, "in two steps");
}

/// Light paths that the whole picture shares, and a model.
#[test]
fn r11_portions_share_light_paths_and_a_model() {
    let scene = builtin("cornell").expect("a built-in scene");
    let folder = tempfile::tempdir().unwrap();
    let connections = Connections::even(2);
    let learns = options(Method::SpcBpt(SpcBpt { light_paths: None, connections, light_tracing: false }), 96);
    let model = Renderer::new(gpu::context(), &scene, learns.clone()).expect("a renderer").model.clone();
    assert!(model.is_some());
    let options = RenderOptions { model, ..learns };
    let expected = whole(&scene, &options).0;
    let portions = Portions { scene: &scene, options, folder: folder.path() };
    let paths = [portions.render(0, 40), portions.render(40, 96)];
    assert_same(&picture_from(merge(&paths, Some(0..96), false).expect("a picture")), &expected, "spcbpt");
    // Another model is another picture.
    let mut other = portions.options.model.as_deref().cloned().expect("a model");
    other.q[0] *= 1.5;
    let options = RenderOptions { model: Some(Arc::new(other)), ..portions.options.clone() };
    let foreign = Portions { options, ..portions }.render(96, 104);
    let said = refusal(&[paths[0].clone(), paths[1].clone(), foreign], None);
    assert!(said.contains("96-104.part") && said.contains("model"), "{said}");
}

/// What does not make the picture is named and refused, or merged as far as it goes.
#[test]
fn r11_portions_that_make_no_picture_are_refused() {
    let scene = builtin("cornell").expect("a built-in scene");
    let folder = tempfile::tempdir().unwrap();
    let seeded = RenderOptions {
        view: View { seed: 5, ..options(Method::Path, 64).view },
        ..options(Method::Path, 64)
    };
    let portions = Portions { scene: &scene, options: options(Method::Path, 64), folder: folder.path() };
    let [a, b, c] = [(0, 16), (8, 24), (32, 48)].map(|(first, end)| portions.render(first, end));
    let stopped = portions.render_until(48, 64, 56);
    let foreign = Portions { options: seeded, ..portions }.render(16, 32);
    for (paths, phrases) in [
        (vec![&a, &b], ["8-24.part", "overlap 0..16"].as_slice()),
        (vec![&a, &a], &["0-16.part", "overlap"]),
        (vec![&a, &c], &["samples 16..32 are in none", "--allow-missing"]),
        (vec![&a, &foreign], &["16-32.part", "seed 0 there, 5 here"]),
        (vec![&c, &stopped], &["48-64.part", "up to 56 only", "halfway resume"]),
    ] {
        let said = refusal(&paths.into_iter().cloned().collect::<Vec<_>>(), None);
        phrases.iter().for_each(|phrase| assert!(said.contains(phrase), "'{phrase}' not in {said}"));
    }
    assert!(refusal(std::slice::from_ref(&c), Some(0..48)).contains("samples 0..32"));
    assert!(refusal(std::slice::from_ref(&a), Some(0..32)).contains("samples 16..32"));
    let merged = merge(&[stopped, a, c], Some(0..72), true).expect("what there is");
    assert_eq!(merged.missing, [16..32, 56..72]);
    let samples = picture_from(merged);
    assert!(samples.channel("samples", "Y").unwrap().iter().all(|count| *count == 40.0));
}
