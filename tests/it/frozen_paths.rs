//! Partition of unity (C-06, N-11): the weights that the kernels' own functions give to every strategy of a frozen
//! path, against the judge's, which come from the definitions.

use halfway::accel::Accel;
use halfway::device::layout::{Batch, Light};
use halfway::device::scene::DeviceScene;
use halfway::device::shader::stitch_text;
use halfway::device::{BufferTable, Kernel};
use halfway::math::equal_area::sphere_to_square;
use halfway::scene::builtin::builtin;
use halfway::scene::{Scene, SceneFeatures};

use crate::bidirectional::double_sided_lamp;
use crate::gpu;
use crate::reference::bidirectional::{Options, trace_full_paths};
use crate::reference::path_space::{FullPath, LightEnd, PathSpace, SurfaceVertex, weights};

/// Vertices that a frozen path may have beside the camera.
const VERTICES: usize = 8;
const RESOLUTION: [u32; 2] = [32, 32];
const LIGHT_PATHS: f32 = 700.0;
const CONNECTION_DENSITY: f32 = 0.4;

/// Walks a path from both ends, as the kernels do but along given directions, and notes the weight of each strategy.
const KERNEL: &str = "
#import bind/accel
#import lib/strategies

struct Frozen {
    direction: vec3f,
    /// Number of edges.
    n: u32,
    /// LIGHT_* and index into `lights`.
    kind: u32,
    light: u32,
    pad0: u32,
    pad1: u32,
    vertices: array<vec4u, 8>,
}

@group(2) @binding(10) var<storage, read> frozen: array<Frozen>;
@group(2) @binding(11) var<storage, read_write> weights: array<f32>;

struct Step {
    pdf_solid: f32,
    next: SubPath,
}

fn is_delta(point: SurfacePoint) -> bool {
    return (materials[point.material].flags & MATERIAL_DELTA) != 0u;
}

/// Where a ray starts is off the surface by a little, so its direction is too, most of all on short edges: weights must
/// follow from the positions alone.
fn arrive_turned(point: SurfacePoint, direction: vec3f, pdf_solid: f32, previous: SubPath) -> Arrival {
    var turned = direction;
    if (previous.flags & SUBPATH_INFINITE) == 0u {
        turned = normalize(direction + 0x1p-7 * point.world_ng.yzx);
    }
    return arrive(point, turned, pdf_solid, previous);
}

fn step_along(point: SurfacePoint, arrival: Arrival, direction: vec3f, from_eye: bool) -> Step {
    let surface = point_surface(point);
    let frame = point_frame(point);
    let survives = survival(surface);
    if is_delta(point) {
        let reflects = (dot(direction, point.world_ng) > 0.0) == (dot(arrival.world_from, point.world_ng) > 0.0);
        let u = vec3f(0.5, 0.5, select(0.99999994, 0.0, reflects));
        let event = shading_sample_direction(surface, frame, arrival.world_from, u, from_eye).pdf_solid * survives;
        return Step(
            event * delta_measure(surface, frame, direction),
            depart(point, arrival, true, event * delta_measure(surface, frame, arrival.world_from)),
        );
    }
    let value = shading_evaluate(surface, frame, arrival.world_from, direction, from_eye);
    return Step(value.pdf_solid * survives, depart(point, arrival, false, value.pdf_back_solid * survives));
}

fn point_at(path: u32, i: u32) -> SurfacePoint {
    let vertex = frozen[path].vertices[i - 1u];
    return surface_point(vertex.x, bitcast<f32>(vertex.y), bitcast<f32>(vertex.z));
}

