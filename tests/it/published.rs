//! Methods as their papers have them: what `--as-published` sets, samples that are independent, and `halfway bench paper`.

use glam::{DVec3, Vec3};
use halfway::integrator::method::{LVCBPT, PCBPT, RISBPT, SPCBPT};
use halfway::integrator::{Connections, Descriptor, LightPaths, LvcBpt, Method, View, Weights};
use halfway::render::{Budget, RenderOptions, Renderer};
use halfway::scene::builtin::shapes::{looking_at, quad};
use halfway::scene::{Material, Scene};
use halfway::training::{Training, When};
use serde_json::Value;

use crate::bidirectional::{SIZE, assert_options_same_as_path, shown};
use crate::command::Case;
use crate::gpu;
use crate::shots::options;

fn of(method: &Descriptor, width: u32, height: u32) -> RenderOptions {
    let view = View::sized(width, height);
    RenderOptions { view, method: method.default_method(), ..RenderOptions::default() }.as_published()
}

/// Light paths are the same share of the pixels at every size, but few for methods by records; nothing of what was added
/// here is on.
#[test]
fn as_published_is_what_the_papers_have() {
    for method in [&LVCBPT, &SPCBPT, &PCBPT, &RISBPT] {
        for (width, height, light_paths) in [(1920, 1080, 100_000), (96, 54, 250)] {
            let options = of(method, width, height);
            let plan = options.method.plan();
            let by_records = plan.record_share().is_some();
            let expected = if by_records { 200 } else { light_paths };
            assert_eq!(plan.light_paths.count(width * height, width * height), expected, "{}", method.name);
            assert!(matches!(plan.light_paths, LightPaths::Shared { .. }));
            assert_eq!(plan.connections, Connections { thinning: false, ..Connections::even(3) });
            assert!(options.view.independent && !plan.to_camera, "{}", method.name);
            if by_records {
                assert_eq!(plan.record_share(), Some(0.004));
                assert_ne!(plan.weights, Weights::AtRecords, "the paper compares with the simple form");
            }
        }
    }
    let training = of(&SPCBPT, 96, 54).training;
    assert_eq!((training.paths, training.settings.subspaces), (Some(1_000_000), Some(1000)));
    assert!(training.settings.lloyd_steps == 0 && !training.settings.light_guide);
    assert_eq!(of(&LVCBPT, 96, 54).training, Training::default(), "it learns nothing");
    // What was asked for stays, and so does a method without such connections.
    let few = RenderOptions {
        method: SPCBPT.default_method(),
        training: Training { paths: Some(5), ..Training::default() },
        ..RenderOptions::default()
    };
    assert_eq!(few.as_published().training.paths, Some(5));
    let path = RenderOptions::default();
    assert_eq!(path.clone().as_published(), path);
}

/// Independent samples are right on average (C-08).
#[test]
fn c08_independent_samples_agree_with_path() {
    let training = Training { when: Some(When::First), ..Training::default().with_rounds(1) };
    for method in [&LVCBPT, &SPCBPT] {
        let base = options(SIZE, 4);
        let view = View { independent: true, ..base.view };
        let method = method.default_method();
        assert_options_same_as_path(
            &shown("cornell"),
            &RenderOptions { view, method, training: training.clone(), ..base },
        );
    }
}

/// Across the edge of a lamp the samples of a pixel that it covers by a share s have a variance of s (1 - s) each.
#[test]
fn independent_samples_scatter_as_such() {
    const SAMPLES: u32 = 512;
    let lamp = Material { emission: Vec3::ONE, ..Material::lambert("lamp", Vec3::ZERO) };
    let method = Method::LvcBpt(LvcBpt { light_paths: Some(1), ..LvcBpt::default() });
    let budget = Budget { samples: Some(SAMPLES), ..Budget::default() };
    let cameras = vec![looking_at("camera", DVec3::Z, DVec3::ZERO, 90.0)];
    let wall = quad(DVec3::new(-1.0, -1.0, 0.0), 1.3 * DVec3::X, 8.0 * DVec3::Y);
    let scene = Scene { materials: vec![lamp], meshes: vec![wall], cameras, ..Scene::default() };
    let variance = |independent: bool| {
        let view = View { max_depth: Some(1), independent, ..View::sized(8, 1) };
        let options = RenderOptions { view, method, budget, ..RenderOptions::default() };
        let mut renderer = Renderer::new(gpu::context(), &scene, options).expect("a renderer");
        renderer.run(|_| false).expect("a render");
        let picture = renderer.picture().expect("a picture");
        let variances = picture.channel("variance", "R").expect("a layer");
        let mean = |pixel: usize| f64::from(picture.rgb[pixel][0]);
        let edges: Vec<usize> = (0..8).filter(|&pixel| (0.1..0.9).contains(&mean(pixel))).collect();
        assert!(!edges.is_empty(), "no pixel is at the edge");
        let ratio = |&pixel: &usize| {
            f64::from(variances[pixel]) / (mean(pixel) * (1.0 - mean(pixel)) / f64::from(SAMPLES))
        };
        edges.iter().map(ratio).sum::<f64>() / edges.len() as f64
    };
    let [together, independent] = [false, true].map(variance);
    assert!(together < 0.5, "{together} in groups");
    // Of 64 groups: 18 % of scatter.
    assert!((0.4..1.6).contains(&independent), "{independent} of independent samples");
}

