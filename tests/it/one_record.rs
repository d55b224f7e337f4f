//! Connections drawn by one record at a time, as Nabata's form of the weights of `risbpt` wants them.

use bytemuck::cast_slice;
use halfway::device::Feature;
use halfway::device::layout::{Batch, Record};
use halfway::math::rng::{RandomKey, uniform4};

use crate::records::{batch_of_draws, run};
use crate::stats::Moments;

const RECORDS: u32 = 5;
const VERTICES: u32 = 12;
const DRAWN: u32 = 1 << 19;
const CHOICES: usize = 4;

const DRAWS: &str = "
#import lib/select_one_record

@group(0) @binding(0) var<storage, read_write> drawn: array<vec4u>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < batch.pixel_count {
        // A kind of eye vertex for every so many-th.
        let kind = id.x % 4u;
        let selection = select_light_vertex(kind, id.x, 0u, 0u, 0u);
        let densities = choice_densities(selection.light, eye_records[kind].xyz);
        let share = densities[selection.choice] / sum_of(densities);
        drawn[id.x] =
            vec4u(selection.vertex, selection.choice, bitcast<u32>(selection.inv_density), bitcast<u32>(share));
    }
}
";

/// Whatever tables records have, whatever Q they are told, and whichever are near: every vertex of the cache is drawn by each
/// choice as often as that says, and the choices that may draw it share its light, so that the mean does not move (C-09).
/// Among them a record that sees nothing, one that sees a single vertex, one that Q is not known of, and eye vertices that
/// have fewer than three records, or none; many light paths, and one.
#[test]
fn c09_draws_by_one_random_record_are_as_often_as_they_say() {
    let random = |record: u32, vertex: u32| uniform4(RandomKey { pixel: vertex, sample: record, seed: 8 }, 0);
    let weight = |record: u32, vertex: u32| match record {
        0 => 0.0,
        1 => f32::from(u8::from(vertex == 5)),
        2 => 0.05 + random(record, vertex).x.powi(4),
        _ if random(record, vertex).y < 0.3 => 0.0,
        _ => 0.05 + random(record, vertex).x,
    };
    let weights: Vec<f32> =
        (0..RECORDS).flat_map(|record| (0..VERTICES).map(move |vertex| weight(record, vertex))).collect();
    let ends: Vec<u32> = weights
        .chunks(VERTICES as usize)
        .flat_map(|row| {
            row.iter().scan(0, |sum, &weight| {
                *sum += (weight * 2f32.powi(27)) as u32 + u32::from(weight > 0.0);
                Some(*sum)
            })
        })
        .collect();
    // Q is anything; of the last record it is not known.
    let record = |index: u32| Record {
        inv_q: if index == 4 { 0.0 } else { 10f32.powf(4.0 * random(index, 99).z - 1.0) },
        ..Record::default()
    };
    let records: Vec<Record> = (0..RECORDS).map(record).collect();
    let none = u32::MAX;
    let near = [[2u32, 3, 1, 0], [0, 2, none, 0], [4, 3, none, 0], [none, none, none, 0]];
    // In another order than the cache's.
    let order: Vec<u32> = (0..VERTICES).map(|place| (5 * place + 3) % VERTICES).collect();
    for light_paths in [2u32, 1] {
        let offsets = if light_paths == 2 { vec![0, 1, VERTICES] } else { vec![0, VERTICES] };
        let inputs = [
            ("light_path_offsets", cast_slice(&offsets)),
            ("light_order", cast_slice(&order)),
            ("record_ends", cast_slice(&ends)),
            ("record_weights", cast_slice(&weights)),
            ("records", cast_slice(&records)),
            ("eye_records", cast_slice(&near)),
        ];
        let batch = Batch {
            records: RECORDS,
            light_path_count: light_paths,
            vertices_per_path: 2.5,
            ..batch_of_draws(DRAWN)
        };
        let features = [Feature::Records, Feature::AtRecords];
        let words = run(DRAWS, &features, batch, &inputs, ("drawn", 4 * DRAWN as usize), DRAWN / 64);
        let mut judged = 0;
        for (kind, near) in near.iter().enumerate() {
            let mut by_choice = [[Moments::default(); CHOICES]; VERTICES as usize];
            let mut shared = [Moments::default(); VERTICES as usize];
            for &[vertex, choice, inv_density, share] in words.as_chunks::<4>().0.iter().skip(kind).step_by(4)
            {
                let value = f64::from(f32::from_bits(inv_density)) * f64::from(light_paths);
                let share = f64::from(f32::from_bits(share));
                for at in 0..VERTICES {
                    let value = if at == vertex { value } else { 0.0 };
                    for (number, moments) in by_choice[at as usize].iter_mut().enumerate() {
                        moments.push(if number as u32 == choice { value } else { 0.0 });
                    }
                    shared[at as usize].push(value * share);
                }
            }
            let name = format!("{light_paths} light paths, eye vertex {kind}");
            for place in 0..VERTICES {
                let vertex = order[place as usize] as usize;
                for choice in 0..CHOICES {
                    let can_draw = choice == 3
                        || near[choice] != none
                            && records[near[choice] as usize].inv_q > 0.0
                            && weights[(near[choice] * VERTICES + place) as usize] > 0.0;
                    let what = format!("{name}, light vertex {vertex}, choice {choice}");
                    let found = &by_choice[vertex][choice];
                    if !can_draw {
                        assert_eq!(found.mean, 0.0, "{what}");
                    } else if found.standard_error() < 0.3 && found.mean > 0.0 {
                        // Others are hardly ever drawn.
                        found.assert_mean(&what, 1.0, 0.3);
                        judged += 1;
                    }
                }
                shared[vertex].assert_mean(&format!("{name}, light vertex {vertex}"), 1.0, 0.1);
            }
        }
        println!("{judged} pairs of a choice and a light vertex");
        assert!(judged >= 60, "{judged} pairs only");
    }
}
