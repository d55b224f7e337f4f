//! The estimated error of the denoised picture, and the halves of the samples that it is from.

use halfway::film::checkpoint::SavedRender;
use halfway::film::denoise::{Denoiser, LAYER};
use halfway::film::halves::{HalfSums, Halves};
use halfway::film::state::GroupPixel;
use halfway::film::sums::FilmSums;
use halfway::film::{Attribute, Picture, metric};
use halfway::integrator::{Connections, LvcBpt, Method};
use halfway::render::{Keeping, NoHalves, Origin, RenderOptions, Renderer, picture_of};
use halfway::scene::Scene;
use halfway::scene::builtin::builtin;

use crate::command::Case;
use crate::gpu;
use crate::random::Stream;
use crate::shots::options;

fn with_halves(size: [u32; 2], samples: u32) -> RenderOptions {
    RenderOptions { halves: true, first_hit_layers: true, through_mirrors: true, ..options(size, samples) }
}

fn renderer(scene: &Scene, options: RenderOptions) -> Renderer {
    Renderer::new(gpu::context(), scene, options).expect("a renderer")
}

fn rendered(scene: &Scene, options: RenderOptions) -> Renderer {
    let mut renderer = renderer(scene, options);
    renderer.run(|_| false).expect("a render");
    renderer
}

fn halves(renderer: &Renderer) -> Halves {
    renderer.halves().expect("a device").expect("halves")
}

fn assert_same_halves(a: &Halves, b: &Halves) {
    assert_eq!(a.shares, b.shares);
    for (a, b) in a.pictures.iter().zip(&b.pictures) {
        assert_eq!(a.rgb, b.rgb);
    }
}

/// Where samples end within a group of either half, within a block and at its end: the picture is the same to the last bit,
/// and that of both halves together.
#[test]
fn s04_halves_change_no_bit_of_the_picture() {
    let scene = builtin("cornell").expect("a built-in scene");
    for samples in [12, 20, 64, 84, 92] {
        let plain = rendered(&scene, options([16, 12], samples));
        let kept = rendered(&scene, with_halves([16, 12], samples));
        assert!(plain.film_state().unwrap() == kept.film_state().unwrap(), "{samples} samples");
        assert_eq!(plain.estimated_error().unwrap(), kept.estimated_error().unwrap());
        assert_eq!(plain.halves().unwrap().err(), Some(NoHalves::NotKept));
        let Halves { pictures: [a, b], shares } = halves(&kept);
        let second = samples / 16 * 8 + (samples % 16).saturating_sub(8);
        assert_eq!(shares, [samples - second, second].map(|half| f64::from(half) / f64::from(samples)));
        let picture = kept.radiance().unwrap();
        let mut differ = 0;
        for ((a, b), all) in a.rgb.iter().zip(&b.rgb).zip(&picture.rgb) {
            for c in 0..3 {
                let both = shares[0] * f64::from(a[c]) + shares[1] * f64::from(b[c]);
                assert!((both - f64::from(all[c])).abs() <= 1e-6 * both, "{both} {}", all[c]);
                differ += usize::from(a[c] != b[c]);
            }
        }
        assert!(differ > 3 * picture.rgb.len() / 2, "{differ}");
    }
}

/// One group is no two halves, however many samples of it there are.
#[test]
fn one_group_has_no_halves() {
    let scene = builtin("cornell").expect("a built-in scene");
    for samples in [1, 8] {
        let renderer = rendered(&scene, with_halves([8, 8], samples));
        assert_eq!(renderer.halves().unwrap().err(), Some(NoHalves::OneGroup));
    }
}