#[test]
fn as_published_is_recorded_and_stands_alone() {
    let case = Case::new();
    for (settings, phrases) in [
        ("-i lvcbpt --as-published --connections 2", ["--as-published", "--connections"]),
        ("-i risbpt --as-published --record-share 0.1", ["--as-published", "--record-share"]),
        ("-i spcbpt --as-published --subspaces 8", ["--as-published", "--subspaces"]),
        ("-i lvcbpt --as-published --independent", ["--as-published", "--independent"]),
        ("-i path --as-published", ["--as-published", "lvcbpt"]),
        ("--independent", ["--independent", "lvcbpt"]),
    ] {
        case.refuse(&format!("render builtin:cornell --size 8x8 {settings} -o DIR/a.exr"), &phrases);
    }
    let run = case
        .run("render builtin:cornell --size 8x8 --spp 2 -i pcbpt --as-published -o a.exr --stats stats.json");
    run.assert(0, &["as published"]);
    let stats = std::fs::read_to_string(case.path("stats.json")).expect("a file");
    let stats: Value = serde_json::from_str(&stats).expect("JSON");
    let choices = stats["choices"].to_string();
    for phrase in ["as published", "records", "shadow rays a sample", "MB"] {
        assert!(choices.contains(phrase), "{phrase} is not in {choices}");
    }
    assert!(stats["rays"]["records"].as_u64().is_some_and(|records| records > 0), "{}", stats["rays"]);
}

/// What records take is told before anything is built.
#[test]
fn info_foretells_records() {
    let case = Case::new();
    let run = case.run("info builtin:cornell");
    run.assert(0, &[]);
    for phrase in [
        "pcbpt and risbpt at",
        "records with tables of about 1200 light vertices",
        "shadow rays",
        "M rays a sample beside",
    ] {
        assert!(run.printed.contains(phrase), "{phrase} is not in {}", run.printed);
    }
}

/// The page has every method of every scene beside the paper's figures, and the second run renders nothing.
#[test]
fn bench_paper_has_both_tables() {
    let case = Case::new();
    // The page knows scenes by name, and the box has kernels that other tests have too.
    std::fs::copy("scenes/cornell.glb", case.path("door.glb")).expect("a copy");
    let command = "bench paper door.glb --size 16x9 --time 0.3s --seeds 1 --inset-time 0.3s --train-paths 50 \
                   --more 5 --more-records 0.5 --reference-time 1s --references refs -o out --markdown page/paper.md";
    case.run(command).assert(0, &[]);
    let read = |name: &str| std::fs::read_to_string(case.path(name)).expect(name);
    let page = read("page/paper.md");
    for phrase in [
        "## To 12 %",
        "724 | 2,328",
        "273 | 269",
        "|  | pcbpt | - | - |",
        "### The order",
        "spcbpt 59 < risbpt 269 < lvcbpt 2,328",
        "## At 100 iterations",
        "101 | 18.3 %",
        "## 64 iterations, more candidates",
        "| pcbpt | records of 50 % of the pixels |",
        "![door: parts of it by each method](paper-door.png)",
        "halfway bench paper door.glb",
    ] {
        assert!(page.contains(phrase), "'{phrase}' is not in {page}");
    }
    assert!(case.path("page/paper-door.png").exists());
    let runs = read("out/runs.jsonl");
    assert_eq!(runs.lines().count(), 8 + 4, "{runs}");
    let paper: Value = serde_json::from_str(&read("out/paper.json")).expect("JSON");
    let labels: Vec<String> = paper["scenes"][0]["candidates"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|one| one["label"].as_str().unwrap_or_default().to_owned())
        .collect();
    assert_eq!(labels[0], "lvcbpt:as-published");
    assert_eq!(labels[6..], ["spcbpt:as-published,train-paths=50", "spcbpt"]);
    case.run(command).assert(0, &["8 renders are there already, 0 to go"]);
    assert_eq!(read("out/runs.jsonl"), runs);
}
