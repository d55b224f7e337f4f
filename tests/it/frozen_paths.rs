//! Partition of unity (C-06, N-11): the weights that the kernels' own functions give to every strategy of a frozen
//! path, against the judge's, which come from the definitions.

use glam::DVec4;
use halfway::accel::Accel;
use halfway::device::layout::{Batch, Camera, Light, Material, THINNING_SHIFT, THINNING_UNITS};
use halfway::device::scene::DeviceScene;
use halfway::device::shader::stitch_text;
use halfway::device::{Feature, Kernel, PagedBuffer};
use halfway::math::alias::AliasEntry;
use halfway::math::equal_area::sphere_to_square;
use halfway::math::shared_exponent::unpack;
use halfway::scene::builtin::builtin;
use halfway::scene::{Scene, SceneFeatures};

use crate::bent_normals::low_poly;
use crate::bidirectional::double_sided_lamp;
use crate::closed_forms::pipe_of_mirrors;
use crate::gpu;
use crate::reference::bidirectional::{Options, trace_full_paths};
use crate::reference::path_space::{FullPath, LightEnd, PathSpace, SurfaceVertex, weights};

/// Vertices that a frozen path may have beside the camera.
pub const VERTICES: usize = 8;
pub const RESOLUTION: [u32; 2] = [32, 32];
pub const LIGHT_PATHS: f32 = 700.0;
/// Any factors on the densities of connections, by the number of the eye vertex, and on that of light that is hit.
const DENSITY_SCALES: [f32; 3] = [2.3, 0.4, 0.9];
pub const HIT_SCALE: f32 = 3.0;

/// The factor of connecting x_i.
pub fn density_scale(i: usize) -> f32 {
    DENSITY_SCALES[(i - 1).min(2)]
}

/// The same where weights take the density of connections as the same for all pairs: light paths that reach the camera know
/// one factor for the second vertex and all that follow.
pub fn plain_density_scale(i: usize, light_paths: f32) -> f32 {
    density_scale(if light_paths > 0.0 && i > 1 { 3 } else { i })
}

const KERNEL: &str = concat!(include_str!("frozen_paths.wgsl"), include_str!("frozen_steps.wgsl"));

/// What the kernel says of a path.
pub struct Found {
    /// By strategy, t = 1 first.
    pub weights: [f32; 10],
    /// Position and geometric normal of x_1 .. x_n in unit space.
    pub points: [[[f32; 4]; 2]; VERTICES],
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frozen {
    direction: [f32; 3],
    n: u32,
    kind: u32,
    /// Index in the device's list of lights.
    pub light: u32,
    pad: [u32; 2],
    /// Triangle and barycentrics b1, b2.
    pub vertices: [[u32; 4]; VERTICES],
}

/// A scene on the device, beside the judge with the device's own probabilities.
pub struct Bench<'a> {
    pub accel: Accel,
    pub device: DeviceScene,
    pub lights: Vec<Light>,
    pub space: PathSpace<'a>,
    /// Of each material, as the device has it.
    thinning: Vec<f64>,
    /// What kernels are told beside what all tests tell them.
    pub batch: Batch,
}

