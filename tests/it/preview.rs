//! The preview's worker without its window: what it renders, learns, saves and loses.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use halfway::device::{Context, DeviceChoice};
use halfway::film::Picture;
use halfway::film::tonemap::ViewTransform;
use halfway::integrator::method::{Given, Setting};
use halfway::integrator::{METHODS, Method, View};
use halfway::preview::controls::Navigator;
use halfway::preview::snapshot::Snapshot;
use halfway::preview::worker::{Event, Request, Save, Saved, Worker};
use halfway::preview::{SLOTS, Settings};
use halfway::render::{Budget, RenderOptions, Renderer};
use halfway::scene::builtin::builtin;
use halfway::scene::{Scene, Viewpoint};
use halfway::subspace::Model;
use halfway::training::Training;

use crate::gpu;

const PATH: usize = 0;
const LVCBPT: usize = 2;
const SPCBPT: usize = 3;
/// Whole groups, an open one, and a flush in between.
const SAMPLES: u32 = 76;

/// With another number of connections than the default.
fn methods() -> [Method; SLOTS] {
    assert_eq!([PATH, LVCBPT, SPCBPT].map(|slot| METHODS[slot].name), ["path", "lvcbpt", "spcbpt"]);
    METHODS.map(|method| {
        let light_tracing = !method.takes(Setting::Learning);
        (method.make)(&Given {
            light_paths: None,
            connections: Some([4; 3]),
            light_tracing,
            ..Given::default()
        })
    })
}

fn options() -> RenderOptions {
    let training = Training::default().with_rounds(2);
    RenderOptions {
        view: View { width: 44, height: 36, seed: 7, ..View::default() },
        training,
        ..RenderOptions::default()
    }
}

fn settings(context: &Context, slot: usize) -> Settings {
    let scene = Arc::new(builtin("cornell").expect("a built-in scene"));
    Settings {
        context: context.clone(),
        scene,
        camera: Viewpoint::default(),
        loader: Box::new(|| Err("the scene does not change".into())),
        files: Vec::new(),
        options: options(),
        methods: methods(),
        slot,
        samples: Some(SAMPLES),
        reference: None,
        view: ViewTransform::Neutral,
        exposure: 0.0,
        output: PathBuf::from("unused"),
        title: "cornell".into(),
        command_line: "halfway preview".into(),
    }
}

fn request(navigator: &Navigator, slot: usize, view: u64) -> Request {
    Request {
        camera: navigator.camera(),
        camera_flags: navigator.flags(),
        view,
        moving: false,
        slot,
        beside: None,
        paused: false,
        samples: Some(SAMPLES),
        denoised: false,
        subspaces: false,
        non_finite: false,
    }
}

/// A worker on its scene, with the window's end of it.
struct Stage {
    worker: Worker,
    navigator: Navigator,
    events: Vec<Event>,
}

impl Stage {
    fn new(settings: Settings) -> Self {
        let navigator = Navigator::new(&settings.scene, &settings.camera).expect("a camera");
        let slot = settings.slot;
        let worker = Worker::new(Arc::new(settings), request(&navigator, slot, 0), || {}).expect("a worker");
        Self { worker, navigator, events: Vec::new() }
    }

    /// The first snapshot that is `enough`.
    #[track_caller]
    fn wait(&mut self, enough: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
        let start = Instant::now();
        loop {
            while let Some(event) = self.worker.event() {
                if let Event::Failed(message) | Event::Lost(message) = &event {
                    panic!("{message}");
                }
                self.events.push(event);
            }
            let snapshot = self.worker.snapshot();
            if enough(&snapshot) {
                return snapshot;
            }
            assert!(start.elapsed() < Duration::from_secs(300), "{:?}", snapshot.figures);
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// All samples of that integrator and view.
    #[track_caller]
    fn finish(&mut self, slot: usize, view: u64) -> Arc<Snapshot> {
        self.wait(|snapshot| {
            let figures = &snapshot.figures;
            let seen = (snapshot.slot, snapshot.view, figures.samples) == (slot, view, SAMPLES);
            seen && figures.done && snapshot.picture.width == options().view.width
        })
    }

    #[track_caller]
    fn save(&mut self, name: PathBuf) -> Saved {
        self.worker.save(Save { name, view: ViewTransform::Neutral, exposure: 0.0 });
        let start = Instant::now();
        loop {
            match self.worker.event() {
                Some(Event::Saved(saved)) => return saved,
                Some(Event::Failed(message) | Event::Lost(message)) => panic!("{message}"),
                Some(Event::Loaded(_)) => {}
                None => std::thread::sleep(Duration::from_millis(5)),
            }
            assert!(start.elapsed() < Duration::from_secs(300), "nothing is saved");
        }
    }
}

/// What `halfway render` makes with these flags.
fn headless(camera: &Viewpoint, slot: usize, model: Option<Arc<Model>>) -> Picture {
    let mut scene: Scene = builtin("cornell").expect("a built-in scene");
    let camera = camera.choose(&mut scene).expect("a camera");
    let options = RenderOptions {
        method: methods()[slot],
        budget: Budget { samples: Some(SAMPLES), ..Budget::default() },
        first_hit_layers: true,
        camera,
        model,
        ..options()
    };
    let mut renderer = Renderer::new(gpu::context(), &scene, options).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    renderer.picture().expect("a picture")
}

#[track_caller]
fn assert_same_bits(saved: &Picture, headless: &Picture, what: &str) {
    let bits = |picture: &Picture| -> Vec<u32> {
        picture.rgb.as_flattened().iter().map(|value| value.to_bits()).collect()
    };
    assert_eq!(bits(saved), bits(headless), "{what}: radiance");
    for layer in &headless.layers {
        for (name, samples) in &layer.channels {
            let other = saved.channel(&layer.name, name).expect("the same layers");
            let same = other.iter().zip(samples).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "{what}: {}.{name}", layer.name);
        }
    }
}

/// Whatever was rendered before, from any camera, in any slices: a saved picture is that of `halfway render`.
#[test]
fn saved_pictures_are_those_of_render() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = Stage::new(settings(gpu::context(), LVCBPT));
    stage.finish(LVCBPT, 0);
    let saved = stage.save(folder.path().join("a"));
    assert_eq!((saved.slot, saved.view, saved.samples), (LVCBPT, 0, SAMPLES));
    let first = Picture::read(&saved.paths[0]).expect("a picture");
    assert_same_bits(&first, &headless(&Viewpoint::default(), LVCBPT, None), "lvcbpt");

