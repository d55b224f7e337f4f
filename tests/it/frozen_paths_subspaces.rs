//! Partition of unity of connections by subspaces (C-06): Gamma and Q are in the densities, and |f_y| of the light
//! sub-path. The judge has all of it from the definitions: it classifies each vertex on the host, by the way that a sub-path
//! which ends there would have come.

use glam::{Vec3, Vec4};
use halfway::device;
use halfway::device::layout::TreeNode;
use halfway::math::equal_area::sphere_to_square;
use halfway::scene::builtin::{builtin, shapes};
use halfway::scene::{AlphaMode, LightKind, Material, Scene};
use halfway::subspace::tree::Growth;
use halfway::subspace::{
    Connections, Feature, LightEnd, Model, Settings, SourceLabels, TrainingReport, Tree,
};

use crate::bidirectional::double_sided_lamp;
use crate::frozen_paths::{
    Bench, Found, Frozen, HIT_SCALE, LIGHT_PATHS, assert_same_weights, density_scale, find_paths, forms,
};
use crate::gpu;
use crate::judge::{grey, horizontal, lamp, scene};
use crate::random::Stream;
use crate::reference::path_space::{FullPath, LightEnd as JudgesEnd, weights};

/// Subspaces a side, and those of them that points on lights share.
const SUBSPACES: u32 = 24;
const SOURCE_SUBSPACES: u32 = 9;

/// Where a path's vertices are, as far as their labels depend on it.
struct Seen<'a> {
    bench: &'a Bench<'a>,
    path: &'a FullPath,
    frozen: &'a Frozen,
    found: &'a Found,
}

impl Seen<'_> {
    fn position(&self, i: usize) -> Vec3 {
        Vec4::from(self.found.points[i - 1][0]).truncate()
    }

    /// Unit direction from x_i to x_{i+1}.
    fn onward(&self, i: usize) -> Vec3 {
        let unit = &self.bench.accel.unit;
        if i == 0 {
            return (self.position(1) - unit.point(self.path.camera)).normalize();
        }
        if i + 1 < self.path.edges() {
            return (self.position(i + 1) - self.position(i)).normalize();
        }
        match &self.path.end {
            JudgesEnd::Emitter(_) => (self.position(i + 1) - self.position(i)).normalize(),
            JudgesEnd::Environment(direction) => direction.as_vec3(),
            JudgesEnd::Punctual(index) => {
                let light = &self.bench.space.world.scene.lights[*index];
                match light.kind {
                    LightKind::Directional => -light.direction,
                    _ => (unit.point(light.position) - self.position(i)).normalize(),
                }
            }
        }
    }

    /// No edge grazes the surfaces that it joins.
    fn is_open(&self) -> bool {
        (1..self.path.edges()).all(|i| {
            let normal = Vec4::from(self.found.points[i - 1][1]).truncate();
            [self.onward(i - 1), self.onward(i)].iter().all(|direction| normal.dot(*direction).abs() > 1e-6)
        })
    }

    /// x_i as the end of a sub-path that came from `direction`.
    fn feature(&self, i: usize, direction: Vec3) -> Feature {
        let (mesh, _) = self.path.surfaces[i - 1].scene_triangle;
        let scene = self.bench.space.world.scene;
        let passes = scene.materials[scene.meshes[mesh].material as usize].transmission > 0.0;
        let front = Vec4::from(self.found.points[i - 1][1]).truncate();
        let normal = if passes || front.dot(direction) > 0.0 { front } else { -front };
        Feature { position: self.position(i), normal, direction }
    }

    /// What an eye sub-path that ends at x_i is classified by.
    fn eye(&self, i: usize) -> Feature {
        self.feature(i, -self.onward(i - 1))
    }

    /// What a light sub-path that ends at x_i is classified by.
    fn light(&self, i: usize) -> LightEnd {
        if i < self.path.edges() {
            return LightEnd::Surface(self.feature(i, self.onward(i)));
        }
        let at = match &self.path.end {
            JudgesEnd::Emitter(_) => {
                let [_, b1, b2, _] = self.frozen.vertices[i - 1];
                [f32::from_bits(b1), f32::from_bits(b2)]
            }
            JudgesEnd::Environment(direction) => sphere_to_square(*direction).as_vec2().to_array(),
            JudgesEnd::Punctual(_) => [0.0; 2],
        };
        LightEnd::Source { light: self.frozen.light, at }
    }
}