/// Unit direction from x_i to x_{i+1}.
fn direction_from(path: u32, i: u32) -> vec3f {
    let at_end = i + 1u == frozen[path].n;
    if at_end && frozen[path].kind != LIGHT_TRIANGLE {
#if punctual_lights
        if frozen[path].kind == LIGHT_POINT || frozen[path].kind == LIGHT_SPOT {
            let light = punctual_lights[lights[frozen[path].light].index];
            return normalize(light.position - point_at(path, i).position);
        }
#endif
        return frozen[path].direction;
    }
    return normalize(point_at(path, i + 1u).position - point_at(path, i).position);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let path = id.x;
    if path >= arrayLength(&frozen) {
        return;
    }
    let n = frozen[path].n;
    let kind = frozen[path].kind;
    let light = frozen[path].light;
    let first = path * 10u - 1u;

    // From the light: vertices x_n .. x_1.
    var light_side: array<LightVertex, 9>;
    let infinite = kind == LIGHT_ENVIRONMENT || kind == LIGHT_DIRECTIONAL;
    let is_triangle = kind == LIGHT_TRIANGLE;
    let ratio = select(0.0, 1.0, is_triangle || kind == LIGHT_ENVIRONMENT);
    let towards_light = direction_from(path, n - 1u);
    var position: vec3f;
    var normal: vec3f;
    var pdf_light = lights[light].pdf_select;
    var pdf_solid = disk_pdf_area();
    var end: LightVertex;
    if is_triangle {
        let point = point_at(path, n);
        position = point.position;
        normal = point.world_ng;
        pdf_light /= point.area;
        pdf_solid = emission_pdf_solid(point, -towards_light);
        end.b1 = bitcast<f32>(frozen[path].vertices[n - 1u].y);
        end.b2 = bitcast<f32>(frozen[path].vertices[n - 1u].z);
    }
#if environment
    if kind == LIGHT_ENVIRONMENT {
        pdf_light = environment_pdf_solid(towards_light);
    }
#endif
#if punctual_lights
    if kind == LIGHT_POINT || kind == LIGHT_SPOT {
        position = punctual_lights[lights[light].index].position;
        pdf_solid = uniform_cone_pdf_solid(emission_cone(punctual_lights[lights[light].index], kind == LIGHT_SPOT));
    }
#endif
    end.weight = vec3f(1.0);
    end.index = lights[light].index;
    if is_triangle {
        end.index = frozen[path].vertices[n - 1u].x;
    }
    end.world_from = towards_light;
    end.depth_kind = (kind + 1u) << 16u;
    end.pdf_area = pdf_light;
    end.ratio = ratio;
    light_side[n] = end;
    var previous = SubPath(position, ratio / pdf_light, normal, select(0u, SUBPATH_INFINITE, infinite));
    var direction = -towards_light;
    for (var i = n - 1u; i >= 1u; i--) {
        let point = point_at(path, i);
        let arrival = arrive_turned(point, direction, pdf_solid, previous);
        var vertex: LightVertex;
        vertex.weight = vec3f(1.0);
        vertex.index = frozen[path].vertices[i - 1u].x;
        vertex.b1 = bitcast<f32>(frozen[path].vertices[i - 1u].y);
        vertex.b2 = bitcast<f32>(frozen[path].vertices[i - 1u].z);
        vertex.world_from = arrival.world_from;
        vertex.depth_kind = n - i;
        vertex.pdf_area = arrival.pdf_area;
        vertex.ratio = arrival.ratio;
        vertex.to_previous = arrival.to_previous;
        vertex.edge = arrival.edge;
        light_side[i] = vertex;
        if i == 1u {
            if n > 1u && !is_delta(point) {
                weights[first + 1u] = connect_camera(point, arrival, camera_view(point.position)).weight;
            }
        } else {
            direction = -direction_from(path, i - 1u);
            let step = step_along(point, arrival, direction, false);
            pdf_solid = step.pdf_solid;
            previous = step.next;
        }
    }

    // From the eye: vertices x_1 .. x_n.
    direction = normalize(point_at(path, 1u).position - camera.origin);
    if n == 1u && !is_triangle {
        direction = frozen[path].direction;
    }
    pdf_solid = camera_pdf(direction);
    previous = SubPath(camera.origin, 0.0, vec3f(0.0), SUBPATH_CAMERA);
    for (var i = 1u; i < n; i++) {
        let point = point_at(path, i);
        let arrival = arrive_turned(point, direction, pdf_solid, previous);
        if !is_delta(point) {
            var connects = true;
            if i + 1u < n {
                connects = !is_delta(point_at(path, i + 1u));
            }
            if connects {
                weights[first + i + 1u] = connect(point, arrival, EyeShares(), light_side[i + 1u]).weight;
            }
        }
        direction = direction_from(path, i);
        let step = step_along(point, arrival, direction, true);
        pdf_solid = step.pdf_solid;
        previous = step.next;
    }
#if area_lights
    if is_triangle {
        let point = point_at(path, n);
        weights[first + n + 1u] = emitter_weight(point, arrive_turned(point, direction, pdf_solid, previous), EyeShares(), light);
    }
#endif
#if environment
    if kind == LIGHT_ENVIRONMENT {
        weights[first + n + 1u] = environment_weight(previous, EyeShares(), direction, pdf_solid);
    }
#endif
}
";

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Frozen {
    direction: [f32; 3],
    n: u32,
    kind: u32,
    light: u32,
    pad: [u32; 2],
    vertices: [[u32; 4]; VERTICES],
}

