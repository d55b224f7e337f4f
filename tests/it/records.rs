//! Connections by records (`pcbpt`): tables and the search for the nearest ones by themselves, then the estimator
//! (C-05, C-08, N-19), and what records may lack.

use bytemuck::cast_slice;
use glam::{DVec3, Vec3};
use halfway::device::layout::{Batch, Record};
use halfway::device::shader::stitch_text;
use halfway::device::{BufferTable, Feature, Kernel};
use halfway::integrator::{Connections, Method, PcBpt, RecordWeights, RisBpt, View};
use halfway::math::kd_tree::KdTree;
use halfway::math::rng::{RandomKey, uniform4};
use halfway::render::{RenderOptions, Renderer};
use halfway::scene::builtin::shapes;
use halfway::scene::{Material, Scene};

use crate::bidirectional::{assert_same_as_path, assert_strategies_alone_are_right, shown};
use crate::gpu;
use crate::judge::{grey, horizontal, lamp, scene};
use crate::shots::{options, render};

/// Few light paths and many records, so that tables are what pictures are made by.
fn settings(light_paths: u32, record_share: f64, light_tracing: bool) -> PcBpt {
    let connections = Connections::even(2);
    PcBpt { light_paths: Some(light_paths), connections, light_tracing, record_share }
}

fn pcbpt(light_paths: u32, record_share: f64, light_tracing: bool) -> Method {
    Method::PcBpt(settings(light_paths, record_share, light_tracing))
}

fn simple(light_paths: u32, record_share: f64, light_tracing: bool) -> Method {
    let records = settings(light_paths, record_share, light_tracing);
    Method::RisBpt(RisBpt { records, weights: RecordWeights::Simple })
}

fn nabata(light_paths: u32, record_share: f64, light_tracing: bool) -> Method {
    let records = settings(light_paths, record_share, light_tracing);
    Method::RisBpt(RisBpt { records, weights: RecordWeights::Nabata })
}

/// So many pixels in a row, of one sample, whose vertices have a connection each.
pub fn batch_of_draws(pixels: u32) -> Batch {
    Batch {
        connections: [1; 3],
        width: pixels,
        height: 1,
        crop_width: pixels,
        crop_height: 1,
        crop_stride: 1,
        pixel_count: pixels,
        sample_count: 1,
        ..Batch::default()
    }
}

/// Runs a text as a kernel in so many workgroups, and reads a buffer of words.
pub fn run(
    text: &str,
    features: &[Feature],
    batch: Batch,
    inputs: &[(&str, &[u8])],
    (output, words): (&str, usize),
    workgroups: u32,
) -> Vec<u32> {
    let context = gpu::context();
    let stitched = stitch_text("test kernel", text, features.iter().copied().collect()).expect("directives");
    let kernel = Kernel::from_stitched(context, "test kernel", &stitched, &[]).expect("a valid kernel");
    let mut buffers = BufferTable::default();
    buffers.upload_uniform(context, "batch", &[batch]).expect("upload");
    inputs.iter().for_each(|(name, bytes)| buffers.upload(context, name, bytes).expect("upload"));
    buffers.create(context, output, words as u64 * 4).expect("create");
    let bound = kernel.bind(context, &buffers).expect("all buffers named");
    let mut encoder = context.device.create_command_encoder(&Default::default());
    bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), workgroups * kernel.workgroup());
    context.queue.submit([encoder.finish()]);
    buffers.read_elements(context, output, words as u32).expect("read")
}

fn points(count: u32, sample: u32) -> Vec<[f32; 3]> {
    let point = |pixel| uniform4(RandomKey { pixel, sample, seed: 3 }, 0).truncate().to_array();
    (0..count).map(point).collect()
}

const NEAREST: &str = "
#import lib/nearest_records

@group(0) @binding(0) var<storage, read> queries: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> found: array<vec4u>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&queries) {
        found[id.x] = vec4u(nearest_records(queries[id.x].xyz), 0u);
    }
}
";

