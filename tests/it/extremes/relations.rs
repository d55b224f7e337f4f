//! Changes of every scene that must leave its picture, or must change it in a known way.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Mutex;
use std::thread;

use glam::{DVec3, Vec3};
use halfway::film::Region;
use halfway::integrator::{Method, View};
use halfway::render::{Prepared, RenderOptions, Renderer, Uploaded};
use halfway::scene::builtin::{NAMES, builtin};
use halfway::scene::gltf::{LoadOptions, load};
use halfway::scene::{AlphaMode, Scene};
use halfway::subspace::Settings;
use halfway::training::Training;

use super::{METHODS, Table};
use crate::bidirectional::mean;
use crate::gpu;
use crate::metamorphic::{brightened, moved, reordered, scaled, snapped};
use crate::shots::options;
use crate::stats::{Moments, welch_p};

const SIZE: [u32; 2] = [24, 16];
/// In the middle.
const CROP: Region = Region { x: 7, y: 5, width: 10, height: 6, stride: 1 };
const SAMPLES: u32 = 8;
/// Pictures where means are compared.
const SEEDS: u64 = 6;
/// Of one comparison that noise alone explains, such that a page of a thousand has one in a thousand pages.
const CHANCE: f64 = 1e-6;

/// A column of the table.
struct Relation {
    name: &'static str,
    change: fn(&Scene) -> Scene,
    /// Radiances times two to this, bit for bit; `None` where paths may part ways.
    bits: Option<i32>,
}

const SCALES: [i32; 2] = [-40, 40];
const EXPOSURES: [i32; 2] = [-60, 60];

const RELATIONS: [Relation; 7] = [
    Relation { name: "size 2^-40", change: |scene| scaled(scene, SCALES[0]), bits: Some(0) },
    Relation { name: "size 2^40", change: |scene| scaled(scene, SCALES[1]), bits: Some(0) },
    Relation {
        name: "light 2^-60",
        change: |scene| brightened(scene, EXPOSURES[0]),
        bits: Some(EXPOSURES[0]),
    },
    Relation {
        name: "light 2^60",
        change: |scene| brightened(scene, EXPOSURES[1]),
        bits: Some(EXPOSURES[1]),
    },
    Relation { name: "place", change: elsewhere, bits: Some(0) },
    Relation { name: "faces twice", change: twice, bits: Some(0) },
    Relation { name: "order", change: reordered, bits: None },
];

/// A power of two above the size of the scene.
fn extent(scene: &Scene) -> f64 {
    let bounds = scene.bounds();
    let places = scene.cameras.iter().map(|camera| camera.position);
    let most = places.chain([bounds.low, bounds.high]).map(|place| place.abs().max_element());
    most.fold(f64::MIN_POSITIVE, f64::max).log2().ceil().exp2()
}

/// Places that can be moved without rounding.
fn on_a_grid(scene: Scene) -> Scene {
    let grid = extent(&scene) * 2f64.powi(-24);
    snapped(scene, grid)
}

fn elsewhere(scene: &Scene) -> Scene {
    moved(scene, extent(scene) * 2f64.powi(20) * DVec3::new(-1.0, 0.75, 0.5))
}

/// Every face stands twice. What may be absent hides nothing, so that stays.
fn twice(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for mesh in &mut scene.meshes {
        if scene.materials[mesh.material as usize].alpha_mode == AlphaMode::Opaque {
            mesh.triangles.extend(mesh.triangles.clone());
        }
    }
    scene
}

/// The files of `scenes/` and the built-in scenes.
fn scenes() -> Vec<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let entries = std::fs::read_dir(folder).expect("scenes");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("a file").path()).collect();
    files.retain(|file| file.extension().is_some_and(|end| end == "glb"));
    files.sort();
    let files = files.iter().map(|file| load(file, &LoadOptions::default()).expect("a scene"));
    let of_code = NAMES.iter().map(|name| {
        let scene = builtin(name).expect("a built-in scene");
        Scene { name: format!("builtin:{name}"), ..scene }
    });
    of_code.chain(files).map(on_a_grid).collect()
}

type Rgb = Vec<[f32; 3]>;

fn renderer(uploaded: &Uploaded, scene: &Scene, method: Method, crop: Option<Region>) -> Renderer {
    let base = options(SIZE, SAMPLES);
    let settings = Settings { subspaces: Some(16), ..Settings::default() };
    let options = RenderOptions {
        view: View { max_depth: Some(6), crop, ..base.view },
        method,
        training: Training { paths: Some(2000), settings, ..Training::default() },
        ..base
    };
    let prepared = Prepared::of(uploaded, &scene.cameras[0], options).expect("a render");
    prepared.renderer().expect("a renderer")
}

fn upload(scene: &Scene) -> Uploaded {
    Uploaded::new(gpu::context(), scene, None).expect("a scene on the device")
}