    // The camera moves, seen small meanwhile, while another integrator is asked for.
    for view in 1..=6 {
        stage.navigator.orbit(0.01, 0.004);
        let moved = Request { moving: true, ..request(&stage.navigator, PATH, view) };
        stage.worker.request(moved, true);
        std::thread::sleep(Duration::from_millis(30));
    }
    stage.wait(|snapshot| snapshot.view == 6 && snapshot.picture.width < options().view.width);
    stage.worker.request(request(&stage.navigator, PATH, 6), false);
    let seen = stage.finish(PATH, 6);
    let saved = stage.save(folder.path().join("b"));
    let second = Picture::read(&saved.paths[0]).expect("a picture");
    let args = stage.navigator.viewpoint();
    assert!(args.look_from.is_some(), "it has moved");
    assert_same_bits(&second, &headless(&args, PATH, None), "path, moved");
    assert_same_bits(&second, &seen.picture, "as seen");

    // Back to the first one's camera and integrator, whose film was for another view in between.
    stage.navigator.reset();
    stage.worker.request(request(&stage.navigator, LVCBPT, 7), true);
    stage.finish(LVCBPT, 7);
    let saved = stage.save(folder.path().join("c"));
    assert_same_bits(&Picture::read(&saved.paths[0]).expect("a picture"), &first, "lvcbpt again");
}

/// Path tracing is seen until SPCBPT is trained; its model is saved, and makes the same picture. It is trained for
/// another view as well, and films of other methods are kept meanwhile.
#[test]
fn learns_in_the_background_and_takes_over() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = Stage::new(settings(gpu::context(), SPCBPT));
    stage.wait(|snapshot| snapshot.slot == PATH && snapshot.figures.samples > 0);
    let learnt = stage.finish(SPCBPT, 0).figures.learnt.clone().expect("a trained model");
    assert!(learnt.of_this_view && learnt.used > 1 && learnt.paths > 1000, "{learnt:?}");
    let saved = stage.save(folder.path().join("a"));
    let model = Model::load(&saved.paths[2], builtin("cornell").unwrap().content_hash()).expect("a model");
    assert_eq!(model.connections, methods()[SPCBPT].plan().connections, "trained for what is rendered");
    let picture = Picture::read(&saved.paths[0]).expect("a picture");
    assert_same_bits(&picture, &headless(&Viewpoint::default(), SPCBPT, Some(Arc::new(model))), "spcbpt");

    // The stand-in's film is kept: it is there again without rendering.
    stage.worker.request(Request { paused: true, ..request(&stage.navigator, PATH, 0) }, false);
    stage.wait(|snapshot| snapshot.slot == PATH && snapshot.figures.samples > 0);

    // Samples of another view are of no use, but its model is: it is used at once, and improved.
    stage.navigator.orbit(0.1, 0.02);
    stage.worker.request(request(&stage.navigator, SPCBPT, 1), true);
    let other = stage.wait(|snapshot| snapshot.slot == SPCBPT && snapshot.view == 1);
    assert!(other.figures.learnt.is_some());
    let of_view = |snapshot: &Snapshot| {
        snapshot.slot == SPCBPT && snapshot.figures.learnt.as_ref().is_some_and(|learnt| learnt.of_this_view)
    };
    stage.wait(|snapshot| snapshot.view == 1 && of_view(snapshot));
    let end = stage.finish(SPCBPT, 1);
    let path = headless(&stage.navigator.viewpoint(), PATH, None);
    let mean = |picture: &Picture| picture.rgb.as_flattened().iter().map(|&v| f64::from(v)).sum::<f64>();
    let ratio = mean(&end.picture) / mean(&path);
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

