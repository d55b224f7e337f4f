//! The paths that SPCBPT finds and learns from: by all ways together they have the density that says how they were found.

use halfway::accel::Accel;
use halfway::device::layout::Camera;
use halfway::device::scene::DeviceScene;
use halfway::integrator::{Connections, DEFAULT_ROULETTE_CAP, Method, Settings, SpcBpt, View};
use halfway::scene::builtin::builtin;
use halfway::scene::{Scene, SceneFeatures};
use halfway::subspace::{self, FirstConnections, Model};
use halfway::training::{Training, TrainingTask, find_training_paths, train};

use crate::closed_forms::pipe_of_mirrors;
use crate::frozen_paths_subspaces::dark_glass;
use crate::gpu;

const CONNECTIONS: u32 = 2;

/// p0 + sum N Gamma / Q mass, over p: one for every path, if the density p of the mixture, and all parts of it that the
/// host puts together from what kernels noted down, are right. `to_learn`: how much an untaught Gamma loses at least.
#[track_caller]
fn assert_densities_of_one(scene: &Scene, roulette_cap: f32, to_learn: f64) {
    let context = gpu::context();
    let accel = Accel::build(scene).expect("a tree");
    let device = DeviceScene::new(context, scene, &accel, SceneFeatures::of(scene)).expect("a device scene");
    let [width, height] = [48, 48];
    let camera = Camera::new(&device.unit, &scene.cameras[0], width, height);
    let method = Method::SpcBpt(SpcBpt {
        light_paths: None,
        // Paths are found with as many as these, whatever a model wants.
        connections: Connections { adapts: true, ..Connections::even(CONNECTIONS) },
        light_tracing: false,
    });
    let settings = Settings {
        view: View { roulette_cap, seed: 3, ..View::sized(width, height) },
        method,
        strategy: None,
        first_hit: false,
        through_mirrors: false,
        transparent: false,
        timing: false,
    };
    let learning = subspace::Settings { subspaces: Some(12), ..subspace::Settings::default() };
    let training = Training { settings: learning, ..Training::default() };
    let task = TrainingTask::new(context, &device, &camera, settings, 0, &training);
    let trained = train(&task, |_| false).expect("light to learn from");
    let first_connections = Some(FirstConnections { count: 5, made: 2, variance: 0.5, cost: 0.5 });
    let model = &Model { first_connections, ..trained.model.as_ref().clone() };
    let set = find_training_paths(&task, model).expect("more paths");
    let mut worst = 0.0f64;
    let mut lengths = [0; 12];
    for index in 0..set.paths().len() {
        let error = (model.path_density(&set, index) - 1.0).abs();
        // Also where it is none.
        worst = if error <= worst { worst } else { error };
        lengths[set.nodes_of(index).len().min(11)] += 1;
    }
    let count = set.paths().len();
    // So is the loss by the model that found them, over itself; an untaught one has more.
    let own = subspace::relative_loss(model, &set, 0..count).expect("sound paths");
    assert!((own - 1.0).abs() < 1e-5, "{}: {own}", scene.name);
    let mut even = model.clone();
    even.gamma.fill(1.0 / even.subspaces as f32);
    let even = subspace::relative_loss(&even, &set, 0..count).expect("sound paths");
    println!("{}: loss of an even Gamma {even:.3}", scene.name);
    assert!(even > 1.0 + to_learn, "{}: {even}", scene.name);
    println!("{}: {count} paths, worst {worst:e}; by number of nodes {lengths:?}", scene.name);
    assert!(count > 500, "{}: only {count} paths", scene.name);
    assert!(
        worst < 1e-5,
        "{}: a path whose densities do not sum to one, but to one +- {worst:e}",
        scene.name
    );
}

#[test]
fn densities_of_found_paths_sum_to_one() {
    // Lambert; sky, point, spot and sun; mirror, metal and glass; glass that absorbs.
    for name in ["cornell", "three-lights", "spheres"] {
        assert_densities_of_one(&builtin(name).expect("a built-in scene"), DEFAULT_ROULETTE_CAP, 0.02);
    }
    assert_densities_of_one(&dark_glass(), DEFAULT_ROULETTE_CAP, 0.02);
    assert_densities_of_one(&builtin("cornell").expect("a built-in scene"), 0.9, 0.02);
    // Rows of more mirrors than roulette passes like any others, and one way for all light.
    assert_densities_of_one(&pipe_of_mirrors(40.0), DEFAULT_ROULETTE_CAP, 0.0);
}