/// Any number of records, none and one among them.
#[test]
fn c15_the_nearest_records_are_those_of_the_host() {
    let queries: Vec<[f32; 4]> = points(256, 1).into_iter().map(|[x, y, z]| [x, y, z, 0.0]).collect();
    for count in [0, 1, 2, 3, 7, 200] {
        let (tree, _) = KdTree::build(&points(count, 0));
        let record = |&position: &[f32; 3]| Record { position, ..Record::default() };
        let mut records: Vec<Record> = tree.points().iter().map(record).collect();
        // What is behind them is left alone.
        records.push(Record { position: queries[0][..3].try_into().expect("three"), ..Record::default() });
        let inputs = [("queries", cast_slice(&queries)), ("records", cast_slice(&records))];
        let batch = Batch { records: count, ..Batch::default() };
        let found = run(NEAREST, &[], batch, &inputs, ("found", 4 * queries.len()), 4);
        for (query, found) in queries.iter().zip(found.as_chunks::<4>().0) {
            let mut expected = [u32::MAX; 3];
            let nearest = tree.nearest([query[0], query[1], query[2]]);
            expected.iter_mut().zip(&nearest).for_each(|(slot, &(place, _))| *slot = place);
            assert_eq!(found[..3], expected, "{count} records");
        }
    }
}

/// Tables have the weights' shares, whatever their range, and nothing of records that no light reaches or too much.
#[test]
fn n14_tables_of_records_are_exact() {
    const RECORDS: u32 = 7;
    let forms =
        [(1u32, &[][..]), (300, &[]), (300, &[Feature::Software]), (1000, &[]), (300, &[Feature::AtRecords])];
    for (vertices, lanes) in forms {
        let weight = |index: u32| {
            let u = uniform4(RandomKey { pixel: index, sample: vertices, seed: 4 }, 0);
            match index / vertices {
                0 => 0.0,
                1 => u.x,
                // Many decades, and zeros.
                2 if u.y < 0.3 => 0.0,
                2 => 10f32.powf(-20.0 * u.x),
                3 => 1e-30 * u.x,
                4 => 1e30 * u.x,
                5 => {
                    if index % vertices == vertices / 2 {
                        5.0
                    } else {
                        0.0
                    }
                }
                _ => 3e38,
            }
        };
        let weights: Vec<f32> = (0..RECORDS * vertices).map(weight).collect();
        let offsets = [0, vertices];
        let sums = [0u32; RECORDS as usize];
        let inputs = [
            ("light_path_offsets", cast_slice(&offsets)),
            ("record_weights", cast_slice(&weights)),
            ("record_sums", cast_slice(&sums)),
        ];
        let batch = Batch { records: RECORDS, light_path_count: 1, ..Batch::default() };
        // Another workgroup than there are records.
        let size = weights.len();
        let kernel = include_str!("../../shaders/record_tables.wgsl");
        let ends = run(kernel, lanes, batch, &inputs, ("record_ends", size), RECORDS + 1);
        let rows = weights.chunks(vertices as usize).zip(ends.chunks(vertices as usize));
        for (record, (weights, ends)) in rows.enumerate() {
            assert!(ends.is_sorted(), "record {record} of {vertices}");
            let all = f64::from(ends[ends.len() - 1]);
            let total: f64 = weights.iter().map(|&weight| f64::from(weight)).sum();
            if total == 0.0 || total > f64::from(f32::MAX) {
                assert_eq!(all, 0.0, "record {record} of {vertices}");
                continue;
            }
            assert!((0.99..=1.001).contains(&(all / 2f64.powi(31))), "record {record} of {vertices}: {all}");
            let mut before = 0;
            for (&weight, &end) in weights.iter().zip(ends) {
                let [found, expected] = [f64::from(end - before) / all, f64::from(weight) / total];
                if lanes == [Feature::AtRecords] {
                    assert!(weight == 0.0 || end > before, "weights count what is never drawn");
                }
                assert!(
                    (found - expected).abs() <= 1e-5 * expected + 2f64.powi(-30),
                    "{found} is not {expected}"
                );
                before = end;
            }
        }
    }
}

const DRAWS: &str = "
#import lib/select_records

@group(0) @binding(0) var<storage, read_write> drawn: array<vec2u>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < batch.pixel_count {
        // A kind of eye vertex for every so many-th.
        let selection = select_light_vertex(id.x % 4u, id.x, 0u, 0u, 0u);
        drawn[id.x] = vec2u(selection.vertex, bitcast<u32>(selection.inv_density));
    }
}
";