/// A scene on the device, beside the judge with the device's own probabilities.
struct Bench<'a> {
    accel: Accel,
    device: DeviceScene,
    lights: Vec<Light>,
    space: PathSpace<'a>,
}

impl<'a> Bench<'a> {
    fn new(scene: &'a Scene) -> Self {
        let context = gpu::context();
        let accel = Accel::build(scene).expect("a tree");
        let device =
            DeviceScene::new(context, scene, &accel, SceneFeatures::of(scene)).expect("a device scene");
        let bytes = (device.light_count * size_of::<Light>()) as u64;
        let lights: Vec<Light> =
            bytemuck::pod_collect_to_vec(&device.buffers.read(context, "lights", bytes).expect("lights"));
        let mut space = PathSpace::new(scene, &scene.cameras[0], RESOLUTION);
        space.disc_radius = accel.unit.world_length(1.0);
        space.picks.triangles.fill(0.0);
        space.picks.environment = 0.0;
        space.picks.punctual.fill(0.0);
        for light in &lights {
            let pdf_select = f64::from(light.pdf_select);
            match light.kind {
                0 => {
                    let triangle = accel.triangles[light.index as usize];
                    let judged =
                        space.world.tree_triangle(triangle.mesh as usize, triangle.triangle as usize);
                    space.picks.triangles[judged.expect("the judge has it")] = pdf_select;
                }
                1 => {
                    space.picks.environment = pdf_select;
                    let size = device.constants.iter().find(|(name, _)| *name == "ENVIRONMENT_SIZE");
                    let size = size.expect("an environment").1;
                    let bytes = (size * size) as u64 * 16;
                    let texels = device.buffers.read(context, "environment_texels", bytes).expect("texels");
                    let texels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&texels);
                    space.picks.environment_pdf_solid = Some(Box::new(move |direction| {
                        let square = sphere_to_square(direction) * size;
                        let at = square.min(glam::DVec2::splat(size - 1.0)).floor();
                        let texel = texels[(at.y * size + at.x) as usize];
                        f64::from(texel[3]) * size * size / (4.0 * std::f64::consts::PI)
                    }));
                }
                _ => space.picks.punctual[light.index as usize] = pdf_select,
            }
        }
        Self { accel, device, lights, space }
    }

    fn freeze(&self, path: &FullPath) -> Frozen {
        let vertex = |vertex: &SurfaceVertex| {
            let (mesh, triangle) = vertex.scene_triangle;
            let found = self
                .accel
                .triangles
                .iter()
                .position(|t| (t.mesh as usize, t.triangle as usize) == (mesh, triangle))
                .expect("the device has it");
            let weights = [1.0 - vertex.b[0] - vertex.b[1], vertex.b[0], vertex.b[1]];
            let b = self.accel.triangles[found].corners.map(|corner| weights[corner as usize] as f32);
            [found as u32, b[1].to_bits(), b[2].to_bits(), 0]
        };
        let mut frozen = Frozen {
            direction: [0.0; 3],
            n: path.edges() as u32,
            kind: 0,
            light: 0,
            pad: [0; 2],
            vertices: [[0; 4]; VERTICES],
        };
        for (slot, surface) in frozen.vertices.iter_mut().zip(&path.surfaces) {
            *slot = vertex(surface);
        }
        let find = |test: &dyn Fn(&Light) -> bool| self.lights.iter().position(test).expect("a light") as u32;
        match &path.end {
            LightEnd::Emitter(end) => {
                let last = vertex(end);
                frozen.vertices[path.surfaces.len()] = last;
                frozen.light = find(&|light| light.kind == 0 && light.index == last[0]);
            }
            LightEnd::Environment(direction) => {
                frozen.direction = direction.as_vec3().to_array();
                frozen.light = find(&|light| light.kind == 1);
            }
            LightEnd::Punctual(index) => {
                frozen.light = find(&|light| light.kind > 1 && light.index as usize == *index);
                let direction = -self.space.world.scene.lights[*index].direction;
                frozen.direction = direction.to_array();
            }
        }
        frozen.kind = self.lights[frozen.light as usize].kind;
        frozen
    }

    /// Weights by path, t = 1 first.
    fn kernel_weights(&mut self, frozen: &[Frozen]) -> Vec<[f32; 10]> {
        let context = gpu::context();
        let mut features = self.device.kernel_features();
        features.insert("bidirectional");
        let stitched = stitch_text("frozen paths", KERNEL, &features).expect("directives");
        let kernel = Kernel::from_stitched(context, "frozen paths", &stitched, &self.device.constants)
            .expect("a kernel");
        let camera = self.device.camera(&self.space.view, RESOLUTION[0], RESOLUTION[1]);
        let mut buffers = std::mem::take(&mut self.device.buffers);
        let batch = Batch {
            width: RESOLUTION[0],
            height: RESOLUTION[1],
            crop_width: RESOLUTION[0],
            crop_height: RESOLUTION[1],
            light_path_count: 1,
            connection_density: CONNECTION_DENSITY,
            camera_paths: LIGHT_PATHS,
            ..Batch::default()
        };
        buffers.upload_uniform(context, "batch", &[batch]).expect("upload");
        buffers.upload_uniform(context, "camera", &[camera]).expect("upload");
        buffers.upload(context, "frozen", frozen).expect("upload");
        buffers.create(context, "weights", frozen.len() as u64 * 40).expect("create");
        self.run(&kernel, &buffers, frozen.len())
    }

    fn run(&self, kernel: &Kernel, buffers: &BufferTable, paths: usize) -> Vec<[f32; 10]> {
        let context = gpu::context();
        let bound = kernel.bind(context, buffers).expect("all buffers named");
        let mut encoder = context.device.create_command_encoder(&Default::default());
        bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), paths as u32);
        context.queue.submit([encoder.finish()]);
        let bytes = buffers.read(context, "weights", paths as u64 * 40).expect("read");
        bytemuck::pod_collect_to_vec(&bytes)
    }
}

