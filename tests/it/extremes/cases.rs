//! Scenes at the extremes (`tests/cases/extremes`) with what physics says of them.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use std::fmt::Write as _;
use std::path::Path;

use halfway::integrator::View;
use halfway::render::RenderOptions;
use halfway::scene::Scene;
use halfway::scene::gltf::{LoadOptions, load};
use halfway::subspace::Settings;
use halfway::training::Training;

use super::{METHODS, Table};
use crate::bidirectional::{mean, renders};
use crate::cases::white;
use crate::shots::options;
use crate::stats::{Moments, student_two_sided};

const SEEDS: u64 = 8;
/// Of one value that noise alone explains.
const CHANCE: f64 = 1e-6;

/// A scene, and the mean of its picture.
struct Case {
    name: &'static str,
    scene: Scene,
    size: u32,
    samples: u32,
    depth: Option<u32>,
    /// Of [`METHODS`], those that can show it in seconds.
    methods: &'static [usize],
    right: f64,
    /// How well the right value is known.
    margin: f64,
    /// What version 0.1.0 gave.
    before: &'static str,
}

const ALL: &[usize] = &[0, 1, 2, 3, 4];
/// Those whose paths begin at the camera, for what no light path can be connected to.
const FROM_THE_CAMERA: &[usize] = &[0, 1, 2, 3];

fn file(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/extremes").join(format!("{name}.glb"));
    load(&path, &LoadOptions::default()).expect("a scene")
}

/// Irradiance over pi below a square lamp of radiance 1, from -`half` to `half` about `centre` in x and z, at a height: the
/// closed form of a rectangle with a corner straight above (Howell, configuration B-3), for each of four.
fn below_a_square([x, z]: [f64; 2], [centre_x, centre_z]: [f64; 2], half: f64, height: f64) -> f64 {
    let corner = |x: f64, z: f64| {
        let (a, b) = (x / height, z / height);
        let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
        (part(a, b) + part(b, a)) / TAU
    };
    let sides = |at: f64, centre: f64| [centre - half - at, centre + half - at];
    let ([x0, x1], [z0, z1]) = (sides(x, centre_x), sides(z, centre_z));
    corner(x1, z1) - corner(x0, z1) - corner(x1, z0) + corner(x0, z0)
}

/// Mean over a rectangle of the floor, which the pixels of the picture share evenly.
fn average(centre: [f64; 2], half: [f64; 2], value: impl Fn([f64; 2]) -> f64) -> f64 {
    // The edges of lamps fall between steps.
    const STEPS: u32 = 640;
    let at = |i: u32, axis: usize| {
        centre[axis] + half[axis] * (2.0 * (f64::from(i) + 0.5) / f64::from(STEPS) - 1.0)
    };
    let cells = (0..STEPS).flat_map(|x| (0..STEPS).map(move |z| (x, z)));
    cells.map(|(x, z)| value([at(x, 0), at(z, 1)])).sum::<f64>() / f64::from(STEPS * STEPS)
}

/// Half of what a camera sees of the floor below it.
fn half_seen(scene: &Scene) -> f64 {
    let camera = &scene.cameras[0];
    match camera.projection {
        halfway::scene::Projection::Perspective { yfov, .. } => {
            camera.position.y * (0.5 * f64::from(yfov)).tan()
        }
        halfway::scene::Projection::Orthographic { xmag, .. } => f64::from(xmag),
    }
}