/// Paths of which no edge grazes the surfaces that it joins: there the judge's own rounding is seen.
pub fn open_paths(bench: &Bench, paths: &[FullPath], frozen: &[Frozen], found: &[Found]) -> Vec<bool> {
    (0..paths.len())
        .map(|at| Seen { bench, path: &paths[at], frozen: &frozen[at], found: &found[at] }.is_open())
        .collect()
}

/// Trees that put each feature where the nearest of some others is, any Gamma, any Q.
fn random_model(features: &[[Feature; 2]], lights: usize, direction: bool, random: &mut Stream) -> Model {
    let surfaces = SUBSPACES - SOURCE_SUBSPACES;
    let mut tree = |side: usize, labels: u32| {
        if features.is_empty() {
            return Tree::single(0);
        }
        let samples: Vec<(Feature, f64)> = features.iter().map(|pair| (pair[side], 1.0)).collect();
        let mut pick = || samples[random.word() as usize % samples.len()].0;
        let centres: Vec<Feature> = (0..labels).map(|_| pick()).collect();
        let apart = |a: &Feature, b: &Feature| {
            let turned = if direction { a.direction.distance_squared(b.direction) } else { 0.0 };
            a.position.distance_squared(b.position) + 0.1 * a.normal.distance_squared(b.normal) + 0.2 * turned
        };
        let nearest = |feature: &Feature| {
            (0..labels)
                .min_by(|&a, &b| {
                    apart(feature, &centres[a as usize]).total_cmp(&apart(feature, &centres[b as usize]))
                })
                .expect("there are labels")
        };
        let labels: Vec<u32> = samples.iter().map(|(feature, _)| nearest(feature)).collect();
        Tree::grow(&samples, &labels, Growth { depth: 12, stop: 1.0, direction })
    };
    let (eye_tree, light_tree) = (tree(0, SUBSPACES), tree(1, surfaces));
    let sources = (0..lights)
        .map(|_| {
            let divisions = 1 + random.word() % 3;
            let spare = SOURCE_SUBSPACES - divisions * divisions;
            SourceLabels { first: surfaces + random.word() % (spare + 1), divisions }
        })
        .collect();
    let k = SUBSPACES as usize;
    let mut gamma: Vec<f32> = (0..k * k).map(|_| 100f32.powf(random.f32())).collect();
    for row in gamma.chunks_mut(k) {
        let sum: f32 = row.iter().sum();
        row.iter_mut().for_each(|entry| *entry /= sum);
    }
    let q = (0..k).map(|_| 100f32.powf(random.f32() - 1.0)).collect();
    Model {
        scene_hash: 0,
        connections: Connections::even(1),
        seed: 0,
        settings: Settings::default(),
        subspaces: SUBSPACES,
        eye_tree,
        light_tree,
        centroids: Default::default(),
        sources,
        gamma,
        q,
        guide: None,
        first_connections: None,
        report: TrainingReport::default(),
    }
}

fn upload(bench: &mut Bench, model: &Model) {
    let (context, buffers) = (gpu::context(), &mut bench.device.buffers);
    buffers.upload::<TreeNode>(context, "eye_tree", model.eye_tree.nodes()).expect("upload");
    buffers.upload::<TreeNode>(context, "light_tree", model.light_tree.nodes()).expect("upload");
    buffers.upload(context, "source_labels", &model.sources).expect("upload");
    buffers.upload(context, "gamma_pdf", &model.tables().expect("rows").pdf).expect("upload");
    let inv_q: Vec<f32> = model.q.iter().map(|q| 1.0 / q).collect();
    buffers.upload(context, "inv_q", &inv_q).expect("upload");
}