/// Whatever tables records have, and whichever records are near: every vertex of the cache is drawn as often as it says,
/// so that the mean does not move (C-09). Among them a record that sees nothing, one that sees a single vertex, and eye
/// vertices that have fewer than three records, or none.
#[test]
fn c09_draws_by_random_records_are_as_often_as_they_say() {
    const RECORDS: u32 = 4;
    const VERTICES: u32 = 12;
    const DRAWN: u32 = 1 << 19;
    let unit = |record: u32, vertex: u32| {
        let random = uniform4(RandomKey { pixel: vertex, sample: record, seed: 8 }, 0);
        match record {
            0 => 0,
            1 => u32::from(vertex == 5) << 30,
            2 => (random.x.powi(8) * 2f32.powi(27)) as u32,
            _ => (random.x * 2f32.powi(27)) as u32,
        }
    };
    let running = |record: u32| {
        (0..VERTICES).scan(0, move |sum, vertex| {
            *sum += unit(record, vertex);
            Some(*sum)
        })
    };
    let ends: Vec<u32> = (0..RECORDS).flat_map(running).collect();
    let none = u32::MAX;
    let near = [[2u32, 3, 1, 0], [0, 2, none, 0], [0, none, none, 0], [none, none, none, 0]];
    // In another order than the cache's.
    let order: Vec<u32> = (0..VERTICES).map(|place| (5 * place + 3) % VERTICES).collect();
    let offsets = [0, 1, VERTICES];
    let inputs = [
        ("light_path_offsets", cast_slice(&offsets)),
        ("light_order", cast_slice(&order)),
        ("record_ends", cast_slice(&ends)),
        ("eye_records", cast_slice(&near)),
    ];
    let batch = Batch { records: RECORDS, light_path_count: 2, ..batch_of_draws(DRAWN) };
    let words = run(DRAWS, &[Feature::Records], batch, &inputs, ("drawn", 2 * DRAWN as usize), DRAWN / 64);
    let draws = f64::from(DRAWN / 4);
    for kind in 0..near.len() {
        let mut sums = [[0.0f64; 2]; VERTICES as usize];
        for &[vertex, inv_density] in words.as_chunks::<2>().0.iter().skip(kind).step_by(4) {
            // Of two light paths.
            let value = f64::from(f32::from_bits(inv_density)) * 2.0;
            sums[vertex as usize][0] += value;
            sums[vertex as usize][1] += value * value;
        }
        for (vertex, [sum, squares]) in sums.iter().enumerate() {
            let mean = sum / draws;
            let error = ((squares / draws - mean * mean) / draws).sqrt();
            let z = (mean - 1.0) / error;
            assert!(
                error < 0.1 && z.abs() < 5.0,
                "eye vertex {kind}, light vertex {vertex}: {mean} +- {error}"
            );
        }
    }
}

/// Every strategy alone, where connections go by tables (C-05).
#[test]
fn c05_every_strategy_by_records_alone_is_right() {
    assert_strategies_alone_are_right(pcbpt(1600, 0.001, true), 3, 12);
}

/// The same where each connection is drawn by one record (C-05).
#[test]
fn c05_every_strategy_by_one_record_alone_is_right() {
    assert_strategies_alone_are_right(nabata(1600, 0.001, true), 3, 12);
}

/// Lambert's law alone and everything else; area lights, punctual ones and a sky; mirrors and glass (C-08).
#[test]
fn c08_pcbpt_agrees_with_path() {
    assert_same_as_path(&shown("cornell"), pcbpt(50, 0.004, false), 4);
    assert_same_as_path(&shown("three-lights"), pcbpt(50, 0.004, true), 4);
}

/// A light path alone, records in many pixels, or one in all (C-08).
#[test]
fn c08_pcbpt_agrees_with_path_at_the_ends_of_its_settings() {
    for (light_paths, share) in [(1, 0.05), (5, 0.25), (20, 1e-6)] {
        assert_same_as_path(&shown("cornell"), pcbpt(light_paths, share, false), 8);
    }
}

/// As `pcbpt`, with all that records may lack (C-08).
#[test]
fn c08_risbpt_agrees_with_path_where_records_see_nothing() {
    for risbpt in [nabata, simple] {
        assert_same_as_path(&mirrors(), risbpt(20, 0.05, false), 4);
        assert_same_as_path(&shaded(), risbpt(20, 1e-6, false), 8);
    }
}

/// Records that see no light, where others do: the camera sees a room through whose door no light comes but by a wall; and
/// records that there are none of, since all is mirrors (C-08).
#[test]
fn c08_pcbpt_agrees_with_path_where_records_see_nothing() {
    assert_same_as_path(&mirrors(), pcbpt(20, 0.05, false), 4);
    assert_same_as_path(&shaded(), pcbpt(20, 1e-6, false), 8);
}

