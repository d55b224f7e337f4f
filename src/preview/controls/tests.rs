use glam::Vec3;
use proptest::prelude::*;

use super::*;
use crate::scene::builtin::{builtin, shapes};

const SCALES: [f64; 3] = [1e-6, 1.0, 1e6];
const PARALLEL: Projection = Projection::Orthographic { xmag: 2.0, ymag: 1.5 };

/// A box of a few units, `away` from the origin, before a perspective and a parallel camera.
fn scene(scale: f64, away: f64) -> Scene {
    let place = |x, y, z| DVec3::new(x + away, y - away, z + 0.5 * away) * scale;
    let low = shapes::quad(place(-1.0, -0.5, -1.0), DVec3::X * 2.0 * scale, DVec3::Z * 2.0 * scale);
    let high = shapes::quad(place(-1.0, 1.0, -1.0), DVec3::X * 2.0 * scale, DVec3::Z * 2.0 * scale);
    let perspective = shapes::looking_at("a", place(3.0, 2.0, 5.0), place(0.0, 0.0, 0.0), 50.0);
    let parallel = PARALLEL.with_height(3.0 * scale).unwrap();
    let parallel = Camera { name: "b".into(), projection: parallel, ..perspective.clone() };
    Scene { meshes: vec![low, high], cameras: vec![perspective, parallel], ..Scene::default() }
}

fn navigator(scene: &Scene, camera: &str) -> Navigator {
    Navigator::new(scene, &Viewpoint { camera: Some(camera.into()), ..Viewpoint::default() }).unwrap()
}

/// Where a point is seen, in heights of the picture, from its middle to the right and down.
fn seen(camera: &Camera, point: DVec3) -> [f64; 2] {
    let [right, up, forward] = [camera.right, camera.up, camera.forward].map(|axis| axis.as_dvec3());
    let way = point - camera.position;
    let height = camera.projection.height_at(way.dot(forward));
    [way.dot(right) / height, -way.dot(up) / height]
}

#[test]
fn what_has_not_moved_is_the_scenes_own() {
    for (name, index) in [("cornell", 0), ("plates", 1)] {
        let scene = builtin(name).unwrap();
        let own = &scene.cameras[index];
        let mut navigator = navigator(&scene, &index.to_string());
        navigator.set_pivot_distance(0.123);
        navigator.orbit(0.0, 0.0);
        navigator.look(0.0, 0.0);
        navigator.pan(0.0, 0.0);
        navigator.dolly(0.0);
        navigator.fly(0.0, 0.0, 0.0, 1.0, true);
        navigator.orbit(f64::NAN, 1.0);
        assert!(!navigator.moved());
        assert_eq!((&navigator.camera(), navigator.flags()), (own, format!("--camera {index}")));
        navigator.orbit(0.1, 0.2);
        assert!(navigator.moved() && navigator.camera() != *own);
        navigator.reset();
        assert_eq!((&navigator.camera(), navigator.moved()), (own, false));
    }
    let named = Navigator::new(&scene(1.0, 0.0), &Viewpoint::default()).unwrap();
    assert_eq!(named.flags(), "--camera a");
    let given = Viewpoint {
        camera: Some("b".into()),
        look_from: Some(DVec3::new(1.0, 2.0, 3.0)),
        look_at: Some(DVec3::NEG_Z),
        ortho_height: Some(2.5),
        ..Viewpoint::default()
    };
    let mut navigator = Navigator::new(&scene(1.0, 0.0), &given).unwrap();
    assert_eq!((navigator.viewpoint(), navigator.camera().position), (given, DVec3::new(1.0, 2.0, 3.0)));
    assert!((navigator.pivot() - DVec3::NEG_Z).length() < 1e-6);
    navigator.pan(0.1, 0.1);
    assert!(navigator.flags().starts_with("--camera b --look-from "), "{}", navigator.flags());
    assert!(navigator.flags().ends_with(" --ortho-height 2.5"), "{}", navigator.flags());
}