pub fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    list.retain(|_| *keep.next().expect("one for each"));
}

/// With light tracing and without.
#[track_caller]
fn assert_partition(scene: &Scene, samples: u32, may_differ: f64, direction: bool) {
    let mut bench = Bench::new(scene);
    let mut paths = find_paths(scene, samples);
    let mut frozen: Vec<Frozen> = paths.iter().map(|path| bench.freeze(path)).collect();
    // Positions first, to grow trees about.
    let blank = random_model(&[], bench.lights.len(), false, &mut Stream::new(0));
    upload(&mut bench, &blank);
    let forms = if direction {
        &[&[device::Feature::SubspaceDirections, device::Feature::Thinning][..]]
    } else {
        forms(scene)
    };
    let subspaces = Some(SUBSPACES);
    let mut found = bench.kernel_finds(&frozen, 0.0, forms[0], subspaces);
    let keep = open_paths(&bench, &paths, &frozen, &found);
    retain(&mut paths, &keep);
    retain(&mut frozen, &keep);
    retain(&mut found, &keep);
    println!("{}: {} paths along faces left out", scene.name, keep.len() - paths.len());
    let ends: Vec<[Feature; 2]> = (0..paths.len())
        .flat_map(|at| {
            let seen = Seen { bench: &bench, path: &paths[at], frozen: &frozen[at], found: &found[at] };
            let both = |i| {
                let LightEnd::Surface(light) = seen.light(i) else { panic!("no surface") };
                [seen.eye(i), light]
            };
            (1..paths[at].edges()).map(both).collect::<Vec<_>>()
        })
        .collect();
    let model = random_model(&ends, bench.lights.len(), direction, &mut Stream::new(6));
    upload(&mut bench, &model);
    let sizes = [model.eye_tree.nodes().len(), model.light_tree.nodes().len()];
    println!("{}: trees of {sizes:?} nodes", scene.name);
    let pdf = model.tables().expect("rows").pdf;
    let unit = bench.accel.unit.length(1.0);
    // Light paths that are guided anyhow make no difference to weights.
    let guided: Vec<Vec<device::Feature>> =
        forms.iter().map(|form| [form, &[device::Feature::Nominal][..]].concat()).collect();
    let forms = forms.iter().map(|form| form.to_vec()).chain(guided);
    for (form, light_paths) in forms.flat_map(|form| [(form.clone(), 0.0), (form, LIGHT_PATHS)]) {
        let found = bench.kernel_finds(&frozen, light_paths, &form, subspaces);
        let expected = |at: usize| {
            let path = &paths[at];
            let seen = Seen { bench: &bench, path, frozen: &frozen[at], found: &found[at] };
            let (ln_light, densities) = (bench.space.ln_light(path), bench.space.densities(path));
            let density = |i: usize| {
                let row = model.eye_label(&seen.eye(i));
                let column = model.light_label(&seen.light(i + 1));
                // |w| in the kernels' units: radiance is a power of two of the scene's, and areas are in unit space.
                let mut ln_w = ln_light[i + 1] - densities.ln_light[i + 1..].iter().sum::<f64>();
                ln_w -= f64::from(bench.device.radiance_exponent) * std::f64::consts::LN_2;
                if i + 1 < path.edges() || !is_parallel(scene, path) {
                    ln_w += 2.0 * unit.ln();
                }
                let share = f64::from(pdf[(row * SUBSPACES + column) as usize]);
                let scale = f64::from(density_scale(i)) * bench.thinning(path, i);
                scale * share / f64::from(model.q[column as usize]) * ln_w.exp()
            };
            weights(&densities.strategies(density, f64::from(HIT_SCALE), f64::from(light_paths)))
        };
        let name = format!("{} {form:?}, {light_paths} light paths", scene.name);
        assert_same_weights(&name, &paths, &found, expected, may_differ);
    }
}

