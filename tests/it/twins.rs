//! Kernel functions against f64 (C-15): traversal, camera rays, texture lookup, points on triangles.

use glam::{Affine2, DVec2, DVec3, Vec2, Vec3};
use halfway::accel::Accel;
use halfway::device::layout::{self, Batch, Counts, PathRay, SAMPLES_A_GROUP};
use halfway::device::scene::DeviceScene;
use halfway::device::{BufferTable, Feature, Kernel};
use halfway::math::rng::{RandomKey, random4, uniform_from_word};
use halfway::scene::builtin::shapes::looking_at;
use halfway::scene::{Camera, Filter, Image, Mesh, Projection, SceneFeatures, Texture, TextureRef, Wrap};

use crate::gpu;
use crate::random::Stream;
use crate::reference::geometry::{self, Tree};
use crate::reference::{camera, texture};
use crate::traversal::{self, NO_TRIANGLE, Ray, device_triangle};

fn vector(stream: &mut Stream) -> Vec3 {
    2.0 * Vec3::new(stream.f32(), stream.f32(), stream.f32()) - 1.0
}

/// Distance from the nearest edge that the ray passes at on its triangle, as a share of the triangle's size (negative
/// outside), and the ray's parameter there.
fn edge_share(corners: [DVec3; 3], ray: &Ray) -> (f64, f64) {
    let [a, b, c] = corners;
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let normal = (b - a).cross(c - a);
    let t = normal.dot(a - origin) / normal.dot(direction);
    let p = origin + t * direction;
    let share = |u: DVec3, v: DVec3| (v - u).cross(p - u).dot(normal) / normal.length_squared();
    (share(a, b).min(share(b, c)).min(share(c, a)), t)
}

/// A cloud of triangles of all sizes, random rays: the same hits as in f64, but where f64 says that the ray passes
/// an edge, or two triangles meet, within rounding.
#[test]
fn c15_traversal() {
    let mut stream = Stream::new(20);
    let mut mesh = Mesh::default();
    for index in 0..3000 {
        let (at, size) = (vector(&mut stream), 10f32.powf(-3.0 * stream.f32()));
        mesh.positions.extend(
            [at, at + size * vector(&mut stream), at + size * vector(&mut stream)].map(Vec3::as_dvec3),
        );
        mesh.triangles.push([3 * index, 3 * index + 1, 3 * index + 2]);
    }
    let accel = Accel::build(&traversal::scene([mesh])).expect("a BVH");
    let corners: Vec<[DVec3; 3]> = accel.triangles.iter().map(|t| t.vertices.map(|v| v.as_dvec3())).collect();
    let tree = Tree::new(corners.clone());
    let rays: Vec<Ray> = (0..100_000)
        .map(|index| {
            let mut ray = Ray::new(vector(&mut stream), vector(&mut stream).normalize());
            // Rays along an axis as well, whose other components are zero of either sign.
            if index % 10 == 0 {
                let zero = if index % 20 == 0 { -0.0 } else { 0.0 };
                let axis = index / 10 % 3;
                let along = ray.direction[axis].signum();
                ray.direction = Vec3::splat(zero);
                ray.direction[axis] = along;
            }
            ray
        })
        .collect();
    let hits = traversal::closest(&accel, &rays);
    let any = traversal::any(&accel, &rays);
    // Spatial splits may list a triangle twice: compared by the scene's index.
    let scene_index = |index: usize| accel.triangles[index].triangle;
    let mut ties = 0;
    for ((ray, hit), any) in rays.iter().zip(&hits).zip(any) {
        assert_eq!(hit.triangle != NO_TRIANGLE, any, "closest and any hit disagree: {ray:?}");
        let exact_ray = geometry::Ray { origin: ray.origin.as_dvec3(), direction: ray.direction.as_dvec3() };
        let exact = tree.closest(&exact_ray, 0.0, f64::INFINITY);
        let found = (hit.triangle != NO_TRIANGLE).then_some(hit.triangle as usize);
        let expected = exact.map(|exact| exact.triangle);
        if found.map(scene_index) == expected.map(scene_index) {
            if let Some(exact) = exact {
                let t = f64::from(hit.t);
                let grazing = (ray.direction.as_dvec3()).dot(normal(&corners[exact.triangle])).abs();
                let error = (t - exact.distance).abs() * grazing;
                assert!(error <= 1e-6, "distance {t} instead of {}: {ray:?}", exact.distance);
            }
            continue;
        }
        ties += 1;
        // Either an edge is within rounding of the ray, or both hits are as far as each other.
        let of = |index: Option<usize>| index.map(|index| edge_share(corners[index], ray));
        let at_an_edge = [of(found), of(expected)].into_iter().flatten().any(|(share, _)| share.abs() < 1e-3);
        let as_far = matches!((of(found), of(expected)), (Some(a), Some(b)) if (a.1 - b.1).abs() < 1e-5);
        assert!(at_an_edge || as_far, "{found:?} instead of {expected:?}: {ray:?}");
    }
    println!("{} of {} rays within rounding of an edge", ties, rays.len());
    assert!(ties < 50, "{ties} rays differ");
}

fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize()
}

#[test]
fn c15_surface_point() {
    let mut stream = Stream::new(21);
    let triangles: Vec<[Vec3; 3]> = (0..100_000)
        .map(|_| {
            let (at, size) = (0.5 * vector(&mut stream), 10f32.powf(-6.0 * stream.f32()));
            [at, at + size * vector(&mut stream), at + size * vector(&mut stream)]
        })
        .collect();
    let shares: Vec<[f32; 2]> = triangles
        .iter()
        .map(|_| {
            let u = stream.vec2();
            [(1.0 - u.x) * u.y, u.x]
        })
        .collect();
    let kernel = "#import lib/hit
        @group(1) @binding(0) var<storage, read> shares: array<vec2f>;
        @group(1) @binding(1) var<storage, read_write> points: array<array<vec4f, 2>>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&shares) {
                let p = surface_point(id.x, shares[id.x].x, shares[id.x].y);
                points[id.x] = array(vec4f(p.position, p.offset), vec4f(p.world_ng, p.area));
            }
        }";
    // Every other one as if its sorted vertices ran clockwise.
    let device: Vec<_> =
        triangles.iter().enumerate().map(|(index, t)| device_triangle(*t, index % 2 == 1)).collect();
    let inputs: [(&str, &[u8]); 2] =
        [("triangles", bytemuck::cast_slice(&device)), ("shares", bytemuck::cast_slice(&shares))];
    let output = gpu::run(
        kernel,
        &[Feature::LambertOnly],
        &inputs,
        &[("points", triangles.len() * 32)],
        triangles.len() as u32,
    );
    let points: Vec<[f32; 8]> = bytemuck::pod_collect_to_vec(&output[0]);
    let epsilon = f64::from(f32::EPSILON);
    for (index, ((triangle, share), point)) in triangles.iter().zip(&shares).zip(&points).enumerate() {
        let [a, b, c] = triangle.map(|v| v.as_dvec3());
        let [b1, b2] = share.map(f64::from);
        let point = point.map(f64::from);
        let reach = triangle.iter().map(|v| v.abs().max_element()).fold(0.0, f32::max);
        let position = (1.0 - b1 - b2) * a + b1 * b + b2 * c;
        let error = (DVec3::new(point[0], point[1], point[2]) - position).length();
        assert!(error <= 3.0 * epsilon * f64::from(reach), "position off by {error:e}: {triangle:?}");
        assert_eq!(point[3], f64::from(reach) * 2f64.powi(-20));
        let product = (b - a).cross(c - a);
        // How much the rounding of the products is magnified in their differences.
        let condition = (b - a).length() * (c - a).length() / product.length();
        let normal = DVec3::new(point[4], point[5], point[6]);
        let side = if index % 2 == 1 { -1.0 } else { 1.0 };
        let error = (normal - side * product.normalize()).length();
        assert!(error <= 4.0 * epsilon * condition, "normal off by {error:e}: {triangle:?}");
        let error = (point[7] / (0.5 * product.length()) - 1.0).abs();
        assert!(error <= 4.0 * epsilon * condition, "area off by {error:e}: {triangle:?}");
    }
}

