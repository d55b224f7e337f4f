//! SPCBPT is unbiased whatever it has learnt (C-08, C-09), also where there is next to nothing to choose from (N-26).

use std::sync::Arc;

use halfway::integrator::{Method, Training};
use halfway::render::{RenderOptions, Renderer};
use halfway::scene::Scene;
use halfway::scene::builtin::builtin;
use halfway::subspace::{Model, Settings};

use crate::bidirectional::{SIZE, assert_options_same_as_path};
use crate::gpu;
use crate::random::Stream;
use crate::shots::options;

fn method(light_paths: u32, connections: u32, light_tracing: bool) -> Method {
    Method::SpcBpt { light_paths: Some(light_paths), connections, light_tracing }
}

fn spcbpt(method: Method, samples: u32, model: Option<Arc<Model>>) -> RenderOptions {
    let Method::SpcBpt { connections, .. } = method else { panic!("{method:?} learns nothing") };
    let settings = Settings { subspaces: Some(24), connections, ..Settings::default() };
    RenderOptions { method, model, training: Training { paths: 4000, settings }, ..options(SIZE, samples) }
}

fn trained(scene: &Scene) -> Model {
    let options = spcbpt(method(600, 2, false), 1, None);
    let renderer = Renderer::new(gpu::context(), scene, options).expect("a renderer");
    let model = renderer.model.as_deref().expect("a scene with light").clone();
    let counts = &model.report.counts;
    assert!(counts.paths >= 4000 && counts.nodes > counts.paths / 2, "{counts:?}");
    assert_eq!((counts.faulty_paths, counts.faulty_light_samples), (0, 0));
    model
}

/// The same trees grown for the wrong side, any Gamma, and Q wrong by factors.
fn nonsense(model: &Model, random: &mut Stream) -> Model {
    let mut model = model.clone();
    std::mem::swap(&mut model.eye_tree, &mut model.light_tree);
    let k = model.subspaces as usize;
    for row in model.gamma.chunks_mut(k) {
        // Over a decade: more only makes the rare, bright samples rarer.
        row.iter_mut().for_each(|entry| *entry = 10f32.powf(random.f32()));
        let sum: f32 = row.iter().sum();
        row.iter_mut().for_each(|entry| *entry /= sum);
    }
    model.q.iter_mut().for_each(|q| *q *= 4f32.powf(2.0 * random.f32() - 1.0));
    model
}

#[test]
fn c08_spcbpt_agrees_with_path() {
    for (name, light_tracing) in [("door", false), ("spheres", true)] {
        let scene = builtin(name).expect("a built-in scene");
        assert_options_same_as_path(&scene, &spcbpt(method(600, 2, light_tracing), 4, None));
    }
}

#[test]
fn c09_spcbpt_with_nonsense_agrees_with_path() {
    let mut random = Stream::new(9);
    for (name, light_tracing) in [("three-lights", true), ("bumpy-plane", false)] {
        let scene = builtin(name).expect("a built-in scene");
        let model = trained(&scene);
        let model = Some(Arc::new(nonsense(&model, &mut random)));
        assert_options_same_as_path(&scene, &spcbpt(method(900, 2, light_tracing), 8, model));
    }
}

/// A light path or two: nearly all subspaces are empty in every iteration.
#[test]
fn n26_empty_subspaces_lose_nothing() {
    let scene = builtin("cornell").expect("a built-in scene");
    let model = Some(Arc::new(trained(&scene)));
    for light_paths in [1, 24] {
        assert_options_same_as_path(&scene, &spcbpt(method(light_paths, 1, false), 24, model.clone()));
    }
}