#[test]
fn orbiting_keeps_the_pivot_and_never_flips() {
    for scale in SCALES {
        let mut navigator = navigator(&scene(scale, 10.0), "a");
        let (pivot, distance) = (navigator.pivot(), navigator.pivot_distance());
        let before = seen(&navigator.camera(), pivot + DVec3::Y * 0.1 * scale)[1];
        navigator.orbit(0.1, 0.0);
        // In front of the pivot, things follow the pointer to the right; the camera went to the left.
        let near = pivot - navigator.start.forward.as_dvec3() * 0.1 * scale;
        assert!(seen(&navigator.camera(), near)[0] > 0.0);
        let after = seen(&navigator.camera(), pivot + DVec3::Y * 0.1 * scale)[1];
        assert!((before - after).abs() < 1e-6, "the axis is upright");
        for dy in [3.0, -0.2, -50.0] {
            navigator.orbit(0.7, dy);
            let camera = navigator.camera();
            assert!((camera.position.distance(pivot) / distance - 1.0).abs() < 1e-9);
            assert!(camera.point_ahead(distance).distance(pivot) < 1e-6 * distance);
            assert!(camera.up.y > 0.0 && camera.right.y.abs() < 1e-6);
        }
        assert!(navigator.camera().forward.y > 0.999, "dragged up, seen from below");
    }
}

#[test]
fn what_is_at_the_pivot_follows_the_pointer() {
    for (scale, name) in SCALES.into_iter().flat_map(|scale| [(scale, "a"), (scale, "b")]) {
        let scene = scene(scale, 10.0);
        let mut navigator = navigator(&scene, name);
        navigator.set_pivot_distance(2.0 * scale);
        let right = navigator.camera().right.as_dvec3();
        let points = [navigator.pivot(), navigator.pivot() + right * 0.3 * scale];
        for (dx, dy) in [(0.25, -0.125), (-0.5, 0.75)] {
            let before = points.map(|point| seen(&navigator.camera(), point));
            navigator.pan(dx, dy);
            for (point, [x, y]) in points.into_iter().zip(before) {
                let [now_x, now_y] = seen(&navigator.camera(), point);
                assert!((now_x - x - dx).abs() < 2e-6 && (now_y - y - dy).abs() < 2e-6);
            }
        }
    }
}

#[test]
fn the_wheel_comes_closer_and_never_through() {
    for scale in SCALES {
        let mut near = navigator(&scene(scale, 10.0), "a");
        let (pivot, distance) = (near.pivot(), near.pivot_distance());
        near.dolly(1.0);
        assert!((near.camera().position.distance(pivot) / distance - 0.9).abs() < 1e-9);
        near.dolly(-1.0);
        assert!((near.pivot_distance() / distance - 1.0).abs() < 1e-9);
        near.dolly(1e4);
        assert!(near.pivot_distance() > 0.0 && near.pivot().distance(pivot) < 1e-9 * distance);
        near.dolly(-1e5);
        assert!(near.pivot_distance() > 1e3 * distance && near.camera().position.is_finite());

        let mut wide = navigator(&scene(scale, 10.0), "b");
        wide.dolly(2.0);
        let Projection::Orthographic { xmag, ymag } = wide.camera().projection else { panic!("a lens") };
        let scale = scale as f32;
        assert!((ymag / (1.5 * 0.81 * scale) - 1.0).abs() < 1e-6, "{ymag}");
        assert!((xmag / (2.0 * 0.81 * scale) - 1.0).abs() < 1e-6, "{xmag}");
        assert_eq!(wide.camera().position, wide.start.position);
    }
}

