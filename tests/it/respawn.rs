//! Rays that start on a surface do not meet it again, and do not jump over what is near (N-07).

use glam::{DVec3, Vec3};
use halfway::accel::Accel;
use halfway::device::{Feature, layout};
use halfway::scene::Mesh;

use crate::gpu;
use crate::random::Stream;
use crate::traversal::{self, device_triangle};

const TRIANGLES: u32 = 1000;
const RAYS_A_TRIANGLE: u32 = 1000;

/// All directions.
const ANYWHERE: &str = "return random;";
/// Directions on the front side.
const FRONT: &str = "return select(-random, random, dot(random, point.world_ng) > 0.0);";
/// Directions within 2^-16 to 1 of the triangle's longest edge.
const ALONG: &str = "let t = triangles[point.triangle];
    var longest = t.v1 - t.v0;
    for (var i = 0u; i < 2u; i++) {
        let edge = t.v2 - select(t.v0, t.v1, i == 1u);
        longest = select(longest, edge, dot(edge, edge) > dot(longest, longest));
    }
    return normalize(normalize(longest) + random * exp2(-16.0 * uniform_from_word(word)));";

/// The ray meets the triangle that it starts on.
const AGAIN: &str = "let t = triangles[triangle];
    return intersect_triangle(shear_ray(origin, direction), t.v0, t.v1, t.v2, MAX_FLOAT).t > 0.0;";

/// Starts `RAYS_A_TRIANGLE` rays on each triangle, towards `aim` (WGSL over a `random` direction, the `point` and a
/// random `word`), and counts those for which `found` (WGSL over `origin`, `direction`, `triangle`) is true.
fn count(triangles: &[layout::Triangle], aim: &str, found: &str) -> u32 {
    let kernel = format!(
        "#import lib/hit
        #import lib/intersect
        #import lib/rng
        #import lib/sampling
        @group(1) @binding(0) var<storage, read_write> total: atomic<u32>;
        fn aim(random: vec3f, point: SurfacePoint, word: u32) -> vec3f {{ {aim} }}
        fn found(origin: vec3f, direction: vec3f, triangle: u32) -> bool {{ {found} }}
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let index = id.x + id.y * 65535u * 64u;
            let triangle = index / {RAYS_A_TRIANGLE}u;
            if triangle >= {}u {{ return; }}
            let key = RandomKey(index, 0u, 7u);
            let u = uniform4(key, 0u);
            let b1 = (1.0 - u.x) * u.y;
            let point = surface_point(triangle, b1, u.x);
            let random = sample_uniform_sphere(u.zw);
            let direction = aim(random, point, random4(key, 1u).x);
            let origin = ray_origin(point, direction);
            if found(origin, direction, triangle) {{ atomicAdd(&total, 1u); }}
        }}",
        triangles.len()
    );
    let inputs: [(&str, &[u8]); 1] = [("triangles", bytemuck::cast_slice(triangles))];
    let invocations = triangles.len() as u32 * RAYS_A_TRIANGLE;
    let output = gpu::run(&kernel, &[Feature::LambertOnly], &inputs, &[("total", 4)], invocations);
    bytemuck::pod_read_unaligned(&output[0][..4])
}

/// A triangle as `Accel` would store it: sorted by its vertices' coordinates.
fn sorted(mut vertices: [Vec3; 3]) -> layout::Triangle {
    vertices.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    device_triangle(vertices, false)
}

/// pbrt-v4, shapes_test.cpp, Reintersect: coordinates 10^U(-8,8) of either sign.
#[test]
fn n07_no_triangle_is_hit_again() {
    let mut stream = Stream::new(8);
    let mut coordinate = || {
        let magnitude = 10f64.powf(16.0 * stream.f64() - 8.0) as f32;
        if stream.word() & 1 == 0 { magnitude } else { -magnitude }
    };
    let triangles: Vec<layout::Triangle> = (0..TRIANGLES)
        .map(|_| sorted(std::array::from_fn(|_| Vec3::from_array(std::array::from_fn(|_| coordinate())))))
        .collect();
    let hits = count(&triangles, ANYWHERE, AGAIN);
    println!("{} rays, {hits} meet their own triangle", TRIANGLES * RAYS_A_TRIANGLE);
    assert_eq!(hits, 0);
}