fn picture(renderer: &mut Renderer) -> Rgb {
    renderer.run(|_| false).expect("a render");
    assert_eq!(renderer.report().expect("a report").non_finite, 0, "samples that are not finite");
    renderer.picture().expect("a picture").rgb
}

/// Means of pictures from different seeds.
fn means(renderer: &mut Renderer, seeds: impl IntoIterator<Item = u64>) -> Moments {
    let mean_of = |seed| {
        renderer.restart(seed, None).expect("a restart");
        let rgb = picture(renderer);
        mean(&rgb.iter().map(|&rgb| Vec3::from(rgb).as_dvec3()).collect::<Vec<_>>())
    };
    seeds.into_iter().map(mean_of).collect()
}

/// A cell of the table, and whether it is right.
fn bits(found: &Rgb, expected: impl Iterator<Item = [f32; 3]>) -> (String, bool) {
    let differ = found.iter().zip(expected).filter(|(found, expected)| *found != expected).count();
    match differ {
        0 => ("=".into(), true),
        _ => (format!("{:.0} % differ", 100.0 * differ as f64 / found.len() as f64), false),
    }
}

fn light(found: &Moments, expected: &Moments) -> (String, bool) {
    let error = found.standard_error().hypot(expected.standard_error());
    let z = if error > 0.0 { (found.mean - expected.mean) / error } else { 0.0 };
    (format!("{z:+.1}"), welch_p(found, expected) > CHANCE)
}

/// Rows of one scene: a line for each integrator.
fn rows(scene: &Scene) -> Table {
    let mut cells: Vec<Vec<(String, bool)>> = vec![Vec::new(); METHODS.len()];
    let mut originals = Vec::new();
    let uploaded = upload(scene);
    for (method, cells) in METHODS.iter().zip(&mut cells) {
        let mut all = renderer(&uploaded, scene, *method, None);
        let rgb = picture(&mut all);
        let part = picture(&mut renderer(&uploaded, scene, *method, Some(CROP)));
        let inside = (0..rgb.len() as u32).filter(|pixel| {
            let (x, y) = (pixel % SIZE[0], pixel / SIZE[0]);
            (CROP.x..CROP.x + CROP.width).contains(&x) && (CROP.y..CROP.y + CROP.height).contains(&y)
        });
        cells.push(match method.plan().learns() {
            // From the paths of the part alone.
            true => ("-".into(), true),
            false => bits(&part, inside.map(|pixel| rgb[pixel as usize])),
        });
        originals.push((rgb, means(&mut all, 1..=SEEDS)));
    }
    for relation in &RELATIONS {
        let changed = (relation.change)(scene);
        let uploaded = upload(&changed);
        for ((method, cells), (rgb, light_of)) in METHODS.iter().zip(&mut cells).zip(&originals) {
            let mut renderer = renderer(&uploaded, &changed, *method, None);
            cells.push(match relation.bits {
                Some(k) => {
                    let factor = 2f32.powi(k);
                    bits(&picture(&mut renderer), rgb.iter().map(|rgb| rgb.map(|c| c * factor)))
                }
                None => light(&means(&mut renderer, 101..=100 + SEEDS), light_of),
            });
        }
    }
    let mut table = Table::default();
    for (method, cells) in METHODS.iter().zip(&cells) {
        let texts: Vec<&str> = cells.iter().map(|(text, _)| text.as_str()).collect();
        let _ = writeln!(table.text, "| `{}` | `{}` | {} |", scene.name, method.name(), texts.join(" | "));
        let names = std::iter::once("part").chain(RELATIONS.iter().map(|relation| relation.name));
        for (name, (text, _)) in names.zip(cells).filter(|(_, (_, right))| !right) {
            table.faults.push(format!("{}, {}, {name}: {text}", scene.name, method.name()));
        }
    }
    println!("{}", table.text);
    table
}

/// All relations of all scenes, by two threads: the host's work of one beside the device's of the other.
pub fn table() -> Table {
    let names: Vec<&str> = RELATIONS.iter().map(|relation| relation.name).collect();
    let mut table = Table::default();
    let _ = writeln!(table.text, "| scene | integrator | part | {} |", names.join(" | "));
    let _ = writeln!(table.text, "|---|---|{}", "---|".repeat(names.len() + 1));
    let scenes = scenes();
    let next = Mutex::new(0..scenes.len());
    let done = Mutex::new((table, 0));
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(index) = next.lock().expect("no panic").next() else { break };
                    let rows = rows(&scenes[index]);
                    let (table, count) = &mut *done.lock().expect("no panic");
                    table.text += &rows.text;
                    table.faults.extend(rows.faults);
                    *count += 1;
                    table.publish("Relations", scenes.len(), *count);
                }
            });
        }
    });
    done.into_inner().expect("no panic").0
}