/// The camera kernel itself, for a crop and for samples that do not begin at the first.
#[test]
fn c15_camera_rays() {
    let context = gpu::context();
    let perspective = looking_at("perspective", DVec3::new(3.0, 2.0, 5.0), DVec3::new(0.5, 0.2, -1.0), 50.0);
    let orthographic =
        Camera { projection: Projection::Orthographic { xmag: 2.0, ymag: 1.5 }, ..perspective.clone() };
    let mut scene = traversal::scene([Mesh {
        positions: vec![DVec3::new(-4.0, -1.0, 0.0), DVec3::new(5.0, -1.0, 2.0), DVec3::new(0.0, 3.0, -2.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    }]);
    scene.cameras = vec![perspective, orthographic];
    let accel = Accel::build(&scene).expect("a BVH");
    let device_scene =
        DeviceScene::new(context, &scene, &accel, SceneFeatures::of(&scene)).expect("a device scene");
    let kernel = Kernel::new(context, "camera_rays", device_scene.kernel_features(), &device_scene.constants)
        .expect("a kernel");
    let [width, height] = [64, 48];
    let batch = Batch {
        width,
        height,
        crop_x: 10,
        crop_y: 1,
        crop_width: 20,
        crop_height: 24,
        crop_stride: 2,
        first_pixel: 60,
        pixel_count: 400,
        // Of two groups.
        first_sample: 5,
        sample_count: 5,
        seed: 99,
        max_depth: 1,
        ..Batch::default()
    };
    let paths = batch.pixel_count * batch.sample_count;
    for camera in &scene.cameras {
        let mut buffers = BufferTable::default();
        for name in ["paths_in", "paths_out", "radiance"] {
            buffers.create(context, name, u64::from(paths) * size_of::<PathRay>() as u64).expect("create");
        }
        buffers.create(context, "counts", size_of::<Counts>() as u64).expect("create");
        buffers
            .upload_uniform(
                context,
                "camera",
                &[layout::Camera::new(&device_scene.unit, camera, width, height)],
            )
            .expect("upload");
        buffers.upload_uniform(context, "batch", &[batch]).expect("upload");
        let bound = kernel.bind(context, &buffers).expect("all buffers named");
        let mut encoder = context.device.create_command_encoder(&Default::default());
        bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), paths);
        context.queue.submit([encoder.finish()]);
        let bytes = u64::from(paths) * size_of::<PathRay>() as u64;
        let rays: Vec<PathRay> =
            bytemuck::pod_collect_to_vec(&buffers.read(context, "paths_in", bytes).expect("read"));
        for (index, ray) in (0..paths).zip(rays) {
            let place = batch.first_pixel + index % batch.pixel_count;
            let x = batch.crop_x + 2 * (place % batch.crop_width);
            let y = batch.crop_y + 2 * (place / batch.crop_width);
            let sample = batch.first_sample + index / batch.pixel_count;
            // A shift for each group of eight samples, and a step for each sample in it.
            let group =
                RandomKey { pixel: y * width + x, sample: sample / SAMPLES_A_GROUP, seed: batch.seed };
            let shift = random4(group, 1 << 31);
            let number = |shift: u32, step: u32| {
                uniform_from_word(shift.wrapping_add(step.wrapping_mul(sample % SAMPLES_A_GROUP)))
            };
            let u = [number(shift.x, 0x2000_0000), number(shift.y, 0x6000_0000)].map(f64::from);
            let at = DVec2::new(f64::from(x) + u[0], f64::from(y) + u[1]);
            let exact = camera::ray(camera, [width, height], at);
            let origin = accel.unit.point_f64(exact.origin);
            let found = Vec3::from_array(ray.origin).as_dvec3();
            assert!(
                (found - origin).length() <= 4e-7 * origin.length(),
                "origin {found} instead of {origin}"
            );
            let found = Vec3::from_array(ray.direction).as_dvec3();
            let error = (found - exact.direction).length();
            assert!(error <= 5e-7, "direction off by {error:e}");
            assert_eq!(
                (ray.path, ray.pdf_solid, ray.throughput, ray.depth_medium),
                (index, 0.0, [1.0; 3], 0)
            );
        }
    }
}