/// Two integrators take turns, each on its own film, until both have their samples.
#[test]
fn integrators_are_rendered_side_by_side() {
    let mut stage = Stage::new(settings(gpu::context(), LVCBPT));
    stage.worker.request(Request { beside: Some(PATH), ..request(&stage.navigator, LVCBPT, 0) }, false);
    let both = stage.wait(|snapshot| snapshot.beside.is_some() && snapshot.figures.done);
    assert_eq!((both.slot, both.figures.samples), (LVCBPT, SAMPLES));
    let (slot, beside) = both.beside.clone().expect("another picture");
    assert_eq!(slot, PATH);
    assert_same_bits(&beside, &without_layers(headless(&Viewpoint::default(), PATH, None)), "path beside");
    let seen = without_layers(headless(&Viewpoint::default(), LVCBPT, None));
    assert_same_bits(&both.picture, &seen, "lvcbpt");
}

fn without_layers(picture: Picture) -> Picture {
    Picture { layers: Vec::new(), ..picture }
}

/// A camera that never stands still has pictures all the same: small ones are finished, however soon the next request.
#[test]
fn pictures_come_while_the_camera_moves() {
    let settings = settings(gpu::context(), LVCBPT);
    let options = RenderOptions { view: View { width: 192, height: 144, ..options().view }, ..options() };
    let mut stage = Stage::new(Settings { options, ..settings });
    stage.wait(|snapshot| snapshot.slot == LVCBPT && snapshot.figures.samples > 0);
    let mut seen = std::collections::BTreeSet::new();
    let (start, mut view) = (Instant::now(), 0);
    while seen.len() < 4 {
        view += 1;
        stage.navigator.orbit(1e-3, 0.0);
        stage.worker.request(Request { moving: true, ..request(&stage.navigator, LVCBPT, view) }, true);
        std::thread::sleep(Duration::from_millis(3));
        let snapshot = stage.worker.snapshot();
        if snapshot.view > 0 && snapshot.picture.width < 192 {
            seen.insert(snapshot.view);
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{} views in a minute of movement", seen.len());
    }
}

/// Another scene in the same file: it is loaded and shown, by the same integrator from the same camera. One that cannot
/// be loaded changes nothing.
#[test]
fn scenes_are_loaded_again() {
    use std::sync::atomic::{AtomicBool, Ordering};
    static BROKEN: AtomicBool = AtomicBool::new(false);
    let loader = || match BROKEN.load(Ordering::Relaxed) {
        true => Err("it is damaged".to_string()),
        false => Ok(Arc::new(builtin("door").expect("a built-in scene"))),
    };
    let settings = Settings { loader: Box::new(loader), ..settings(gpu::context(), PATH) };
    let mut stage = Stage::new(settings);
    let cornell = stage.finish(PATH, 0);
    stage.worker.reload();
    let door =
        stage.wait(|now| now.number > cornell.number && now.figures.done && now.picture != cornell.picture);
    assert_eq!((door.slot, door.figures.samples), (PATH, SAMPLES));
    let loaded = |event: &&Event| matches!(event, Event::Loaded(scene) if scene.name == "door");
    assert_eq!(stage.events.iter().filter(loaded).count(), 1);
    BROKEN.store(true, Ordering::Relaxed);
    stage.worker.reload();
    let start = Instant::now();
    let said = loop {
        match stage.worker.event() {
            Some(Event::Failed(message)) => break message,
            _ => std::thread::sleep(Duration::from_millis(5)),
        }
        assert!(start.elapsed() < Duration::from_secs(60), "no event says that it failed");
    };
    assert_eq!(said, "it is damaged");
    assert_eq!(stage.worker.snapshot().picture, door.picture);
}

/// A lost device is reported, and the last picture is still there to be saved.
#[test]
fn r08_a_lost_device_keeps_the_last_picture() {
    let context = Context::new(&DeviceChoice::Auto).expect("a device");
    let settings = Settings { samples: None, ..settings(&context, PATH) };
    let mut stage = Stage::new(settings);
    stage.worker.request(Request { samples: None, ..request(&stage.navigator, PATH, 0) }, false);
    stage.wait(|snapshot| snapshot.figures.samples > 8);
    context.device.destroy();
    let start = Instant::now();
    let lost = loop {
        match stage.worker.event() {
            Some(Event::Lost(message)) => break message,
            Some(Event::Failed(message)) => panic!("{message}"),
            _ => std::thread::sleep(Duration::from_millis(5)),
        }
        assert!(start.elapsed() < Duration::from_secs(60), "no event says that the device is lost");
    };
    assert!(!lost.is_empty());
    let snapshot = stage.worker.snapshot();
    assert!(snapshot.figures.samples > 8 && snapshot.picture.rgb.iter().flatten().any(|&value| value > 0.0));
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_desktop_the_headless_command_is_named() {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_halfway"));
    command.args(["preview", "builtin:cornell"]);
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    let output = command.output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("no desktop") && said.contains("halfway render"), "{said}");
}