/// Triangles in unit space that are `aspect` times as long as high, with one short side (needles) or with none (caps).
fn slivers(aspect: f32, caps: bool) -> Vec<layout::Triangle> {
    let mut stream = Stream::new(9);
    let mut sliver = || {
        let mut vector = || 2.0 * Vec3::new(stream.f32(), stream.f32(), stream.f32()) - 1.0;
        let (at, along) = (0.5 * vector(), 0.5 * vector().normalize());
        let across = along.any_orthogonal_vector().normalize() * along.length() / aspect;
        let foot = if caps { stream.f32() } else { 0.0 };
        sorted([at, at + along, at + foot * along + across])
    };
    (0..TRIANGLES).map(|_| sliver()).collect()
}

#[test]
fn n07_no_sliver_is_hit_again() {
    for aspect in [1.0, 16.0, 256.0, 1e4] {
        for caps in [false, true] {
            let hits = count(&slivers(aspect, caps), ANYWHERE, AGAIN);
            println!("aspect {aspect}, caps {caps}: {hits} meet their own triangle");
            assert_eq!(hits, 0, "aspect {aspect}, caps {caps}");
        }
    }
}

/// The worst there is: rays that leave a needle along its length. Those of caps are past what f32 normals can tell
/// from about 256 on.
#[test]
fn n07_no_needle_is_hit_again_along_its_length() {
    for (aspect, caps) in [(1.0, false), (256.0, false), (1e4, false), (1.0, true), (64.0, true)] {
        let hits = count(&slivers(aspect, caps), ALONG, AGAIN);
        println!("aspect {aspect}, caps {caps}: {hits} meet their own triangle");
        assert_eq!(hits, 0, "aspect {aspect}, caps {caps}");
    }
}

/// Two large parallel plates, 1e-5 of their size apart: rays that leave one meet the other, whatever the size, the
/// place, and the plates' orientation.
#[test]
fn n07_a_near_plane_is_not_jumped_over() {
    let mut stream = Stream::new(10);
    for exponent in [-6, 0, 6] {
        let size = 10f64.powi(exponent);
        for _ in 0..4 {
            let mut vector = || 2.0 * DVec3::new(stream.f64(), stream.f64(), stream.f64()) - 1.0;
            let normal = vector().normalize();
            let u = normal.any_orthonormal_vector();
            let v = normal.cross(u);
            let center = vector() * size * 1e3;
            // The nearer plate is where rays start; the other one is so much larger that even slanted rays meet it.
            let plate = |height: f64, half: f64| Mesh {
                positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(s, t)| center + normal * height + (u * s + v * t) * half)
                    .to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            };
            let scene = traversal::scene([plate(0.0, 0.25 * size), plate(1e-5 * size, 0.5 * size)]);
            let accel = Accel::build(&scene).expect("a BVH");
            let plate = |mesh: u32| {
                let of_mesh = accel.triangles.iter().filter(move |triangle| triangle.mesh == mesh);
                of_mesh.map(|t| device_triangle(t.vertices, t.flipped)).collect::<Vec<_>>()
            };
            let triangles = [plate(0), plate(1)].concat();
            assert_eq!(triangles.len(), 4);
            // Rays that run along the plates may pass the far one's end: those steeper than 1e-4 must meet it.
            let met = "let steep = abs(dot(direction, surface_point(triangle, 0.3, 0.3).world_ng)) > 1e-4;
                let a = triangles[2];
                let b = triangles[3];
                let ray = shear_ray(origin, direction);
                let hit = max(intersect_triangle(ray, a.v0, a.v1, a.v2, MAX_FLOAT).t,
                    intersect_triangle(ray, b.v0, b.v1, b.v2, MAX_FLOAT).t);
                return triangle < 2u && steep && hit <= 0.0;";
            let missed = count(&triangles, FRONT, met);
            assert_eq!(missed, 0, "size 10^{exponent}");
        }
    }
}
