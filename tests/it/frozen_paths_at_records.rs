//! Partition of unity of weights that know what light vertices bring to records (C-06), Nabata's form: the density of a
//! connection is a sum over the records nearest to its eye vertex, and over all vertices alike. The judge has the light that
//! a record gets, what hides it included, from the definitions, for every edge of a path.

use glam::Vec4;
use halfway::device::Feature;
use halfway::device::layout::{Batch, Record, RecordLink};
use halfway::math::kd_tree::KdTree;
use halfway::scene::Scene;
use halfway::scene::builtin::builtin;

use crate::frozen_paths::{
    self, Bench, Frozen, HIT_SCALE, LIGHT_PATHS, VERTICES, assert_same_weights, find_paths,
    plain_density_scale,
};
use crate::frozen_paths_subspaces::{dark_glass, open_paths, retain};
use crate::gpu;
use crate::random::Stream;
use crate::reference::path_space::{JudgesRecord, weights};

/// Mean number of vertices of light paths.
const VERTICES_A_PATH: f32 = 2.5;
/// Of light at a record: shaders/lib/record_light.
const LEAST_COSINE: f64 = 1.0 / 4096.0;
/// In `Record::depth_sides`.
const RECORD_SIDES: u32 = 16;

/// v of each choice by the definition, of `m` light paths: records by r and 1 / Q of each, then all vertices alike.
fn densities(m: u32, light: &[(f64, f64)]) -> [f64; 4] {
    let m = f64::from(m);
    let known = light.iter().filter(|(_, inv_q)| *inv_q > 0.0).count() as f64;
    let mut v = [0.0; 4];
    for (v, &(r, inv_q)) in v.iter_mut().zip(light) {
        if r > 0.0 && inv_q > 0.0 {
            *v = 0.25 * m / ((m - 1.0) * (1.0 / inv_q / r).max(1e-3) + 1.0);
        }
    }
    v[3] = (1.0 - 0.25 * known) * m / ((m - 1.0) * f64::from(VERTICES_A_PATH) + 1.0);
    v
}

