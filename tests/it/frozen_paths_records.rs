//! Partition of unity of weights that know of records (C-06): the density of a connection is that of a draw from M light
//! paths, a function of the light r that arrives at the eye vertex and of Q of the records nearest to it. The judge has r
//! and the nearest records from the definitions.

use glam::{DVec3, Vec4};
use halfway::device::Feature;
use halfway::device::layout::{Batch, EyeLink, Record};
use halfway::math::kd_tree::KdTree;
use halfway::scene::Scene;
use halfway::scene::builtin::builtin;

use crate::frozen_paths::{
    Bench, Frozen, HIT_SCALE, LIGHT_PATHS, VERTICES, assert_same_weights, find_paths, forms,
    plain_density_scale,
};
use crate::frozen_paths_subspaces::{dark_glass, open_paths, retain};
use crate::gpu;
use crate::random::Stream;
use crate::reference::path_space::weights;

/// Light paths that connections are drawn from, and the mean number of their vertices.
const M: u32 = 50;
const VERTICES_A_PATH: f32 = 2.5;

/// c over the scale of the eye vertex, by the definition.
fn density(arriving: f64, inv_q: &[f64]) -> f64 {
    let there: Vec<f64> = inv_q.iter().copied().filter(|&inv_q| inv_q > 0.0).collect();
    let even = 1.0 / f64::from(VERTICES_A_PATH);
    let x = match there.len() {
        0 => even,
        count => {
            let sum: f64 = there.iter().map(|inv_q| (arriving * inv_q).min(1000.0)).sum();
            0.75 * sum / count as f64 + 0.25 * even
        }
    };
    let m = f64::from(M);
    m * x / (m - 1.0 + x)
}

/// With so many records, of which some know nothing.
#[track_caller]
fn assert_partition(scene: &Scene, records: usize, samples: u32, may_differ: f64) {
    let context = gpu::context();
    let mut bench = Bench::new(scene);
    let mut paths = find_paths(scene, samples);
    let mut frozen: Vec<Frozen> = paths.iter().map(|path| bench.freeze(path)).collect();
    // Positions first, to put records near.
    let mut found = bench.kernel_finds(&frozen, 0.0, forms(scene)[0], None);
    let keep = open_paths(&bench, &paths, &frozen, &found);
    retain(&mut paths, &keep);
    retain(&mut frozen, &keep);
    retain(&mut found, &keep);
    let mut random = Stream::new(9);
    let mut position = || {
        let path = random.word() as usize % paths.len();
        let vertex = random.word() as usize % (paths[path].edges() - 1).max(1);
        let near = Vec4::from(found[path].points[vertex][0]).truncate();
        (near + 0.05 * glam::Vec3::new(random.f32(), random.f32(), random.f32())).to_array()
    };
    let positions: Vec<[f32; 3]> = (0..records).map(|_| position()).collect();
    let (tree, _) = KdTree::build(&positions);
    let mut record = |&position: &[f32; 3]| {
        let inv_q = if random.f32() < 0.1 { 0.0 } else { 1e4f32.powf(random.f32() - 0.3) };
        Record { position, inv_q, ..Record::default() }
    };
    let list: Vec<Record> = tree.points().iter().map(&mut record).collect();
    let padded: Vec<Record> = list.iter().copied().chain([Record::default()]).collect();
    bench.device.buffers.upload(context, "records", &padded).expect("upload");
    let links = (paths.len() * VERTICES * size_of::<EyeLink>()) as u64;
    bench.device.buffers.create(context, "eye_links", links).expect("create");
    bench.batch = Batch {
        light_path_count: M,
        records: records as u32,
        vertices_per_path: VERTICES_A_PATH,
        ..Batch::default()
    };
    for (form, light_paths) in forms(scene).iter().flat_map(|form| [(form, 0.0), (form, LIGHT_PATHS)]) {
        bench.device.buffers.create(context, "eye_link_count", 4).expect("create");
        let form: Vec<Feature> = form.iter().copied().chain([Feature::Resampling]).collect();
        let found = bench.kernel_finds(&frozen, light_paths, &form, None);
        let expected = |at: usize| {
            let path = &paths[at];
            let (ln_light, densities) = (bench.space.ln_light(path), bench.space.densities(path));
            let density = |i: usize| {
                // In the kernels' units: radiance is a power of two of the scene's.
                let mut ln_r = ln_light[i] - densities.ln_light[i + 1..].iter().sum::<f64>();
                ln_r -= f64::from(bench.device.radiance_exponent) * std::f64::consts::LN_2;
                let position = DVec3::from(Vec4::from(found[at].points[i - 1][0]).truncate());
                let nearest = tree.nearest(position.as_vec3().to_array());
                let inv_q: Vec<f64> =
                    nearest.iter().map(|&(place, _)| f64::from(list[place as usize].inv_q)).collect();
                let scale = f64::from(plain_density_scale(i, light_paths)) * bench.thinning(path, i);
                scale * density(ln_r.exp(), &inv_q)
            };
            weights(&densities.strategies(density, f64::from(HIT_SCALE), f64::from(light_paths)))
        };
        let name = format!("{} {form:?}, {records} records, {light_paths} light paths", scene.name);
        assert_same_weights(&name, &paths, &found, expected, may_differ);
    }
}

/// A lamp, a sky, a point, a spot, a sun.
#[test]
fn c06_records_three_lights() {
    let scene = builtin("three-lights").expect("a built-in scene");
    assert_partition(&scene, 60, 8, 2e-3);
}

/// Fewer records than three, and none.
#[test]
fn c06_records_that_are_few() {
    let scene = builtin("door").expect("a built-in scene");
    for records in [0, 2] {
        assert_partition(&scene, records, 8, 2e-3);
    }
}

/// Smooth and rough glass that absorbs.
#[test]
fn c06_records_dark_glass() {
    assert_partition(&dark_glass(), 60, 8, 2e-3);
}