/// Every pair of wrap modes, both filters, both encodings, odd sizes, and a transform, from the scene's own upload.
#[test]
fn c15_texture_lookup() {
    let mut stream = Stream::new(22);
    let mut image = |width: u32, height: u32| Image {
        name: "noise".into(),
        width,
        height,
        texels: (0..width * height).map(|_| stream.word().to_le_bytes()).collect(),
    };
    let mut scene = traversal::scene([]);
    scene.images = vec![image(5, 3), image(16, 8), image(1, 7)];
    let modes = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    for filter in [Filter::Linear, Filter::Nearest] {
        for u in modes {
            for v in modes {
                let image = scene.textures.len() as u32 % 3;
                scene.textures.push(Texture { image, wrap: [u, v], filter });
            }
        }
    }
    let transform = Affine2::from_scale_angle_translation(Vec2::new(1.5, -0.75), 0.6, Vec2::new(0.3, -2.1));
    let mut references = Vec::new();
    let white = scene.materials[0].clone();
    scene.materials.clear();
    for texture in 0..scene.textures.len() as u32 {
        let transform = if texture % 2 == 0 { Affine2::IDENTITY } else { transform };
        let reference = TextureRef { texture, uv_set: 0, transform };
        scene.materials.push(halfway::scene::Material {
            base_color_texture: Some(reference),
            metallic_roughness_texture: Some(reference),
            ..white.clone()
        });
        // In the order in which a material's slots are uploaded.
        references.extend([(reference, true), (reference, false)]);
    }
    let accel = Accel::build(&scene).expect("a BVH");
    let features = SceneFeatures { textures: true, ..SceneFeatures::default() };
    let device_scene = DeviceScene::new(gpu::context(), &scene, &accel, features).expect("a device scene");
    let read = |name: &str| {
        let bytes = device_scene.buffers.get(name).expect("a texture buffer").size();
        device_scene.buffers.read(gpu::context(), name, bytes).expect("read")
    };
    let (slots, texels) = (read("texture_slots"), read("texels"));

    let queries: Vec<[f32; 4]> = (0..100_000)
        .map(|index| {
            let uv = 8.0 * stream.vec2() - 4.0;
            [uv.x, uv.y, f32::from_bits(index % references.len() as u32), 0.0]
        })
        .collect();
    let kernel = "#import lib/texture
        @group(1) @binding(0) var<storage, read> queries: array<vec4f>;
        @group(1) @binding(1) var<storage, read_write> values: array<vec4f>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&queries) {
                let query = queries[id.x];
                values[id.x] = sample_texture(bitcast<u32>(query.z) + 1u, query.xy);
            }
        }";
    let inputs: [(&str, &[u8]); 3] =
        [("texture_slots", &slots), ("texels", &texels), ("queries", bytemuck::cast_slice(&queries))];
    let output = gpu::run(
        kernel,
        &[Feature::Textures],
        &inputs,
        &[("values", queries.len() * 16)],
        queries.len() as u32,
    );
    let values: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&output[0]);
    let mut skipped = 0;
    for (query, value) in queries.iter().zip(values) {
        let (reference, srgb) = references[query[2].to_bits() as usize];
        let uv = Vec2::new(query[0], query[1]);
        let texture = &scene.textures[reference.texture as usize];
        let image = &scene.images[texture.image as usize];
        let size = DVec2::new(f64::from(image.width), f64::from(image.height));
        let at = reference.transform.transform_point2(uv).as_dvec2() * size;
        // A coordinate of up to 10 is rounded to 2^-21; nearest lookup that close to a border may go either way.
        let border = (at - at.round()).abs().min_element();
        if texture.filter == Filter::Nearest && border < 1e-4 {
            skipped += 1;
            continue;
        }
        let exact = texture::lookup(&scene, &reference, uv, srgb);
        let error = (glam::Vec4::from_array(value).as_dvec4() - exact).abs().max_element();
        let bound = if texture.filter == Filter::Nearest { 5e-6 } else { 1e-4 };
        assert!(error <= bound, "{value:?} instead of {exact} at {uv} of {texture:?}, srgb {srgb}");
    }
    assert!(skipped < 200, "{skipped} lookups at a border");
}