/// Samples weigh in halves what they weigh in the picture.
#[test]
fn halves_have_the_weights_of_the_picture() {
    let mut random = Stream::new(1);
    let (mut sums, mut first) = (FilmSums::new(5, 4), HalfSums::new(20));
    // Per half and pixel: weighted sum and weight.
    let mut expected = [[(0.0, 0.0); 20]; 2];
    for group in 0..12 {
        if group == 5 || group == 8 {
            sums.settle();
            first.settle();
        }
        if group == 7 || group == 9 {
            sums.weigh_earlier(0.25);
            first.weigh_earlier(0.25);
        }
        let weight = if group < 5 {
            1.0 / 16.0
        } else if group < 8 {
            0.25
        } else {
            1.0
        };
        let pixels: Vec<GroupPixel> =
            (0..20).map(|_| GroupPixel { sum: [8.0 * random.f32(); 3], count: 8, non_finite: 0 }).collect();
        let half = usize::from(!HalfSums::takes(group));
        if half == 0 {
            first.add(&pixels);
        }
        let taken: Vec<_> = pixels
            .iter()
            .map(|pixel| {
                let mut sums = halfway::film::sums::PixelSums::default();
                sums.add_group(pixel.sum.map(f64::from), 8);
                sums
            })
            .collect();
        sums.add(taken);
        for ((sum, total), pixel) in expected[half].iter_mut().zip(&pixels) {
            *sum += weight * f64::from(pixel.sum[0]);
            *total += 8.0 * weight;
        }
    }
    let Halves { pictures, shares } = first.pictures(&sums, 2.0);
    for (half, (picture, expected)) in pictures.iter().zip(&expected).enumerate() {
        for (pixel, (sum, weight)) in picture.rgb.iter().zip(expected) {
            let wanted = 2.0 * sum / weight;
            assert!((f64::from(pixel[0]) / wanted - 1.0).abs() < 1e-6, "half {half}: {pixel:?} {wanted}");
        }
    }
    let weights = [expected[0][0].1, expected[1][0].1];
    assert!((shares[0] - weights[0] / (weights[0] + weights[1])).abs() < 1e-12, "{shares:?} {weights:?}");
}

fn keeping(scene: &Scene, options: &RenderOptions) -> Keeping {
    let origin = Origin {
        method: options.method,
        seed: options.view.seed,
        scene_hash: scene.content_hash(),
        device: gpu::context().describe(),
        command_line: String::new(),
    };
    let picture = picture_of(origin.scene_hash, &scene.cameras[0], options);
    Keeping { picture, origin, command: Vec::new(), folder: String::new(), end: None }
}

/// Stopped within a group, and between groups within a block: halves go on with the picture. Where either render has none,
/// the picture goes on alone.
#[test]
fn r06_halves_go_on_from_a_checkpoint() {
    let scene = builtin("cornell").expect("a built-in scene");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.checkpoint");
    let whole = rendered(&scene, with_halves([16, 12], 88));
    for (stop, before, after) in [(21, true, true), (40, true, true), (21, true, false), (21, false, true)] {
        let of = |halves: bool, samples: u32| RenderOptions { halves, ..with_halves([16, 12], samples) };
        let mut begun = rendered(&scene, of(before, stop));
        let keeping = keeping(&scene, &of(before, stop));
        begun.saved(&keeping, Vec::new()).unwrap().save(&path).unwrap();
        let saved = SavedRender::read(&path).expect("a whole file");
        assert!(saved == begun.saved(&keeping, Vec::new()).unwrap());
        let mut renderer = renderer(&scene, of(after, 88));
        renderer.go_on_from(&path, saved).expect("a place to go on from");
        renderer.run(|_| false).expect("a render");
        assert!(renderer.film_state().unwrap() == whole.film_state().unwrap(), "{stop} {before} {after}");
        match before && after {
            true => assert_same_halves(&halves(&renderer), &halves(&whole)),
            false => assert_eq!(renderer.halves().unwrap().err(), Some(NoHalves::NotKept)),
        }
    }
}

/// Noise alone, with and without shared light paths: the estimate is within a factor of 1.5 of the truth, and so it is when the
/// truth is several times as large.
#[test]
fn the_estimate_is_near_the_error_of_the_denoised_picture() {
    let scene = builtin("cornell").expect("a built-in scene");
    let reference = rendered(&scene, RenderOptions { method: lvcbpt(), ..options([48, 48], 384) });
    let reference = reference.radiance().unwrap();
    let mut denoiser = Denoiser::open().unwrap();
    for (method, samples) in [(Method::Path, 16), (Method::Path, 128), (lvcbpt(), 16)] {
        let mut renderer = rendered(&scene, RenderOptions { method, ..with_halves([48, 48], samples) });
        let picture = renderer.picture().unwrap();
        let (denoised, error) = denoiser.denoise_halves(&picture, &halves(&renderer)).unwrap();
        let truth = metric::errors(&Picture::new(48, 48, denoised), &reference).unwrap().mape;
        let error = error.expect("an estimate");
        println!("{} {samples}: estimate {error:.4}, truth {truth:.4}", method.name());
        assert!((2.0 / 3.0..1.5).contains(&(error / truth)), "{samples}: {error} for {truth}");
    }
}