impl<'a> Bench<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let context = gpu::context();
        let accel = Accel::build(scene).expect("a tree");
        let device =
            DeviceScene::new(context, scene, &accel, SceneFeatures::of(scene)).expect("a device scene");
        let bytes = (device.lights.len() * size_of::<Light>()) as u64;
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
                    let texels: Vec<[u32; 2]> =
                        PagedBuffer::EnvironmentTexels.read(context, &device.buffers).expect("texels");
                    let size = (texels.len() as f64).sqrt();
                    let entries: Vec<AliasEntry> =
                        PagedBuffer::EnvironmentAlias.read(context, &device.buffers).expect("a table");
                    // How often a texel is drawn, by the table and not by what the kernels make of its radiance.
                    let mut units = vec![0u64; entries.len()];
                    for (slot, entry) in entries.iter().enumerate() {
                        // A slot that is its own alias is full.
                        let own =
                            if entry.alias as usize == slot { 1 << 32 } else { u64::from(entry.threshold) };
                        units[slot] += own;
                        units[entry.alias as usize] += (1 << 32) - own;
                    }
                    let texel = move |direction| {
                        let square = sphere_to_square(direction) * size;
                        let at = square.min(glam::DVec2::splat(size - 1.0)).floor();
                        let index = (at.y * size + at.x) as usize;
                        let [r, g, b] = unpack(texels[index]).map(f64::from);
                        [r, g, b, units[index] as f64 / (size * size * 2f64.powi(32))]
                    };
                    let radiance = texel.clone();
                    let scale = f64::from(device.radiance_exponent).exp2();
                    space.sky_radiance =
                        Some(Box::new(move |direction| scale * DVec4::from(radiance(direction)).truncate()));
                    space.picks.environment_pdf_solid = Some(Box::new(move |direction| {
                        texel(direction)[3] * size * size / (4.0 * std::f64::consts::PI)
                    }));
                }
                _ => space.picks.punctual[light.index as usize] = pdf_select,
            }
        }
        let bytes = (scene.materials.len() * size_of::<Material>()) as u64;
        let materials: Vec<Material> = bytemuck::pod_collect_to_vec(
            &device.buffers.read(context, "materials", bytes).expect("materials"),
        );
        let thinning =
            |material: &Material| f64::from(material.flags >> THINNING_SHIFT) / f64::from(THINNING_UNITS);
        let thinning: Vec<f64> = materials.iter().map(thinning).collect();
        // Lambert's law has all of its connections.
        let all = thinning.iter().all(|&share| share == 1.0);
        assert!(all || !SceneFeatures::of(scene).lambert_only, "{thinning:?}");
        Self {
            accel,
            device,
            lights,
            space,
            thinning,
            batch: Batch { light_path_count: 1, ..Batch::default() },
        }
    }

    /// Share of its connections that x_i makes.
    pub fn thinning(&self, path: &FullPath, i: usize) -> f64 {
        let mesh = &self.space.world.scene.meshes[path.surfaces[i - 1].scene_triangle.0];
        self.thinning[mesh.material as usize]
    }

    pub fn freeze(&self, path: &FullPath) -> Frozen {
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

    /// What the kernel, in a form of it, finds for each path, with light tracing by so many light paths. `subspaces`:
    /// connections by so many; their buffers are there.
    pub fn kernel_finds(
        &mut self,
        frozen: &[Frozen],
        light_paths: f32,
        form: &[Feature],
        subspaces: Option<u32>,
    ) -> Vec<Found> {
        let context = gpu::context();
        let mut features = self.device.kernel_features();
        features.insert(Feature::Bidirectional);
        features.extend(form.iter().copied());
        let constants = self.device.constants.clone();
        if subspaces.is_some() {
            features.insert(Feature::Subspaces);
        }
        let mut stitched = stitch_text("frozen paths", KERNEL, features).expect("directives");
        let caught_run = |run: usize| format!("const CAUGHT_RUN: u32 = {run}u;");
        assert!(stitched.code.contains(&caught_run(16)));
        stitched.code = stitched.code.replace(&caught_run(16), &caught_run(self.space.caught_run));
        let kernel = Kernel::from_stitched(context, "frozen paths", &stitched, &constants).expect("a kernel");
        let camera = Camera::new(&self.device.unit, &self.space.view, RESOLUTION[0], RESOLUTION[1]);
        let buffers = &mut self.device.buffers;
        let batch = Batch {
            width: RESOLUTION[0],
            height: RESOLUTION[1],
            crop_width: RESOLUTION[0],
            crop_height: RESOLUTION[1],
            crop_stride: 1,
            hit_scale: HIT_SCALE,
            density_scales: [1, 2, 3].map(|i| match subspaces {
                Some(_) => density_scale(i),
                None => plain_density_scale(i, light_paths),
            }),
            camera_paths: light_paths,
            subspaces: subspaces.unwrap_or(0),
            ..self.batch
        };
        buffers.upload_uniform(context, "batch", &[batch]).expect("upload");
        buffers.upload_uniform(context, "camera", &[camera]).expect("upload");
        buffers.upload(context, "frozen", frozen).expect("upload");
        let count = frozen.len() as u64;
        let (weights, points) = (count * 40, count * 32 * VERTICES as u64);
        buffers.create(context, "weights", weights).expect("create");
        buffers.create(context, "points", points).expect("create");
        let bound = kernel.bind(context, buffers).expect("all buffers named");
        let mut encoder = context.device.create_command_encoder(&Default::default());
        bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), frozen.len() as u32);
        context.queue.submit([encoder.finish()]);
        let read = |name: &str, bytes: u64| buffers.read(context, name, bytes).expect("read");
        let weights: Vec<[f32; 10]> = bytemuck::pod_collect_to_vec(&read("weights", weights));
        let points: Vec<[[[f32; 4]; 2]; VERTICES]> = bytemuck::pod_collect_to_vec(&read("points", points));
        weights.into_iter().zip(points).map(|(weights, points)| Found { weights, points }).collect()
    }
}