/// A scene, how many samples the judge takes to find paths in it, and how many of its weights may be off by more than
/// 1e-4: positions are f32 in the kernels, and grazing cosines on short edges or narrow lobes have few digits left.
#[track_caller]
fn assert_partition(scene: &Scene, samples: u32, may_differ: f64) {
    let name = &scene.name;
    let mut bench = Bench::new(scene);
    let options =
        Options { resolution: RESOLUTION, samples, max_scatterings: VERTICES - 2, ..Options::default() };
    // The judge's own choice of lights finds the paths; the device's is in the densities.
    let mut paths = trace_full_paths(&PathSpace::new(scene, &scene.cameras[0], RESOLUTION), &options);
    paths.retain(|path| path.edges() < VERTICES);
    let frozen: Vec<Frozen> = paths.iter().map(|path| bench.freeze(path)).collect();
    let found = bench.kernel_weights(&frozen);

    let (mut checked, mut off, mut worst, mut worst_sum) = (0usize, 0usize, 0.0f64, 0.0f64);
    let mut lengths = [0usize; VERTICES + 1];
    for (path, found) in paths.iter().zip(&found) {
        let strategies =
            bench.space.strategies(path, |_, _| f64::from(CONNECTION_DENSITY), f64::from(LIGHT_PATHS));
        let expected = weights(&strategies);
        let found: Vec<f64> = found[..expected.len()].iter().map(|&weight| f64::from(weight)).collect();
        assert!(found.iter().all(|weight| weight.is_finite()), "{name}: {found:?}, {path:?}");
        lengths[path.edges()] += 1;
        let sum: f64 = found.iter().sum();
        worst_sum = worst_sum.max((sum - 1.0).abs());
        let difference = found
            .iter()
            .zip(&expected)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
            .max((sum - 1.0).abs());
        worst = worst.max(difference);
        checked += 1;
        off += usize::from(difference > 1e-4);
    }
    let share = off as f64 / checked as f64;
    println!(
        "{name}: {checked} paths (by edges {lengths:?}); largest difference {worst:.1e}, of a sum from one \
         {worst_sum:.1e}; {share:.5} differ by more than 1e-4"
    );
    assert!(checked >= 1000, "{name}: too few paths");
    assert!(share <= may_differ, "{name}: {share} of the weights differ");
    assert!(worst_sum <= 1e-2, "{name}: a path's weights sum to one within {worst_sum:e} only");
}

