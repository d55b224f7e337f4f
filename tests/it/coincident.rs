//! Surfaces that lie in one another have one answer for every ray and every integrator.

use glam::{DMat3, DVec3, Mat3, Vec3};
use halfway::accel::{Accel, Coincidence};
use halfway::integrator::{Bdpt, Connections, LightTracing, LvcBpt, Method, SpcBpt, View};
use halfway::render::RenderOptions;
use halfway::scene::builtin::shapes;
use halfway::scene::{AlphaMode, Camera, Material, Mesh, Projection, Scene};
use halfway::subspace::Settings;
use halfway::training::Training;

use crate::bidirectional::{mean, renders};
use crate::judge::{grey, horizontal, lamp, scene};
use crate::random::Stream;
use crate::shots::options;
use crate::stats::Moments;
use crate::traversal::{self, NO_TRIANGLE, Ray};

/// From one unit square to another that faces it at distance 1.
const FORM_FACTOR: f64 = 0.199_824_895_698_387_46;

const METHODS: [Method; 5] = [
    Method::Path,
    Method::Bdpt(Bdpt { light_tracing: false }),
    Method::LvcBpt(LvcBpt {
        light_paths: Some(256),
        connections: Connections::even(2),
        light_tracing: false,
    }),
    Method::SpcBpt(SpcBpt {
        light_paths: Some(256),
        connections: Connections::even(2),
        light_tracing: false,
    }),
    Method::Light(LightTracing { light_paths: None }),
];

/// Turned by no simple angle, of no simple size, and with vertices as a file would have them: planes that were one
/// differ by rounding.
fn turned(mut scene: Scene, size: f64) -> Scene {
    let turn = DMat3::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 0.7);
    for position in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions) {
        *position = (turn * *position * size).as_vec3().as_dvec3();
    }
    let turn_f32: Mat3 = turn.as_mat3();
    for camera in &mut scene.cameras {
        camera.position = turn * camera.position * size;
        for axis in [&mut camera.right, &mut camera.up, &mut camera.forward] {
            *axis = turn_f32 * *axis;
        }
        if let Projection::Orthographic { xmag, ymag } = &mut camera.projection {
            *xmag *= size as f32;
            *ymag *= size as f32;
        }
    }
    scene
}

/// A floor of a unit square and albedo 1/2, one unit below `above`, and a camera that sees all of it.
fn over_the_floor<const N: usize>(above: [(Material, Mesh); N]) -> Scene {
    let mut all = scene(above);
    let material = all.materials.len() as u32;
    all.materials.push(grey(0.5));
    all.meshes.push(Mesh { material, ..horizontal(1.0, 0.0, true) });
    all.cameras.push(Camera {
        name: "above".into(),
        position: DVec3::Y * 0.5,
        right: Vec3::X,
        up: Vec3::NEG_Z,
        forward: Vec3::NEG_Y,
        projection: Projection::Orthographic { xmag: 0.5, ymag: 0.5 },
    });
    all
}

/// Light that the floor scatters once.
#[track_caller]
fn assert_lit(what: &str, scene: &Scene, methods: &[Method], expected: f64) {
    for &method in methods {
        let base = options([16, 16], 32);
        let settings = Settings { subspaces: Some(8), ..Settings::default() };
        let render = RenderOptions {
            view: View { max_depth: Some(2), ..base.view },
            method,
            training: Training { paths: Some(1000), settings, ..Training::default() },
            ..base
        };
        let means: Moments = renders(scene, &render, 0..8).iter().map(|picture| mean(picture)).collect();
        let name = format!("{what}, {}", method.name());
        println!("{name}: {:.5} +- {:.5} of it", means.mean / expected, means.standard_error() / expected);
        means.assert_mean(&name, expected, 2e-2);
    }
}

#[test]
fn c25_a_lamp_in_the_ceiling_is_whole() {
    let ceiling = (grey(0.0), horizontal(1.7, 1.0, false));
    let lamp = (lamp(1.0), horizontal(1.0, 1.0, false));
    assert_lit("lamp", &over_the_floor([ceiling.clone(), lamp.clone()]), &METHODS[..2], 0.5 * FORM_FACTOR);
    assert_lit("turned", &turned(over_the_floor([lamp, ceiling]), 300.0), &METHODS, 0.5 * FORM_FACTOR);
}

