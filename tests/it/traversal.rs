//! The traversal of the renderer, alone: rays in, hits out.

use glam::{DVec3, Vec3};
use halfway::accel::{Accel, AccelTriangle};
use halfway::bench::rays::{RayBench, Work};
use halfway::device::{Feature, layout};
use halfway::scene::builtin::shapes::{looking_at, quad};
use halfway::scene::{Material, Mesh, Scene};

use crate::gpu;

/// A ray in unit space over t in (0, `t_max`).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Ray {
    pub origin: Vec3,
    pub t_max: f32,
    pub direction: Vec3,
    pub pad: u32,
}

impl Ray {
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, t_max: f32::MAX, direction, pad: 0 }
    }
}

pub const NO_TRIANGLE: u32 = u32::MAX;

/// A scene of one white material.
pub fn scene(meshes: impl IntoIterator<Item = Mesh>) -> Scene {
    Scene {
        materials: vec![Material::lambert("white", Vec3::ONE)],
        meshes: meshes.into_iter().collect(),
        ..Scene::default()
    }
}

/// A triangle as kernels have it, with material 0.
pub fn device_triangle(vertices: [Vec3; 3], flipped: bool) -> layout::Triangle {
    let [v0, v1, v2] = vertices.map(|vertex| vertex.to_array());
    let material_flags = if flipped { layout::TRIANGLE_FLIPPED } else { 0 };
    layout::Triangle { v0, material_flags, v1, light: 0, v2, cover: 0 }
}

/// The text of a kernel that traces so many rays.
pub fn tracing(rays: usize) -> String {
    format!(
        "#if ray_query
        enable wgpu_ray_query;
        #endif
        #import lib/traverse
        struct TestRay {{ origin: vec3f, t_max: f32, direction: vec3f, pad: u32 }}
        @group(1) @binding(0) var<storage, read> rays: array<TestRay>;
        @group(1) @binding(1) var<storage, read_write> found: array<RayHit>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let index = id.x + id.y * 65535u * 64u;
            if index < {rays}u {{
                found[index] = trace(rays[index].origin, rays[index].direction, rays[index].t_max);
            }}
        }}"
    )
}

/// A kernel that traces each ray; `features` may hold `any_hit`.
fn run(accel: &Accel, rays: &[Ray], features: &[Feature]) -> Vec<layout::Hit> {
    let kernel = tracing(rays.len());
    let mut features = features.to_vec();
    // The same rule as the renderer's, with the deep stack for any tree that the ordinary one may not hold.
    if accel.depth > 16 {
        features.push(Feature::DeepTree);
    }
    let triangle =
        |t: &AccelTriangle| layout::Triangle { cover: t.cover, ..device_triangle(t.vertices, t.flipped) };
    let triangles: Vec<layout::Triangle> = accel.triangles.iter().map(triangle).collect();
    let mut inputs: Vec<(&str, &[u8])> = vec![
        ("nodes", bytemuck::cast_slice(&accel.nodes)),
        ("triangles", bytemuck::cast_slice(&triangles)),
        ("rays", bytemuck::cast_slice(rays)),
    ];
    if !accel.covers.is_empty() {
        features.extend([Feature::Coincident, Feature::LambertOnly]);
        inputs.push(("covers", bytemuck::cast_slice(&accel.covers)));
    }
    let bytes = rays.len() * size_of::<layout::Hit>();
    let output = gpu::run(&kernel, &features, &inputs, &[("found", bytes)], rays.len() as u32);
    bytemuck::pod_collect_to_vec(&output[0])
}

/// The closest hit of every ray.
pub fn closest(accel: &Accel, rays: &[Ray]) -> Vec<layout::Hit> {
    run(accel, rays, &[])
}

/// Whether every ray hits anything.
pub fn any(accel: &Accel, rays: &[Ray]) -> Vec<bool> {
    run(accel, rays, &[Feature::AnyHit]).iter().map(|hit| hit.triangle != NO_TRIANGLE).collect()
}

/// A sphere of `rings` x `segments` quadrangles between poles, halved into triangles; every vertex shared.
pub fn uv_sphere(center: DVec3, radius: f64, rings: u32, segments: u32) -> Mesh {
    let mut positions = vec![center + radius * DVec3::Y, center - radius * DVec3::Y];
    for ring in 1..rings {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for segment in 0..segments {
            let phi = std::f64::consts::TAU * f64::from(segment) / f64::from(segments);
            let (sin, cos) = theta.sin_cos();
            positions.push(center + radius * DVec3::new(sin * phi.cos(), cos, sin * phi.sin()));
        }
    }
    let at = |ring: u32, segment: u32| 2 + (ring - 1) * segments + segment % segments;
    let mut triangles = Vec::new();
    for segment in 0..segments {
        triangles.push([0, at(1, segment + 1), at(1, segment)]);
        triangles.push([1, at(rings - 1, segment), at(rings - 1, segment + 1)]);
        for ring in 1..rings - 1 {
            let quad =
                [at(ring, segment), at(ring, segment + 1), at(ring + 1, segment + 1), at(ring + 1, segment)];
            triangles.push([quad[0], quad[1], quad[2]]);
            triangles.push([quad[0], quad[2], quad[3]]);
        }
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Of rays that look at 4, 2, none and 8 nodes, two go along with the longest of each two.
#[test]
fn lanes_are_live_while_their_own_ray_is() {
    let work = Work::of(&[[4, 1], [2, 0], [0, 0], [8, 3]], 2);
    assert_eq!(work, Work { nodes_per_ray: 3.5, triangles_per_ray: 1.0, live_lanes: 14.0 / 12.0, lanes: 2 });
}

/// A wall of two triangles is one node, which every ray looks at; those that hit have looked at a triangle.
#[test]
fn rays_tell_what_they_look_at() {
    let wall = quad(DVec3::new(-0.5, -0.5, 0.0), DVec3::X, DVec3::Y);
    let cameras = vec![looking_at("camera", DVec3::Z, DVec3::ZERO, 90.0)];
    let scene = Scene { cameras, ..scene([wall]) };
    let mut bench = RayBench::new(gpu::context(), &scene, 0, [16, 16]).expect("rays");
    let rate = bench.measure(gpu::context(), 0, 0.0).expect("a rate");
    let work = rate.work.expect("kernels that count");
    assert_eq!((rate.hits, work.nodes_per_ray), (64, 1.0), "{work:?}");
    assert_eq!(work.live_lanes, f64::from(work.lanes));
    let triangles = work.triangles_per_ray * 256.0;
    assert!((64.0..=128.0).contains(&triangles), "{triangles}");
    // Shadow rays along the wall meet nothing, but look for it.
    assert!(
        bench.measure(gpu::context(), 2, 0.0).expect("a rate").work.expect("a count").nodes_per_ray >= 1.0
    );
}