#[test]
fn looking_stays_and_flying_does_not_turn() {
    for scale in SCALES {
        let mut navigator = navigator(&scene(scale, 10.0), "a");
        let (before, distance) = (navigator.camera(), navigator.pivot_distance());
        navigator.look(0.25, 0.0);
        let camera = navigator.camera();
        assert_eq!(camera.position, before.position);
        assert!(camera.forward.dot(before.right) > 0.1 && camera.forward.y == before.forward.y);
        navigator.look(0.0, 0.25);
        assert!(navigator.camera().forward.y < before.forward.y, "down");
        assert!((navigator.pivot().distance(before.position) / distance - 1.0).abs() < 1e-9);
        navigator.look(0.3, -90.0);
        assert!(navigator.camera().up.y > 0.0);

        navigator.reset();
        navigator.fly(1.0, 2.0, -1.0, 0.5, false);
        let radius = navigator.bounds.radius();
        let way = navigator.camera().position - before.position;
        let expected = 0.25 * radius * (before.right - before.forward + 2.0 * Vec3::Y).as_dvec3();
        assert!((way - expected).length() < 1e-6 * radius);
        assert!((navigator.camera().forward - before.forward).length() < 1e-6);
        navigator.reset();
        navigator.fly(1.0, 2.0, -1.0, 0.125, true);
        assert!((navigator.camera().position - before.position - way).length() < 1e-6 * radius);
    }
}

#[test]
fn all_is_framed() {
    for (scale, name) in SCALES.into_iter().flat_map(|scale| [(scale, "a"), (scale, "b")]) {
        let scene = scene(scale, 10.0);
        for aspect in [0.25, 1.0, 2.5] {
            let mut navigator = navigator(&scene, name);
            navigator.fly(1.0, 3.0, 40.0, 1.0, false);
            navigator.look(0.7, 0.3);
            navigator.frame_all(aspect);
            let bounds = scene.bounds();
            let [right, up, forward] = navigator.view.axes();
            let mut most = [0.0f64; 2];
            for turn in 0..3600 {
                let (sin, cos) = (f64::from(turn) * TAU / 3600.0).sin_cos();
                for side in [right, up] {
                    let point = bounds.centre() + (side * sin + forward * cos) * bounds.radius();
                    assert!((point - navigator.from()).dot(forward) > 0.0);
                    let [x, y] = seen(&navigator.camera(), point);
                    most = [most[0].max(x.abs() / aspect), most[1].max(y.abs())];
                }
            }
            let most = most[0].max(most[1]);
            assert!((0.499..0.500_01).contains(&most), "touches the edge: {most}, {name}, {aspect}");
        }
    }
}

#[test]
fn rolled_cameras_and_those_above_go_on_as_they_are() {
    let camera = |right: Vec3, up: Vec3| {
        let (position, projection) = (DVec3::new(0.2, 4.0, 0.1), Projection::Perspective { yfov: 0.7 });
        Camera { name: "a".into(), position, right, up, forward: up.cross(right), projection }
    };
    let rolled = Vec3::new(0.6, 0.8, 0.0);
    for (camera, rolls) in [
        (camera(Vec3::X, Vec3::NEG_Z), false),
        (camera(Vec3::Z, Vec3::X), false),
        (camera(Vec3::X, Vec3::Z), false),
        (camera(rolled, Vec3::new(-0.8, 0.6, 0.0)), true),
        (camera(rolled, Vec3::NEG_Z), true),
        (camera(Vec3::X, Vec3::NEG_Y), true),
    ] {
        let scene = Scene { cameras: vec![camera.clone()], ..scene(1.0, 0.0) };
        let mut navigator = navigator(&scene, "a");
        navigator.pan(0.1, 0.1);
        let moved = navigator.camera();
        assert!(moved.position != camera.position);
        for (now, before) in
            [(moved.right, camera.right), (moved.up, camera.up), (moved.forward, camera.forward)]
        {
            assert!((now - before).length() < 1e-6, "{moved:?} {camera:?}");
        }
        // What is nearest follows the pointer all the same.
        let near = navigator.pivot() - camera.forward.as_dvec3() * 0.01;
        let [x, _] = seen(&navigator.camera(), near);
        navigator.orbit(0.01, 0.0);
        assert!(seen(&navigator.camera(), near)[0] > x, "{camera:?}");
        let upright = navigator.camera().right.y.abs() < 1e-6 && navigator.camera().up.y > 0.0;
        assert_eq!(upright, !rolls, "{camera:?}");
    }
}

