//! Nothing leaks: closed surfaces are closed for every ray, at every place and size (N-05, N-06).

use glam::{DVec3, Vec3};
use halfway::accel::Accel;
use halfway::scene::Mesh;
use halfway::scene::builtin::shapes::icosphere;

use crate::random::Stream;
use crate::traversal::{self, NO_TRIANGLE, Ray, uv_sphere};

/// Embree's place for its watertightness test, in units of a sphere's radius of 2.
const FAR: DVec3 = DVec3::new(148_376.0, 1234.0, -223_423.0);
/// Of each of the three kinds.
const RAYS: usize = 100_000;

/// Rays from `center` (unit space), and from nearby, at vertices, edge midpoints and random points of the triangles
/// as the device has them.
fn aimed_rays(accel: &Accel, center: Vec3, reach: f32, count: usize) -> Vec<Ray> {
    let mut stream = Stream::new(5);
    let mut rays = Vec::with_capacity(count);
    for index in 0..count {
        let pick = stream.word() as usize % accel.triangles.len();
        let [a, b, c] = accel.triangles[pick].vertices;
        let target = match index % 3 {
            0 => [a, b, c][index / 3 % 3],
            1 => 0.5 * ([a, b, c][index / 3 % 3] + [b, c, a][index / 3 % 3]),
            _ => {
                let u = stream.vec2();
                a + (b - a) * u.x + (c - a) * (1.0 - u.x) * u.y
            }
        };
        let jitter = 2.0 * Vec3::new(stream.f32(), stream.f32(), stream.f32()) - 1.0;
        let origin = if index % 2 == 0 { center } else { center + 0.25 * reach * jitter };
        rays.push(Ray::new(origin, target - origin));
    }
    rays
}

/// Every ray from inside `mesh`, a sphere, meets it. `others` are further meshes of the scene.
#[track_caller]
fn assert_closed(name: &str, sphere: Mesh, center: DVec3, radius: f64, others: Vec<Mesh>, rays: usize) {
    let scene = traversal::scene(std::iter::once(sphere).chain(others));
    let mut accel = Accel::build(&scene).expect("a BVH");
    let others = accel.triangles.iter().filter(|triangle| triangle.mesh > 0).count();
    assert_eq!(accel.dropped, 0, "{name}: the sphere has lost triangles");
    let (unit_center, unit_radius) = (accel.unit.point(center), accel.unit.length(radius) as f32);
    // Targets on the sphere alone.
    let whole = accel.clone();
    accel.triangles.retain(|triangle| triangle.mesh == 0);
    assert_eq!(accel.triangles.len() + others, whole.triangles.len());
    let rays = aimed_rays(&accel, unit_center, unit_radius, rays);
    let misses = traversal::closest(&whole, &rays).iter().filter(|hit| hit.triangle == NO_TRIANGLE).count();
    let any_misses = traversal::any(&whole, &rays).iter().filter(|found| !**found).count();
    println!(
        "{name}: {} triangles, {} rays, {misses} and {any_misses} misses",
        accel.triangles.len(),
        rays.len()
    );
    assert_eq!([misses, any_misses], [0, 0], "{name}: closest and any hit");
}

#[test]
fn n05_watertight_icosphere() {
    for center in [DVec3::ZERO, FAR] {
        assert_closed("icosphere", icosphere(center, 2.0, 4), center, 2.0, Vec::new(), 3 * RAYS);
    }
}

#[test]
fn n05_watertight_uv_sphere() {
    for center in [DVec3::ZERO, FAR] {
        assert_closed("uv sphere 60x60", uv_sphere(center, 2.0, 60, 60), center, 2.0, Vec::new(), 3 * RAYS);
    }
}

#[test]
fn n05_watertight_fine_uv_sphere() {
    assert_closed("uv sphere 200x400", uv_sphere(FAR, 2.0, 200, 400), FAR, 2.0, Vec::new(), 3 * RAYS);
}

/// A small sphere in the corner of a wide scene: unit space cannot recentre it, so that its edges are a few
/// roundings of its position long.
#[test]
fn n05_watertight_far_from_the_middle() {
    let corner = Mesh {
        positions: vec![-FAR, -FAR + DVec3::X, -FAR + DVec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    for radius in [2.0, 200.0] {
        assert_closed(
            "small and far",
            uv_sphere(FAR, radius, 20, 20),
            FAR,
            radius,
            vec![corner.clone()],
            3 * RAYS,
        );
    }
}

/// Powers of two change nothing at all: the same nodes, the same hits, bit for bit.
#[test]
fn n06_scale_ladder() {
    let ladder = |exponent: i32| {
        let scale = 2f64.powi(exponent);
        let center = DVec3::new(0.7, -1.3, 0.2) * scale;
        let scene = traversal::scene([icosphere(center, scale, 3), uv_sphere(center, 0.3 * scale, 30, 30)]);
        let accel = Accel::build(&scene).expect("a BVH");
        let center = accel.unit.point(center + DVec3::splat(0.4) * scale);
        let rays = aimed_rays(&accel, center, accel.unit.length(0.1 * scale) as f32, 30_000);
        let hits = traversal::closest(&accel, &rays);
        (accel, hits)
    };
    let (accel, hits) = ladder(0);
    assert!(hits.iter().all(|hit| hit.triangle != NO_TRIANGLE));
    for exponent in [-700, -40, -20, -7, 7, 20, 40, 700] {
        let (scaled, scaled_hits) = ladder(exponent);
        assert_eq!(scaled.unit.exponent, accel.unit.exponent - exponent);
        assert!(scaled.nodes == accel.nodes, "2^{exponent}: other nodes");
        let differing = scaled_hits.iter().zip(&hits).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "2^{exponent}: other hits");
    }
}

/// The same at sizes that are no powers of two: every size is closed.
#[test]
fn n06_any_scale_is_closed() {
    for exponent in [-18, -9, -4, 4, 9, 18] {
        let radius = 10f64.powi(exponent);
        let center = DVec3::new(3.0, -1.0, 2.0) * radius;
        assert_closed("scaled icosphere", icosphere(center, radius, 2), center, radius, Vec::new(), 30_000);
    }
}