fn above(mut scene: Scene, name: &str) -> Scene {
    scene.name = name.into();
    scene.cameras.push(shapes::looking_at("above", DVec3::new(0.0, 0.9, 1.4), DVec3::ZERO, 50.0));
    scene
}

fn mirrors() -> Scene {
    let mirror = Material { metallic: 1.0, roughness: 0.0, ..grey(0.9) };
    above(scene([(mirror, horizontal(2.0, 0.0, true)), (lamp(1.0), horizontal(2.0, 2.0, false))]), "mirrors")
}

/// A lamp that shines up, on a ceiling; what it lights is seen by the ceiling alone.
fn shaded() -> Scene {
    above(
        scene([
            (grey(0.6), horizontal(2.0, 0.0, true)),
            (lamp(3.0), horizontal(0.7, 0.6, true)),
            (grey(0.7), horizontal(2.0, 1.2, false)),
        ]),
        "lamp that shines up",
    )
}

/// Whatever records tell weights: few light paths, one record, records of every pixel (C-08, C-09).
#[test]
fn c08_risbpt_agrees_with_path() {
    for risbpt in [nabata, simple] {
        assert_same_as_path(&shown("cornell"), risbpt(50, 0.004, false), 4);
        assert_same_as_path(&shown("cornell"), risbpt(1, 1e-6, false), 8);
        assert_same_as_path(&shown("spheres"), risbpt(50, 0.004, true), 4);
    }
}

/// Lights of every kind, and records of every pixel (C-08).
#[test]
fn c08_risbpt_of_nabata_agrees_with_path() {
    assert_same_as_path(&shown("three-lights"), nabata(50, 0.004, false), 4);
    assert_same_as_path(&shown("cornell"), nabata(5, 0.25, false), 8);
}

/// The same seed makes the same picture, in parts too, and other records do not (N-19).
#[test]
fn n19_pictures_by_records_repeat() {
    assert_repeats(pcbpt);
    assert_repeats(simple);
    assert_repeats(nabata);
}

fn assert_repeats(method: fn(u32, f64, bool) -> Method) {
    let scene = shown("three-lights");
    let of = |view: View, share: f64| {
        let base = options([40, 30], 4);
        render(&scene, RenderOptions { view, method: method(60, share, true), ..base }).picture.rgb
    };
    let view = options([40, 30], 4).view;
    let whole = of(view, 0.01);
    assert_eq!(of(view, 0.01), whole);
    assert_ne!(of(view, 0.04), whole);
    let region = halfway::film::Region::new(7, 11, 13, 9);
    let crop = of(View { crop: Some(region), ..view }, 0.01);
    for (index, rgb) in crop.iter().enumerate() {
        let (column, row) = (7 + index % 13, 11 + index / 13);
        assert_eq!(*rgb, whole[row * 40 + column], "{column}, {row}");
    }
}

/// Without lights there is nothing to connect to, and no records.
#[test]
fn pcbpt_of_the_dark_is_dark() {
    let mut dark = scene([(grey(0.5), horizontal(2.0, 0.0, true))]);
    dark.cameras.push(shapes::looking_at("above", DVec3::Y, DVec3::ZERO, 50.0));
    let shot = render(&dark, RenderOptions { method: pcbpt(20, 0.05, true), ..options([8, 8], 2) });
    assert!(shot.picture.rgb.iter().all(|rgb| Vec3::from(*rgb) == Vec3::ZERO));
    assert_eq!(shot.report.rays.records, 0);
}

/// What would not fit is refused before the first sample, with what to change; what does fit says its size.
#[test]
fn tables_of_records_are_told_and_refused() {
    let make = |method| {
        let options = RenderOptions { method, ..options([128, 128], 2) };
        Renderer::new(gpu::context(), &shown("cornell"), options)
    };
    let Err(error) = make(pcbpt(400_000, 1.0, false)) else { panic!("there is room for everything") };
    for phrase in ["records", "--record-share", "--light-paths"] {
        assert!(error.to_string().contains(phrase), "{error}");
    }
    for (method, has_weights) in [(pcbpt(200, 0.004, false), false), (nabata(200, 0.004, false), true)] {
        let renderer = make(method).expect("a renderer");
        let choices = renderer.report().expect("a report").choices;
        let choice = choices.iter().find(|choice| choice.what == "records").expect("a line on records");
        assert!(choice.reason.contains("shadow rays a sample"), "{choice:?}");
        assert_eq!(choice.reason.contains("weights take"), has_weights, "{choice:?}");
    }
}