fn lvcbpt() -> Method {
    Method::LvcBpt(LvcBpt { light_paths: None, connections: Connections::even(2), light_tracing: false })
}

/// Report, metadata and figures have both errors; one group of samples says why there is only one.
#[test]
fn both_errors_are_reported() {
    let case = Case::new();
    let arguments = "render builtin:cornell -i path --size 32x32 --denoise --stats a.json -o a.exr";
    let run = case.run(&format!("{arguments} --spp 32"));
    run.assert(0, &["estimated error", "% denoised)"]);
    let stats = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(case.path(name)).unwrap()).expect("JSON")
    };
    let figures = stats("a.json");
    let picture = case.picture("a.exr");
    for (name, attribute) in
        [("estimated_error", "estimatedError"), ("denoised_error", "estimatedErrorDenoised")]
    {
        let figure = figures[name].as_f64().expect("a number");
        // JSON need not have the last digit.
        match picture.attribute(attribute) {
            Some(Attribute::Number(number)) => assert!((number / figure - 1.0).abs() < 1e-12, "{name}"),
            other => panic!("{name}: {other:?}"),
        }
    }
    assert!(figures["denoised_error"].as_f64() < figures["estimated_error"].as_f64());
    case.run(&format!("{arguments} --spp 8"))
        .assert(0, &["the error of the denoised picture is not known: that takes more than 8 samples"]);
    assert!(stats("a.json")["denoised_error"].is_null());
    assert_eq!(case.picture("a.exr").attribute("estimatedErrorDenoised"), None);
    let run = case.run("render builtin:cornell -i path --size 16x16 --spp 16 --stats b.json -o b.exr");
    run.assert(0, &["estimated error"]);
    assert!(!run.said.contains("denoised"), "{}", run.said);
    assert_eq!(case.picture("b.exr").attribute("estimatedErrorDenoised"), None);
}

/// `--error` goes by the picture that is looked at: it is met long before the raw picture would meet it.
#[test]
fn a_denoised_picture_ends_by_its_own_error() {
    let case = Case::new();
    let run = case.run(
        "render builtin:door -i path --size 32x32 --spp 600 --error 0.25 --denoise --stats a.json -o a.exr",
    );
    run.assert(0, &["--error reached"]);
    let picture = case.picture("a.exr");
    assert!(picture.channel(LAYER, "R").is_some());
    let figures: serde_json::Value =
        serde_json::from_slice(&std::fs::read(case.path("a.json")).unwrap()).expect("JSON");
    let of = |name: &str| figures[name].as_f64().expect("a number");
    assert!(of("denoised_error") <= 0.25, "{}", of("denoised_error"));
    assert!(of("estimated_error") > 0.25, "{}", of("estimated_error"));
    assert!(of("samples") >= 64.0 && of("samples") < 600.0, "{}", of("samples"));
}

/// A checkpoint without halves gives no error of the denoised picture, and no end by it.
#[test]
fn a_checkpoint_without_halves_is_said_to_have_none() {
    let case = Case::new();
    let arguments = "render builtin:cornell -i path --size 16x16 --checkpoint a.checkpoint -o a.exr";
    case.run(&format!("{arguments} --spp 16")).assert(0, &[]);
    let resumed = format!("{arguments} --resume a.checkpoint --denoise --spp 32");
    case.run(&format!("{resumed} --error 0.1"))
        .assert(2, &["the checkpoint was rendered without --denoise", "Leave out --error"]);
    case.run(&resumed).assert(0, &["not known: the checkpoint was rendered without --denoise"]);
    // With them it goes on.
    case.run(&format!("{arguments} --spp 16 --denoise")).assert(0, &["% denoised)"]);
    case.run("resume a.checkpoint --spp 32").assert(0, &["32 spp", "% denoised)"]);
}
