//! Learning while rendering: samples by all models so far are in the picture, and nothing is lost or claimed that is not
//! there (C-09).

use halfway::film::Picture;
use halfway::integrator::{Connections, Method, SpcBpt, View};
use halfway::render::{Budget, RenderOptions, Renderer, Report};
use halfway::scene::Scene;
use halfway::scene::builtin::builtin;
use halfway::subspace::Settings;
use halfway::training::{Training, When};

use crate::bidirectional::{SIZE, cornell_by_path, mean};
use crate::gpu;
use crate::shots::options;
use crate::stats::{FAMILY_ALPHA, Moments, welch_p};

const ROUNDS: u32 = 3;

fn renderer(scene: &Scene, seed: u64) -> Renderer {
    let settings = Settings::default();
    let training =
        Training { settings, when: Some(When::Meanwhile), ..Training::default() }.with_rounds(ROUNDS);
    // First vertices have more or fewer as soon as that is known.
    let connections = Connections { counts: [3, 2, 2], adapts: true, ..Connections::even(2) };
    let method = Method::SpcBpt(SpcBpt { light_paths: None, connections, light_tracing: false });
    let options =
        RenderOptions { view: View { seed, ..options(SIZE, 8).view }, method, training, ..options(SIZE, 8) };
    Renderer::new(gpu::context(), scene, options).expect("a renderer")
}

/// Renders until all rounds are over, and two groups more.
fn render(renderer: &mut Renderer) -> Report {
    let mut samples = 0;
    loop {
        samples += 8;
        assert!(samples < 100_000, "learning does not end");
        renderer.set_budget(Budget { samples: Some(samples), ..Budget::default() });
        renderer.run(|_| false).expect("a render");
        let report = renderer.report().expect("a report");
        assert_eq!(report.samples, samples);
        let choice = report.choices.iter().find(|choice| choice.what == "rounds");
        if choice.is_some_and(|choice| choice.reason == "as many as wanted") {
            renderer.set_budget(Budget { samples: Some(samples + 16), ..Budget::default() });
            renderer.run(|_| false).expect("a render");
            return renderer.report().expect("a report");
        }
    }
}

/// Of all pixels and channels.
fn sum(picture: &Picture, of: impl Fn(usize, usize) -> f64) -> f64 {
    (0..picture.rgb.len())
        .flat_map(|pixel| [0, 1, 2].map(|channel| (pixel, channel)))
        .map(|(p, c)| of(p, c))
        .sum()
}

#[test]
fn c09_learning_while_rendering_agrees_with_path() {
    let scene = builtin("cornell").expect("a built-in scene");
    let path = cornell_by_path();
    let truth = |pixel: usize, channel: usize| {
        path.iter().map(|picture| picture[pixel][channel]).sum::<f64>() / path.len() as f64
    };
    let (mut means, mut claimed, mut scatter) = (Vec::new(), 0.0, 0.0);
    for seed in 3000..3008 {
        let mut renderer = renderer(&scene, seed);
        let report = render(&mut renderer);
        let at = &report.round_samples;
        assert_eq!(at.len(), ROUNDS as usize, "{at:?}");
        assert!(at.is_sorted() && at.iter().all(|samples| samples % 8 == 0), "{at:?}");
        // The last is judged as well: what was rendered before it has its weight.
        let losses = &report.round_losses;
        assert!(
            losses.len() == ROUNDS as usize && losses.iter().all(|loss| (0.01..1.3).contains(loss)),
            "{losses:?}"
        );
        let picture = renderer.picture().expect("a picture");
        let samples = picture.channel("samples", "Y").expect("a layer");
        assert!(samples.iter().all(|&count| count == report.samples as f32), "{} samples", report.samples);
        let variance = ["R", "G", "B"].map(|channel| picture.channel("variance", channel).expect("a layer"));
        claimed += sum(&picture, |pixel, channel| variance[channel][pixel].into());
        scatter += sum(&picture, |p, c| (f64::from(picture.rgb[p][c]) - truth(p, c)).powi(2));
        let pixels: Vec<glam::DVec3> =
            picture.rgb.iter().map(|&rgb| glam::Vec3::from(rgb).as_dvec3()).collect();
        means.push(mean(&pixels));
        println!("seed {seed}: rounds after {at:?} of {} samples, losses {losses:.2?}", report.samples);
    }
    let [a, b]: [Moments; 2] = [means.into_iter().collect(), path.iter().map(|p| mean(p)).collect()];
    let error = a.standard_error().hypot(b.standard_error()) / b.mean;
    let (ratio, p) = (a.mean / b.mean, welch_p(&a, &b));
    println!(
        "8 seeds: {ratio:.5} +- {error:.5} of path, p = {p:.2e}; variance claimed over true {:.3}",
        claimed / scatter
    );
    assert!(error < 4e-3, "{error} is too noisy: only a bias of six times as much is found");
    assert!(p > FAMILY_ALPHA, "{ratio} +- {error}, p = {p:e}");
    assert!((0.85..1.15).contains(&(claimed / scatter)), "claimed {claimed}, true {scatter}");
}

/// A render that ends first, or begins again, ends learning as well, and keeps what was learnt.
#[test]
fn learning_ends_with_the_render() {
    let scene = builtin("cornell").expect("a built-in scene");
    let mut renderer = renderer(&scene, 7);
    renderer.run(|_| false).expect("a render");
    let report = renderer.report().expect("a report");
    let choice = report.choices.iter().find(|choice| choice.what == "rounds").expect("a choice");
    assert_eq!(choice.value, report.round_samples.len().to_string());
    assert_eq!(choice.reason, "the render ended before learning did");
    let learnt = renderer.model.clone().expect("a model");
    renderer.restart(8, None).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    assert!(std::sync::Arc::ptr_eq(&learnt, renderer.model.as_ref().expect("a model")));
    assert_eq!(renderer.report().expect("a report").samples, 8);
}