#[derive(Clone, Debug)]
enum Move {
    Orbit(f64, f64),
    Pan(f64, f64),
    Dolly(f64),
    Look(f64, f64),
    Fly([f64; 3], f64, bool),
    Frame(f64),
    Pivot(f64),
}

fn moves() -> impl Strategy<Value = Move> {
    let way = || -2.0..2.0f64;
    prop_oneof![
        (way(), way()).prop_map(|(x, y)| Move::Orbit(x, y)),
        (way(), way()).prop_map(|(x, y)| Move::Pan(x, y)),
        (-30.0..30.0f64).prop_map(Move::Dolly),
        (way(), way()).prop_map(|(x, y)| Move::Look(x, y)),
        (prop::array::uniform3(-1.0..1.0f64), 0.0..10.0f64, any::<bool>())
            .prop_map(|(way, seconds, fast)| Move::Fly(way, seconds, fast)),
        (0.1..4.0f64).prop_map(Move::Frame),
        prop::num::f64::ANY.prop_map(Move::Pivot),
    ]
}

proptest! {
    #[test]
    fn any_moves_leave_a_camera_that_its_viewpoint_makes_again(
        exponent in -6..=6i32,
        away in prop::sample::select(vec![0.0, 1.0, 1e4]),
        name in prop::sample::select(vec!["a", "b"]),
        roll in prop::option::of(-3.2..3.2f32),
        moves in prop::collection::vec(moves(), 1..40),
    ) {
        let mut scene = scene(10f64.powi(exponent), away);
        for camera in &mut scene.cameras {
            let turn = glam::Quat::from_axis_angle(camera.forward, roll.unwrap_or(0.0));
            (camera.right, camera.up) = (turn * camera.right, turn * camera.up);
        }
        let mut navigator = navigator(&scene, name);
        for step in moves {
            match step {
                Move::Orbit(x, y) => navigator.orbit(x, y),
                Move::Pan(x, y) => navigator.pan(x, y),
                Move::Dolly(steps) => navigator.dolly(steps),
                Move::Look(x, y) => navigator.look(x, y),
                Move::Fly([x, y, z], seconds, fast) => navigator.fly(x, y, z, seconds, fast),
                Move::Frame(aspect) => navigator.frame_all(aspect),
                Move::Pivot(distance) => navigator.set_pivot_distance(distance.abs().min(1e9)),
            }
            let camera = navigator.camera();
            let (right, up, forward) = (camera.right, camera.up, camera.forward);
            prop_assert!(camera.position.is_finite() && navigator.pivot().is_finite());
            for (a, b) in [(right, up), (up, forward), (forward, right)] {
                prop_assert!(a.dot(b).abs() < 3e-7 && (a.length() - 1.0).abs() < 3e-7);
            }
            prop_assert!(right.cross(up).dot(forward) < -0.999_99);
            let expected = navigator.view.axes()[2].as_vec3();
            prop_assert!((forward - expected).length() < 1e-5, "{:?}", forward - expected);

            let mut again = scene.clone();
            let viewpoint = navigator.viewpoint();
            let index = viewpoint.choose(&mut again).unwrap();
            // Floats are written so that no two look alike.
            prop_assert_eq!(format!("{:?}", again.cameras[index]), format!("{camera:?}"), "{}", viewpoint);
            let restarted = Navigator::new(&scene, &viewpoint).unwrap();
            prop_assert_eq!(restarted.camera(), camera);
            prop_assert_eq!(restarted.flags(), navigator.flags());
        }
    }
}