/// The light is infinitely far.
fn is_parallel(scene: &Scene, path: &FullPath) -> bool {
    match &path.end {
        JudgesEnd::Emitter(_) => false,
        JudgesEnd::Environment(_) => true,
        JudgesEnd::Punctual(index) => scene.lights[*index].kind == LightKind::Directional,
    }
}

fn shown(name: &str) -> Scene {
    builtin(name).expect("a built-in scene")
}

#[test]
fn c06_subspaces_double_sided_lamp() {
    assert_partition(&double_sided_lamp(), 8, 2e-3, false);
}

/// A lamp, a sky, a point, a spot, a sun.
#[test]
fn c06_subspaces_three_lights() {
    assert_partition(&shown("three-lights"), 8, 2e-3, false);
}

/// Bent normals.
#[test]
#[ignore = "minutes of compiling on a software device; subspaces know nothing of normal maps, which `c06_bumpy_plane` has"]
fn c06_subspaces_bumpy_plane() {
    assert_partition(&shown("bumpy-plane"), 8, 2e-3, false);
}

/// A corner of walls of one pure colour each: light of other channels arrives and does not go on.
pub fn pure_colors() -> Scene {
    let pure = |color: [f32; 3]| Material::lambert("pure", color.into());
    let wall = |x: f64| shapes::quad(glam::DVec3::new(x, 0.0, -1.0), glam::DVec3::Y, glam::DVec3::Z * 2.0);
    let mut scene = scene([
        (pure([0.8, 0.0, 0.0]), horizontal(2.0, 0.0, true)),
        (Material { double_sided: true, ..pure([0.7, 0.6, 0.0]) }, wall(-1.0)),
        (Material { double_sided: true, ..pure([0.9, 0.0, 0.5]) }, wall(1.0)),
        (grey(0.7), horizontal(2.0, 1.2, false)),
        // Half there, and half as strong as a light: |f_y| knows.
        (Material { alpha: 0.6, alpha_mode: AlphaMode::Blend, ..lamp(3.0) }, horizontal(0.5, 1.1, false)),
    ]);
    scene.name = "pure colours".into();
    scene.cameras.push(shapes::looking_at(
        "front",
        glam::DVec3::new(0.0, 0.6, 3.0),
        glam::DVec3::Y * 0.6,
        50.0,
    ));
    scene
}

#[test]
fn c06_subspaces_pure_colors() {
    assert_partition(&pure_colors(), 8, 2e-3, false);
}

/// Glass that absorbs, smooth and rough, over a floor.
pub fn dark_glass() -> Scene {
    let glass = |roughness| Material {
        metallic: 0.0,
        transmission: 1.0,
        volume: true,
        roughness,
        attenuation_distance: 0.2,
        attenuation_color: Vec3::new(0.7, 0.3, 0.5),
        ..Material::default()
    };
    let cube =
        |x: f64| shapes::cuboid(glam::DVec3::new(x - 0.3, 0.2, -0.3), glam::DVec3::new(x + 0.3, 0.6, 0.3));
    let mut scene = scene([
        (grey(0.7), horizontal(2.0, 0.0, true)),
        (glass(0.0), cube(-0.4)),
        (glass(0.5), cube(0.4)),
        (lamp(3.0), horizontal(1.5, 1.1, false)),
    ]);
    scene.name = "dark glass".into();
    scene.cameras.push(shapes::looking_at(
        "front",
        glam::DVec3::new(0.0, 0.9, 3.0),
        glam::DVec3::Y * 0.3,
        40.0,
    ));
    scene
}

#[test]
fn c06_subspaces_dark_glass() {
    assert_partition(&dark_glass(), 8, 2e-3, false);
}

/// Trees that look at where sub-paths come from, which is another direction from either end.
#[test]
fn c06_subspaces_by_direction() {
    assert_partition(&double_sided_lamp(), 8, 2e-3, true);
}
