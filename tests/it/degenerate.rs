//! Triangles that are none: left out, counted, and without any effect on the picture (N-08).

use glam::{DVec3, Vec3};
use halfway::accel::Accel;
use halfway::integrator::View;
use halfway::render::{Budget, RenderOptions, Renderer};
use halfway::scene::builtin::shapes::{looking_at, quad};
use halfway::scene::{LightKind, Material, Mesh, PunctualLight, Scene};

use crate::gpu;
use crate::random::Stream;

/// A wall with a lamp before it, and far behind it a second wall that is not seen.
fn good_scene() -> Scene {
    let wall = quad(DVec3::new(-1.0, -1.0, 0.0), 2.0 * DVec3::X, 2.0 * DVec3::Y);
    let hidden = quad(DVec3::new(-1.0, -1.0, -1.0), 2.0 * DVec3::X, 2.0 * DVec3::Y);
    Scene {
        materials: vec![Material::lambert("wall", Vec3::splat(0.6))],
        meshes: vec![wall, hidden],
        lights: vec![PunctualLight {
            name: "lamp".into(),
            kind: LightKind::Point,
            position: DVec3::new(0.3, 0.5, 1.5),
            direction: Vec3::NEG_Z,
            intensity: Vec3::splat(4.0),
        }],
        cameras: vec![looking_at("camera", DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, 60.0)],
        ..Scene::default()
    }
}

/// The corners of a triangle without a face.
fn degenerate(kind: u32, stream: &mut Stream) -> [DVec3; 3] {
    let mut point = || {
        DVec3::new(stream.f64() - 0.5, stream.f64() - 0.5, -0.25 - 0.5 * stream.f64()).as_vec3().as_dvec3()
    };
    let (a, b) = (point(), point());
    match kind % 9 {
        0 => [a, a, a],
        1 => [a, a, b],
        2 => [a, b, b],
        3 => [b, a, b],
        // Exactly collinear.
        4 => [a, a + DVec3::X, a - DVec3::X],
        5 => [a, DVec3::new(f64::NAN, 0.0, 0.0), b],
        6 => [a, b, DVec3::new(0.0, f64::INFINITY, 0.0)],
        7 => [DVec3::NEG_INFINITY, b, DVec3::NAN],
        _ => [DVec3::ZERO, 1e30 * DVec3::X, 2e30 * DVec3::X],
    }
}

/// A sliver with aspect 1e7, which does have a face, between the walls.
fn sliver(stream: &mut Stream) -> [DVec3; 3] {
    let a = DVec3::new(stream.f64() - 0.5, stream.f64() - 0.5, -0.25 - 0.5 * stream.f64());
    [a, a + 0.5 * DVec3::X, a + 0.25 * DVec3::X + 5e-8 * DVec3::Y]
}

fn push(scene: &mut Scene, corners: impl IntoIterator<Item = [DVec3; 3]>) {
    let mut mesh = Mesh::default();
    for triangle in corners {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(triangle);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    scene.meshes.push(mesh);
}

/// The picture's bits, and the number of triangles left out.
fn render(scene: &Scene) -> (Vec<[u32; 3]>, usize) {
    let budget = Budget { samples: Some(4), ..Budget::default() };
    let options = RenderOptions {
        view: View { width: 24, height: 24, ..View::default() },
        budget,
        ..RenderOptions::default()
    };
    let mut renderer = Renderer::new(gpu::context(), scene, options).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    let report = renderer.report().expect("a report");
    assert_eq!(report.non_finite, 0);
    let picture = renderer.picture().expect("a picture");
    (picture.rgb.iter().map(|rgb| rgb.map(f32::to_bits)).collect(), report.dropped_triangles)
}

#[test]
fn n08_degenerate_triangles_leave_no_trace() {
    let (expected, dropped) = render(&good_scene());
    assert_eq!(dropped, 0);
    assert!(expected.iter().flatten().any(|bits| f32::from_bits(*bits) > 0.0), "a black picture");
    for count in [1, 9, 1000] {
        let mut stream = Stream::new(11);
        let mut scene = good_scene();
        push(&mut scene, (0..count).map(|kind| degenerate(kind, &mut stream)));
        push(&mut scene, (0..count).map(|_| sliver(&mut stream)));
        // Before the good ones as well, so that their indices move.
        scene.meshes.rotate_right(1);
        let (found, dropped) = render(&scene);
        assert_eq!(dropped, count as usize);
        assert!(found == expected, "{count} degenerate triangles change the picture");
    }
}

#[test]
fn n08_every_kind_is_dropped() {
    let mut stream = Stream::new(12);
    for kind in 0..9 {
        let corners = degenerate(kind, &mut stream);
        let mut scene = good_scene();
        push(&mut scene, [corners]);
        let accel = Accel::build(&scene).expect("a BVH");
        assert_eq!((accel.dropped, accel.triangles.len()), (1, 4), "{corners:?}");
        scene.meshes.drain(..2);
        let accel = Accel::build(&scene).expect("a BVH");
        assert_eq!((accel.dropped, accel.triangles.len()), (1, 0), "{corners:?} alone");
    }
}

/// A face of 1e30 is a face: nothing panics, and what it leaves no room for in f32 is counted.
#[test]
fn n08_huge_faces_do_not_panic() {
    for size in [1e12, 1e30, 1e150, 1e300] {
        let mut scene = good_scene();
        push(&mut scene, [[DVec3::ZERO, size * DVec3::X, size * DVec3::Y]]);
        let accel = Accel::build(&scene).expect("a BVH");
        assert_eq!(accel.dropped + accel.triangles.len(), 5, "{size:e}");
        assert!(accel.triangles.iter().any(|triangle| triangle.mesh == 2), "{size:e}");
        assert!(accel.triangles.iter().flat_map(|t| t.vertices).all(|vertex| vertex.is_finite()), "{size:e}");
    }
}