/// With so many records, of which some know nothing, and `m` light paths to draw from, in some forms of the kernels, without
/// light tracing and with it.
#[track_caller]
fn assert_partition(
    scene: &Scene,
    [records, m]: [u32; 2],
    forms: &[(&[Feature], f32)],
    samples: u32,
    may_differ: f64,
) {
    let context = gpu::context();
    let mut bench = Bench::new(scene);
    let mut paths = find_paths(scene, samples);
    let mut frozen: Vec<Frozen> = paths.iter().map(|path| bench.freeze(path)).collect();
    // Positions first, for the records.
    let mut found = bench.kernel_finds(&frozen, 0.0, frozen_paths::forms(scene)[0], None);
    let keep = open_paths(&bench, &paths, &frozen, &found);
    retain(&mut paths, &keep);
    retain(&mut frozen, &keep);
    retain(&mut found, &keep);
    let mut random = Stream::new(9);
    let with_surfaces: Vec<usize> = (0..paths.len()).filter(|&at| paths[at].edges() > 1).collect();
    // Vertices of paths, each a record by itself, so that none lies on a path of the test twice.
    let places: Vec<(usize, usize)> = (0..records)
        .map(|_| {
            let path = with_surfaces[random.word() as usize % with_surfaces.len()];
            (path, random.word() as usize % (paths[path].edges() - 1))
        })
        .collect();
    let positions: Vec<[f32; 3]> =
        places.iter().map(|&(path, i)| Vec4::from(found[path].points[i][0]).truncate().to_array()).collect();
    let (tree, order) = KdTree::build(&positions);
    let unit = bench.accel.unit.world_length(1.0);
    let (mut list, mut judged): (Vec<Record>, Vec<JudgesRecord>) = (Vec::new(), Vec::new());
    for &index in &order {
        let (path, i) = places[index as usize];
        let [triangle, b1, b2, _] = frozen[path].vertices[i];
        let inv_q = if random.f32() < 0.1 { 0.0 } else { 1e4f32.powf(random.f32() - 0.3) };
        let sides = 1 + random.word() % 3;
        let most_geometry = 30f32.powf(random.f32() + 0.5);
        list.push(Record {
            position: positions[index as usize],
            triangle,
            b1: f32::from_bits(b1),
            b2: f32::from_bits(b2),
            depth_sides: sides << RECORD_SIDES,
            inv_q,
            most_geometry,
            ..Record::default()
        });
        judged.push(JudgesRecord {
            vertex: paths[path].surfaces[i],
            sides: [sides & 1 != 0, sides & 2 != 0],
            least_cosine: LEAST_COSINE,
            most_geometry: f64::from(most_geometry) / (unit * unit),
        });
    }
    let padded: Vec<Record> = list.iter().copied().chain([Record::default()]).collect();
    bench.device.buffers.upload(context, "records", &padded).expect("upload");
    let links = (paths.len() * VERTICES * size_of::<RecordLink>()) as u64;
    bench.device.buffers.create(context, "eye_links", links).expect("create");
    bench.batch =
        Batch { light_path_count: m, records, vertices_per_path: VERTICES_A_PATH, ..Batch::default() };
    // By path, then by edge from x_1 on: v of each choice.
    let v: Vec<Vec<[f64; 4]>> = paths
        .iter()
        .zip(&found)
        .map(|(path, found)| {
            let ln_pdfs = bench.space.densities(path).ln_light;
            let of_edge = |i: usize| {
                let position = Vec4::from(found.points[i - 1][0]).truncate().to_array();
                let light: Vec<(f64, f64)> = tree
                    .nearest(position)
                    .iter()
                    .map(|&(place, _)| {
                        let ln_light = bench.space.ln_light_at_record(path, i + 1, &judged[place as usize]);
                        // In the kernels' units: radiance is a power of two of the scene's.
                        let exponent = f64::from(bench.device.radiance_exponent) * std::f64::consts::LN_2;
                        let r = (ln_light - ln_pdfs[i + 1..].iter().sum::<f64>() - exponent).exp();
                        (r, f64::from(list[place as usize].inv_q))
                    })
                    .collect();
                densities(m, &light)
            };
            (1..path.edges()).map(of_edge).collect()
        })
        .collect();
    for &(form, light_paths) in forms {
        bench.device.buffers.create(context, "eye_link_count", 4).expect("create");
        let choices = paths.len() as u64 * 128;
        bench.device.buffers.create(context, "choices", choices).expect("create");
        let form: Vec<Feature> = form.iter().copied().chain([Feature::AtRecords, Feature::AnyHit]).collect();
        let found = bench.kernel_finds(&frozen, light_paths, &form, None);
        let expected = |at: usize| {
            let density = |i: usize| {
                let scale = f64::from(plain_density_scale(i, light_paths)) * bench.thinning(&paths[at], i);
                scale * v[at][i - 1].iter().sum::<f64>()
            };
            let strategies = bench.space.densities(&paths[at]).strategies(
                density,
                f64::from(HIT_SCALE),
                f64::from(light_paths),
            );
            weights(&strategies)
        };
        let name = format!("{} {form:?}, {records} records, {m}, {light_paths} light paths", scene.name);
        assert_same_weights(&name, &paths, &found, expected, may_differ);
        // What each choice has of a connection.
        let bytes = bench.device.buffers.read(context, "choices", choices).expect("read");
        let choices: Vec<[[f32; 4]; 8]> = bytemuck::pod_collect_to_vec(&bytes);
        let (mut checked, mut off) = (0usize, 0usize);
        for ((path, choices), (found, v)) in paths.iter().zip(&choices).zip(found.iter().zip(&v)) {
            for i in 1..path.edges() {
                let weight = f64::from(found.weights[i]);
                let sum: f64 = v[i - 1].iter().sum();
                let pairs = choices[i].iter().zip(&v[i - 1]);
                let worst = pairs.map(|(&a, v)| (f64::from(a) - weight * v / sum).abs()).fold(0.0, f64::max);
                checked += 1;
                off += usize::from(worst > 1e-4);
            }
        }
        println!("{name}: {off} of {checked} connections differ in the part of a choice");
        assert!(off as f64 <= may_differ * checked as f64, "{name}: {off} of {checked}");
    }
}

const LAMBERT: &[Feature] = &[Feature::LambertVertices];

/// A lamp, a sky, a point, a spot, a sun.
#[test]
fn c06_at_records_three_lights() {
    let scene = builtin("three-lights").expect("a built-in scene");
    assert_partition(&scene, [60, 50], &[(&[], LIGHT_PATHS), (LAMBERT, 0.0)], 4, 2e-3);
}

/// Fewer records than three, and none; one light path.
#[test]
fn c06_at_records_that_are_few() {
    let scene = builtin("door").expect("a built-in scene");
    for of in [[0, 50], [2, 50], [40, 1]] {
        assert_partition(&scene, of, &[(LAMBERT, 0.0)], 4, 2e-3);
    }
}

/// Smooth and rough glass that absorbs.
#[test]
fn c06_at_records_dark_glass() {
    assert_partition(&dark_glass(), [60, 50], &[(&[Feature::Thinning], 0.0)], 4, 2e-3);
}