fn shown(name: &str) -> Scene {
    builtin(name).expect("a built-in scene")
}

/// A lamp that shines to both sides.
#[test]
fn c06_double_sided_lamp() {
    assert_partition(&double_sided_lamp(), 8, 2e-3);
}

/// Lamps and Lambert surfaces.
#[test]
fn c06_door() {
    assert_partition(&shown("door"), 8, 1e-3);
}

/// A lamp, a sky, a spot: lights that can be hit and lights that cannot.
#[test]
fn c06_three_lights() {
    assert_partition(&shown("three-lights"), 8, 2e-3);
}

/// Mirrors, glass, rough metal, coated plastic.
#[test]
fn c06_spheres() {
    assert_partition(&shown("spheres"), 8, 2e-2);
}

/// Bent normals.
#[test]
fn c06_bumpy_plane() {
    assert_partition(&shown("bumpy-plane"), 8, 2e-3);
}

/// The recursion alone, on random densities over many decades, against sums of logarithms (N-11).
#[test]
fn n11_ratios_neither_overflow_nor_vanish() {
    const LENGTH: usize = 32;
    let mut random = crate::random::Stream::new(11);
    let mut uniform = || random.f64();
    let scales = [-24.0, -12.0, 0.0, 12.0, 24.0];
    // Forward and backward densities of every vertex.
    let paths: Vec<(usize, Vec<[f32; 2]>)> = (0..2000)
        .map(|index| {
            let scale = 10f64.powf(scales[index % 5] / 2.0);
            let n = 2 + index % (LENGTH - 1);
            let pdfs = (0..=n).map(|_| [0, 1].map(|_| (scale * 10f64.powf(3.0 * uniform() - 1.5)) as f32));
            (n, pdfs.collect())
        })
        .collect();
    let inputs: Vec<[u32; 2 * LENGTH + 4]> = paths
        .iter()
        .map(|(n, pdfs)| {
            let mut words = [0; 2 * LENGTH + 4];
            words[0] = *n as u32;
            for (slot, pdf) in words[2..].chunks_mut(2).zip(pdfs) {
                slot.copy_from_slice(&pdf.map(f32::to_bits));
            }
            words
        })
        .collect();
    // One edge density for all; the weight of the hit, then of every connection from the light's end on.
    let outputs: Vec<[u32; LENGTH + 1]> = gpu::map(
        &["lib/mis"],
        "const C: f32 = 0.5;
        fn twin(x: array<u32, 68>) -> array<u32, 33> {
            var pdfs = x;
            var out: array<u32, 33>;
            let n = pdfs[0];
            // Eye's ratio of x_1 .. x_n; light's of x_n .. x_1.
            var eye: array<f32, 34>;
            var light: array<f32, 34>;
            for (var i = 2u; i <= n; i++) {
                let edge = select(0.0, C, i > 2u);
                let back = select(0.0, bitcast<f32>(pdfs[2u + 2u * (i - 2u) + 1u]), i > 2u);
                eye[i] = mis_step(eye[i - 1u], back, edge, bitcast<f32>(pdfs[2u + 2u * (i - 1u)]));
            }
            light[n] = 1.0;
            for (var i = n; i > 1u; i--) {
                let edge = select(C, 0.0, i == n);
                let back = select(bitcast<f32>(pdfs[2u + 2u * min(i + 1u, n)]), 1.0, i == n);
                light[i - 1u] = mis_step(light[i], back, edge, bitcast<f32>(pdfs[2u + 2u * i + 1u]));
            }
            let pdf_eye = bitcast<f32>(pdfs[2u + 2u * n]);
            let pdf_light = bitcast<f32>(pdfs[2u + 2u * n + 1u]);
            let pdf_previous = bitcast<f32>(pdfs[2u + 2u * (n - 1u) + 1u]);
            out[0] = bitcast<u32>(hit_weight(C, eye[n], pdf_previous, pdf_light, pdf_eye));
            for (var t = 2u; t <= n; t++) {
                // x_{t-1} is the eye's, x_t the light's.
                let eye_edge = select(0.0, C, t > 2u);
                let eye_back = select(0.0, bitcast<f32>(pdfs[2u + 2u * (t - 2u) + 1u]), t > 2u);
                let eye_step = mis_step(eye[t - 1u], eye_back, eye_edge, bitcast<f32>(pdfs[2u + 2u * (t - 1u)]));
                let light_edge = select(C, 0.0, t == n);
                let light_back = select(bitcast<f32>(pdfs[2u + 2u * min(t + 1u, n)]), 1.0, t == n);
                let light_step =
                    mis_step(light[t], light_back, light_edge, bitcast<f32>(pdfs[2u + 2u * t + 1u]));
                let backward = bitcast<f32>(pdfs[2u + 2u * (t - 1u) + 1u]);
                let forward = bitcast<f32>(pdfs[2u + 2u * t]);
                out[n + 1u - t] = bitcast<u32>(connection_weight(C, eye_step, backward, light_step, forward));
            }
            return out;
        }",
        &inputs,
    );
    let mut worst = [0.0f64; 2];
    for ((n, pdfs), out) in paths.iter().zip(&outputs) {
        let found: Vec<f64> = out[..*n].iter().map(|&bits| f64::from(f32::from_bits(bits))).collect();
        let ln = |i: usize, side: usize| f64::from(pdfs[i][side]).ln();
        let strategy = |s: usize| {
            let t = n + 1 - s;
            let eye: f64 = (1..t).map(|i| ln(i, 0)).sum();
            let light: f64 = (t..=*n).map(|i| ln(i, 1)).sum();
            eye + light + if s > 0 { 0.5f64.ln() } else { 0.0 }
        };
        let logs: Vec<f64> = (0..*n).map(strategy).collect();
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = logs.iter().map(|log| (log - largest).exp()).sum();
        worst[1] = worst[1].max((found.iter().sum::<f64>() - 1.0).abs());
        for (found, log) in found.iter().zip(&logs) {
            let expected = (log - largest).exp() / sum;
            assert!(found.is_finite());
            // A weight that vanishes in f32 may do so.
            worst[0] = worst[0].max((found - expected).abs() / expected.max(1e-30));
        }
    }
    println!("relative error of a weight {:.1e}, of a sum {:.1e}", worst[0], worst[1]);
    assert!(worst[0] <= 5e-6 && worst[1] <= 1e-5, "{worst:?}");
}