/// The brighter one shines where both are; by symmetry each half of the square lights half of the floor's light.
#[test]
fn c25_of_two_lamps_in_one_plane_the_brighter_shines() {
    let half = shapes::quad(DVec3::new(0.0, 1.0, -0.5), DVec3::X * 0.5, DVec3::Z);
    let lamps = [(lamp(1.0), horizontal(1.0, 1.0, false)), (lamp(3.0), half)];
    assert_lit("two lamps", &turned(over_the_floor(lamps), 0.003), &METHODS, 0.5 * FORM_FACTOR * 2.0);
}

/// A lamp that is there to a quarter, in the ceiling.
#[test]
fn c25_a_blended_lamp_in_the_ceiling_shines_as_far_as_it_is_there() {
    let blended = Material { alpha: 0.25, alpha_mode: AlphaMode::Blend, ..lamp(4.0) };
    let lamps = [(grey(0.0), horizontal(1.7, 1.0, false)), (blended, horizontal(1.0, 1.0, false))];
    assert_lit("blended", &turned(over_the_floor(lamps), 1.0), &METHODS[..2], 0.5 * FORM_FACTOR);
}

/// Faces that stand twice, or fifty times, count once.
#[test]
fn c25_emitters_that_stand_twice_count_once() {
    let once = horizontal(1.0, 1.0, false);
    for copies in [2, 50] {
        let mut several = once.clone();
        several.triangles = once.triangles.iter().copied().cycle().take(2 * copies).collect();
        let scene = turned(over_the_floor([(lamp(1.0), several)]), 40.0);
        let accel = Accel::build(&scene).expect("a BVH");
        let hidden = 2 * (copies - 1);
        let expected = Coincidence { hidden, hidden_emitters: hidden, ..Coincidence::default() };
        assert_eq!((accel.coincidence, accel.triangles.len()), (expected, 4));
        if copies == 50 {
            assert_lit("fifty times", &scene, &METHODS[1..2], 0.5 * FORM_FACTOR);
        }
    }
}

/// Corners of the file's other order, of another mesh, and another material in front.
#[test]
fn c25_what_hides_both_sides_hides_a_face_of_the_same_corners() {
    let mut rotated = horizontal(1.0, 1.0, false);
    rotated.triangles.iter_mut().for_each(|triangle| triangle.rotate_left(1));
    let same = [
        (grey(0.3), horizontal(1.0, 1.0, false)),
        (lamp(1.0), rotated),
        (grey(0.3), horizontal(1.0, 1.0, true)),
    ];
    let accel = Accel::build(&over_the_floor(same.clone())).expect("a BVH");
    // The lamp is in front on its own side, one of the others on the other.
    let expected = Coincidence { hidden: 2, overlaps: 2, overlapping_emitters: 2, ..Coincidence::default() };
    assert_eq!(accel.coincidence, expected);
    assert_eq!(accel.triangles.iter().filter(|triangle| triangle.mesh == 1).count(), 2);

    // What may be absent hides nothing.
    let glass = Material { alpha: 0.5, alpha_mode: AlphaMode::Blend, ..grey(0.3) };
    let accel = Accel::build(&over_the_floor([same[0].clone(), (glass, same[0].1.clone())])).expect("a BVH");
    assert_eq!(accel.coincidence, Coincidence { overlaps: 2, ..Coincidence::default() });

    // Neighbours that share an edge do not overlap, folded or not; neither do faces back to back on edge.
    let accel = Accel::build(&turned(traversal::scene([shapes::icosphere(DVec3::ZERO, 1.0, 3)]), 7.0))
        .expect("a BVH");
    assert_eq!(accel.coincidence, Coincidence::default());
}