/// Paths of the scene, as many as the judge finds with so many samples.
pub fn find_paths(scene: &Scene, samples: u32) -> Vec<FullPath> {
    let options =
        Options { resolution: RESOLUTION, samples, max_scatterings: VERTICES - 2, ..Options::default() };
    // The judge's own choice of lights finds the paths; the device's is in the densities.
    let mut paths = trace_full_paths(&PathSpace::new(scene, &scene.cameras[0], RESOLUTION), &options);
    paths.retain(|path| path.edges() < VERTICES);
    paths
}

/// A scene, how many samples the judge takes to find paths in it, and how many of its weights may be off by more than
/// 1e-4: positions are f32 in the kernels, and grazing cosines on short edges or narrow lobes have few digits left.
#[track_caller]
fn assert_partition(scene: &Scene, samples: u32, may_differ: f64) {
    assert_partition_of(Bench::new(scene), samples, may_differ);
}

#[track_caller]
fn assert_partition_of(mut bench: Bench, samples: u32, may_differ: f64) {
    let scene = bench.space.world.scene;
    let paths = find_paths(scene, samples);
    let frozen: Vec<Frozen> = paths.iter().map(|path| bench.freeze(path)).collect();
    for (form, light_paths) in forms(scene).iter().flat_map(|form| [(form, 0.0), (form, LIGHT_PATHS)]) {
        let found = bench.kernel_finds(&frozen, light_paths, form, None);
        let expected = |index: usize| {
            let density = |i: usize, path: &FullPath| {
                f64::from(plain_density_scale(i, light_paths)) * bench.thinning(path, i)
            };
            let strategies =
                bench.space.strategies(&paths[index], density, f64::from(HIT_SCALE), f64::from(light_paths));
            weights(&strategies)
        };
        let name = format!("{} {form:?}, {light_paths} light paths", scene.name);
        assert_same_weights(&name, &paths, &found, expected, may_differ);
    }
}

/// The features of each form that the kernels have for a scene.
pub fn forms(scene: &Scene) -> &'static [&'static [Feature]] {
    match SceneFeatures::of(scene).lambert_only {
        true => &[&[], &[Feature::LambertVertices]],
        false => &[&[Feature::Thinning]],
    }
}

/// Every weight, and every sum of one.
#[track_caller]
pub fn assert_same_weights(
    name: &str,
    paths: &[FullPath],
    found: &[Found],
    expected: impl Fn(usize) -> Vec<f64>,
    may_differ: f64,
) {
    let (mut checked, mut off, mut worst, mut worst_sum) = (0usize, 0usize, 0.0f64, 0.0f64);
    let mut lengths = [0usize; VERTICES + 1];
    let mut differences = Vec::new();
    for (index, (path, found)) in paths.iter().zip(found).enumerate() {
        let expected = expected(index);
        let found: Vec<f64> =
            found.weights[..expected.len()].iter().map(|&weight| f64::from(weight)).collect();
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
        differences.push(difference);
    }
    differences.sort_by(f64::total_cmp);
    let share = off as f64 / checked as f64;
    println!(
        "{name}: {checked} paths (by edges {lengths:?}); median difference {:.1e}, largest {worst:.1e}, of a sum from \
         one {worst_sum:.1e}; {share:.5} differ by more than 1e-4",
        differences[checked / 2]
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

/// Rows of mirrors, of which roulette ends more from the second or the third on, counted by the eye path from its side and by
/// the light path from its own.
#[test]
fn c06_rows_of_mirrors() {
    let scene = pipe_of_mirrors(4.0);
    for caught_run in [1, 2] {
        let mut bench = Bench::new(&scene);
        bench.space.caught_run = caught_run;
        assert_partition_of(bench, 32, 2e-3);
    }
}

/// Bent normals.
#[test]
fn c06_bumpy_plane() {
    assert_partition(&shown("bumpy-plane"), 8, 2e-3);
}

/// Normals bent far, on metal, plastic and glass, smooth and rough.
#[test]
fn c06_low_poly() {
    assert_partition(&low_poly(0.3), 8, 2e-2);
    assert_partition(&low_poly(0.0), 8, 2e-2);
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
            out[0] = bitcast<u32>(hit_weight(1.0, C, eye[n], pdf_previous, pdf_light, pdf_eye));
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