/// 1 - cos, to the last digits of a small angle.
fn one_minus_cos(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// Lit once by a lamp above the floor, which hides what is straight below it from a camera further up.
fn lit(name: &'static str, lamp: (f64, [f64; 2], f64, f64), before: &'static str) -> Case {
    let (radiance, centre, half, height) = lamp;
    let scene = file(name);
    let seen = half_seen(&scene);
    let is_hidden = |[x, z]: [f64; 2]| (x - centre[0]).abs() < half && (z - centre[1]).abs() < half;
    let floor = |place| match is_hidden(place) {
        true => 0.0,
        false => 0.5 * radiance * below_a_square(place, centre, half, height),
    };
    let right = average([0.0; 2], [seen; 2], floor);
    Case { name, scene, size: 16, samples: 32, depth: Some(2), methods: ALL, right, margin: 1e-5, before }
}

fn cases() -> Vec<Case> {
    let case = |name: &'static str, right: f64, before: &'static str| Case {
        name,
        scene: file(name),
        size: 16,
        samples: 32,
        depth: None,
        methods: ALL,
        right,
        margin: 1e-5 * right,
        before,
    };
    // The lamp's plate reflects as well: L = .5 (1 + .5 L). No light path meets the few micrometres that are seen.
    let plates = |name, before| Case { methods: FROM_THE_CAMERA, ..case(name, 2.0 / 3.0, before) };
    let spot = |name, angle: f64, samples| Case {
        depth: Some(2),
        samples,
        // A linear ramp's square in the cosine, over the four units of area that are seen.
        ..case(name, 0.5 / PI * TAU * one_minus_cos(angle) / 3.0 / 4.0, "")
    };
    // Of a parallel camera at 45 degrees, whose rays end about (.8, 0) of the floor.
    let far = average([0.8, 0.0], [0.1 / FRAC_1_SQRT_2, 0.1], |place| {
        0.5 * below_a_square(place, [0.0; 2], 1.0, 1.0)
    });
    vec![
        lit("coplanar_one_lamp_below_ceiling", (1.0, [0.0; 2], 0.8, 0.499), ".371"),
        lit(
            "coplanar_lamp_coplanar_with_ceiling",
            (1.0, [0.0; 2], 0.8, 0.5),
            "path .270, bdpt .271, lvcbpt .323, spcbpt .326, light .379",
        ),
        lit("coplanar_emitters", (3.0, [0.0; 2], 1.0, 1.0), "path .848"),
        case("duplicates_2", 2.0, "2.379"),
        case("duplicates_50", 2.0, "3.52"),
        plates("plates_2^-12", ".667"),
        plates("plates_2^-20", "0"),
        Case { size: 4, samples: 8, methods: &[0], ..case("furnace_0.999", 1000.0, "1000") },
        Case { before: "38 % of it", ..spot("spot_.035", 0.035, 256) },
        Case { before: "about 0", methods: &[4], ..spot("spot_1e-3", 1e-3, 32) },
        lit("sealed_ratio_1e+20", (1.0, [0.2, 0.0], 0.2, 0.5), "variance 0"),
        lit("sealed_ratio_1e+25", (1.0, [0.2, 0.0], 0.2, 0.5), "variance 0"),
        Case { margin: 1e-4, depth: Some(2), ..case("far_camera_1e+07", far, "") },
        // Known to three digits, lit once.
        Case { margin: 5e-5, depth: Some(2), ..case("tiny_triangle_1e-12", 0.0346, ".0346") },
        Case { margin: 5e-5, depth: Some(2), ..case("tiny_triangle_1e-20", 0.0346, "light: 0") },
    ]
}

/// Five digits, of small numbers as well.
fn digits(value: f64) -> String {
    if value.abs() < 0.01 { format!("{value:.4e}") } else { format!("{value:.5}") }
}

/// Rough glass in a white room, whose light is that of the room if nothing is lost between its facets.
fn balls() -> Vec<(String, Scene)> {
    let ball = |roughness: f32, ior: f32| {
        let mut scene = file("ball_rg1");
        scene.environment = Some(white());
        scene.materials[0].roughness = roughness;
        scene.materials[0].ior = ior;
        (format!("ball of roughness {roughness}, index {ior:e}"), scene)
    };
    [(0.3, 1.5), (1.0, 1.5), (0.3, 1.0001), (0.3, 1.01), (0.3, 1.02), (0.5, 1e38)]
        .map(|(r, n)| ball(r, n))
        .into()
}

/// Of pictures from different seeds.
fn measured(scene: &Scene, method: usize, size: u32, samples: u32, depth: Option<u32>) -> Moments {
    let base = options([size, size], samples);
    let settings = Settings { subspaces: Some(16), ..Settings::default() };
    let options = RenderOptions {
        view: View { max_depth: depth, ..base.view },
        method: METHODS[method],
        training: Training { paths: Some(2000), settings, ..Training::default() },
        ..base
    };
    renders(scene, &options, 0..SEEDS).iter().map(|picture| mean(picture)).collect()
}

/// Values of all cases.
pub fn table() -> Table {
    let mut table = Table::default();
    let _ = writeln!(
        table.text,
        "| case | integrator | 0.1.0 | value | right value | z |\n|---|---|---|--:|--:|--:|"
    );
    let (cases, balls) = (cases(), balls());
    let of = cases.len() + balls.len();
    for (done, case) in cases.iter().enumerate() {
        table.publish("Cases", of, done);
        for &method in case.methods {
            let found = measured(&case.scene, method, case.size, case.samples, case.depth);
            let (value, error) = (found.mean, found.standard_error().hypot(case.margin));
            let z = (value - case.right) / error;
            let name = METHODS[method].name();
            let row = format!(
                "| `{}` | `{name}` | {} | {} +- {} | {} | {z:+.1} |",
                case.name,
                case.before,
                digits(value),
                digits(error),
                digits(case.right)
            );
            println!("{row}");
            let _ = writeln!(table.text, "{row}");
            let likely = student_two_sided(z, (SEEDS - 1) as f64) > CHANCE;
            // What is within a hundredth cannot be told from noise by so few seeds anyway.
            if !likely || error > 0.1 * case.right {
                table.faults.push(row);
            }
        }
    }
    for (index, (name, scene)) in balls.iter().enumerate() {
        table.publish("Cases", of, cases.len() + index);
        for &method in FROM_THE_CAMERA {
            let found = measured(scene, method, 16, 32, Some(16));
            let row = format!(
                "| {name} | `{}` | | {:.4} +- {:.4} | | |",
                METHODS[method].name(),
                found.mean,
                found.standard_error()
            );
            println!("{row}");
            let _ = writeln!(table.text, "{row}");
        }
    }
    table.publish("Cases", of, of);
    table
}