/// A wall with patches in its plane: from either side every ray meets what is in front there, whatever the order of
/// the file, and from the lamps' backs the wall.
#[test]
fn c25_every_ray_meets_the_same_surface() {
    let patch = |x: f64, y: f64, size: f64, up: bool| {
        let (u, v) = (DVec3::X * size, DVec3::Y * size);
        let corner = DVec3::new(x, y, 0.0);
        if up { shapes::quad(corner, u, v) } else { shapes::quad(corner, v, u) }
    };
    let mut parts = vec![
        ("wall", grey(0.5), patch(-1.0, -1.0, 2.0, true)),
        ("lamp to the front", lamp(1.0), patch(-0.7, -0.7, 0.9, true)),
        ("brighter lamp to the front", lamp(2.0), patch(0.0, 0.0, 0.6, true)),
        ("lamp to the back", lamp(1.0), patch(-0.2, -0.5, 0.6, false)),
    ];
    // Many small ones, so that their table has cells.
    for i in 0..100 {
        let place = |k: u32| 0.3 + 0.06 * f64::from(k);
        parts.push(("small lamp to the front", lamp(0.5), patch(place(i % 10), -place(i / 10), 0.05, true)));
    }
    let make = |order: &[usize]| {
        let mut scene = Scene::default();
        for &part in order {
            let (name, material, mesh) = parts[part].clone();
            scene.meshes.push(Mesh { name: name.into(), material: scene.materials.len() as u32, ..mesh });
            scene.materials.push(material);
        }
        turned(scene, 5.0)
    };
    let forwards: Vec<usize> = (0..parts.len()).collect();
    let backwards: Vec<usize> = forwards.iter().rev().copied().collect();
    let names = [forwards, backwards].map(|order| {
        let scene = make(&order);
        let accel = Accel::build(&scene).expect("a BVH");
        assert!(accel.coincidence.overlapping_emitters >= 6, "{:?}", accel.coincidence);
        let turn = DMat3::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 0.7);
        let mut stream = Stream::new(21);
        let mut targets = Vec::new();
        let rays: Vec<Ray> = (0..20_000)
            .map(|index| {
                let target = DVec3::new(2.0 * stream.f64() - 1.0, 2.0 * stream.f64() - 1.0, 0.0);
                let side = if index % 2 == 0 { 1.0 } else { -1.0 };
                let from = DVec3::new(
                    3.0 * stream.f64() - 1.5,
                    3.0 * stream.f64() - 1.5,
                    side * (0.1 + stream.f64()),
                );
                targets.push((target, side > 0.0));
                let unit = |point: DVec3| accel.unit.point(turn * point * 5.0);
                Ray::new(unit(from), unit(target) - unit(from))
            })
            .collect();
        let hits = traversal::closest(&accel, &rays);
        let mut wrong = 0;
        let names: Vec<&str> = hits
            .iter()
            .zip(&targets)
            .map(|(hit, &(target, front))| {
                assert_ne!(hit.triangle, NO_TRIANGLE);
                let name = &scene.meshes[accel.triangles[hit.triangle as usize].mesh as usize].name;
                let expected = in_front(target, front);
                // Rounding may decide within 1e-5 of an edge.
                let clear = [-1e-5, 1e-5].iter().all(|&d| {
                    in_front(target + DVec3::X * d, front) == expected
                        && in_front(target + DVec3::Y * d, front) == expected
                });
                wrong += usize::from(clear && name != expected);
                parts.iter().find(|part| part.0 == name).expect("a part").0
            })
            .collect();
        assert_eq!(wrong, 0, "of {} hits", names.len());
        names
    });
    let differing = names[0].iter().zip(&names[1]).filter(|(a, b)| a != b).count();
    assert!(differing <= 2, "{differing} hits depend on the file's order");
}

/// What is seen at a point of the wall of [`c25_every_ray_meets_the_same_surface`].
fn in_front(at: DVec3, front: bool) -> &'static str {
    let inside = |x: f64, y: f64, size: f64| at.x >= x && at.x < x + size && at.y >= y && at.y < y + size;
    if !front {
        return if inside(-0.2, -0.5, 0.6) { "lamp to the back" } else { "wall" };
    }
    let small = |i: u32| inside(0.3 + 0.06 * f64::from(i % 10), -0.3 - 0.06 * f64::from(i / 10), 0.05);
    match () {
        () if inside(0.0, 0.0, 0.6) => "brighter lamp to the front",
        () if inside(-0.7, -0.7, 0.9) => "lamp to the front",
        () if (0..100).any(small) => "small lamp to the front",
        () => "wall",
    }
}
