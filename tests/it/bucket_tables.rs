//! The light cache sorted by subspace, and its alias tables (N-14, N-15): on the device, every light vertex is drawn as
//! often as the renderer believes.

use halfway::device::layout::{Batch, Counts, LightVertex};
use halfway::device::{BufferTable, Feature, Features, Kernel};

use crate::gpu;
use crate::random::Stream;
use crate::stats::{FAMILY_ALPHA, chi_square_p, sidak};

/// As in `shaders/bind/buckets.wgsl`.
const RUNS: usize = 256;
const SUBSPACES: usize = 9;

/// The sorted cache, and what it was made of.
struct Sorted {
    vertices: Vec<LightVertex>,
    order: Vec<u32>,
    ends: Vec<u32>,
    items: Vec<[u32; 2]>,
    tables: Vec<[u32; 2]>,
    counts: Counts,
}

impl Sorted {
    fn range(&self, label: usize) -> std::ops::Range<usize> {
        let end = |label: usize| self.ends[label * RUNS + RUNS - 1] as usize;
        (if label == 0 { 0 } else { end(label - 1) })..end(label)
    }

    fn magnitude(&self, place: usize) -> f64 {
        magnitude(&self.vertices[self.items[place][0] as usize])
    }
}

fn magnitude(vertex: &LightVertex) -> f64 {
    vertex.weight.iter().map(|&w| f64::from(w)).sum()
}

/// Weights that broke tables of floats, a family for each subspace; one subspace is empty, one has a single vertex, one
/// has most of all vertices, one has only black and faulty ones.
fn cache() -> Vec<LightVertex> {
    let mut random = Stream::new(15);
    let mut vertices = Vec::new();
    let mut push = |label: u32, weight: f32| {
        let weight = [weight, 0.5 * weight, 0.25 * weight];
        vertices.push(LightVertex { weight, number_label: label << 16, ..LightVertex::default() });
    };
    push(1, 3.0);
    (0..777).for_each(|_| push(2, 0.25));
    (0..1000).for_each(|_| push(3, 10f32.powf(20.0 * random.f32() - 10.0)));
    (0..500).for_each(|i| push(4, if i == 250 { 1e20 } else { 1e-10 }));
    (0..501).for_each(|_| push(5, if random.f32() < 0.3 { 0.0 } else { random.f32() + 1e-3 }));
    (0..60_000).for_each(|_| push(6, random.f32().powi(4)));
    [0.0, f32::NAN, 0.0, f32::INFINITY].into_iter().for_each(|weight| push(7, weight));
    (0..512).for_each(|i| push(8, (1 + i % 3) as f32));
    // In any order.
    for i in (1..vertices.len()).rev() {
        vertices.swap(i, (random.f64() * (i + 1) as f64) as usize);
    }
    vertices
}

fn sort(lanes: &[Feature]) -> Sorted {
    let context = gpu::context();
    let mut vertices = cache();
    let count = vertices.len();
    // One light path has them all, in another order than that of their slots.
    let order: Vec<u32> = (0..count).map(|i| ((i * 7919) % count) as u32).collect();
    for (number, &slot) in order.iter().enumerate() {
        vertices[slot as usize].number_label |= number as u32 & 0xffff;
    }
    let mut buffers = BufferTable::default();
    let batch = Batch { light_path_count: 1, subspaces: SUBSPACES as u32, ..Batch::default() };
    buffers.upload_uniform(context, "batch", &[batch]).expect("upload");
    buffers.upload(context, "light_vertices", &vertices).expect("upload");
    buffers.upload(context, "light_order", &order).expect("upload");
    buffers.upload(context, "light_path_offsets", &[0, count as u32]).expect("upload");
    buffers.create(context, "counts", size_of::<Counts>() as u64).expect("create");
    buffers.create(context, "bucket_ends", (SUBSPACES * RUNS * 4) as u64).expect("create");
    for name in ["bucket_items", "bucket_tables", "bucket_sums"] {
        buffers.create(context, name, count as u64 * 8).expect("create");
    }
    let features = Features::from([Feature::Subspaces, Feature::LightCache]).with(lanes);
    for name in ["bucket_counts", "bucket_scan", "bucket_order", "bucket_tables"] {
        let kernel = Kernel::new(context, name, features, &[]).expect("a kernel");
        let invocations = match name {
            "bucket_counts" | "bucket_order" => RUNS as u32,
            "bucket_scan" => 1,
            _ => SUBSPACES as u32 * kernel.workgroup(),
        };
        let bound = kernel.bind(context, &buffers).expect("all buffers");
        let mut encoder = context.device.create_command_encoder(&Default::default());
        bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), invocations);
        context.queue.submit([encoder.finish()]);
    }
    let read = |name: &str, bytes: usize| buffers.read(context, name, bytes as u64).expect("read");
    Sorted {
        ends: bytemuck::pod_collect_to_vec(&read("bucket_ends", SUBSPACES * RUNS * 4)),
        items: bytemuck::pod_collect_to_vec(&read("bucket_items", count * 8)),
        tables: bytemuck::pod_collect_to_vec(&read("bucket_tables", count * 8)),
        counts: bytemuck::pod_read_unaligned(&read("counts", size_of::<Counts>())),
        vertices,
        order,
    }
}

#[test]
fn n14_light_tables_are_exact() {
    for lanes in [&[Feature::Software][..], &[]] {
        let sorted = sort(lanes);
        assert_eq!(sorted.counts.non_finite_vertices, 2);
        for label in 0..SUBSPACES {
            let range = sorted.range(label);
            let label_of = |slot: u32| (sorted.vertices[slot as usize].number_label >> 16) as usize;
            let drawable = |slot: &&u32| {
                let weight = magnitude(&sorted.vertices[**slot as usize]);
                label_of(**slot) == label && weight > 0.0 && weight.is_finite()
            };
            let expected: Vec<u32> = sorted.order.iter().filter(drawable).copied().collect();
            let found: Vec<u32> = sorted.items[range.clone()].iter().map(|item| item[0]).collect();
            assert!(found == expected, "{lanes:?}, subspace {label}: other vertices, or in another order");
            if expected.is_empty() {
                continue;
            }
            // Read from the slots alone: the units that each vertex gets.
            let n = range.len();
            let bits = (n as u32).leading_zeros() - 1;
            let mut implied = vec![0u64; n];
            for place in range.clone() {
                let [threshold, alias] = sorted.tables[place];
                let own = u64::from(threshold >> (32 - bits));
                assert_eq!(u64::from(threshold), own << (32 - bits));
                implied[place - range.start] += own;
                implied[alias as usize - range.start] += (1 << bits) - own;
            }
            let units: Vec<u64> = sorted.items[range.clone()].iter().map(|item| u64::from(item[1])).collect();
            assert!(implied == units, "{lanes:?}, subspace {label}: drawn otherwise than reported");
            let table = (n as u64) << bits;
            assert_eq!(units.iter().sum::<u64>(), table, "{lanes:?}, subspace {label}");
            assert!(units.iter().all(|&units| units > 0), "{lanes:?}, subspace {label}: a vertex is lost");
            let total: f64 = range.clone().map(|place| sorted.magnitude(place)).sum();
            let distance: f64 = range
                .clone()
                .zip(&units)
                .map(|(place, &units)| (units as f64 / table as f64 - sorted.magnitude(place) / total).abs())
                .sum();
            // 2^-12 of all goes to all alike, and a unit to each.
            let limit = 2f64.powi(-11) + n as f64 / table as f64;
            assert!(distance <= limit, "{lanes:?}, subspace {label}: total variation {distance:e}");
        }
    }
}

/// Draws by the tables, and by the search in the running sums of the weights that they replace.
const DRAWS: &str = "
#import bind/buckets
#import lib/rng

@group(0) @binding(0) var<storage, read> sums: array<f32>;
@group(0) @binding(1) var<storage, read_write> by_table: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> by_search: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let range = bucket_range(LABEL);
    let n = range.y - range.x;
    for (var number = 0u; number < 96u; number++) {
        let words = random4(RandomKey(id.x, number, 77u), 5u);
        atomicAdd(&by_table[draw_from_bucket(range, words.xy) - range.x], 1u);
        let target_sum = uniform_from_word(words.z) * sums[n - 1u];
        var low = 0u;
        var high = n - 1u;
        while low < high {
            let middle = (low + high) / 2u;
            if sums[middle] > target_sum {
                high = middle;
            } else {
                low = middle + 1u;
            }
        }
        atomicAdd(&by_search[low], 1u);
    }
}
";

/// Fifty million draws, and as many by the oracle.
#[test]
fn n15_light_vertices_are_drawn_as_reported() {
    const INVOCATIONS: u32 = 1 << 19;
    let sorted = sort(&[]);
    let labels = [5, 8];
    let level = sidak(FAMILY_ALPHA, 2 * labels.len());
    for label in labels {
        let range = sorted.range(label);
        let n = range.len();
        let mut sum = 0.0;
        let sums: Vec<f32> = range
            .clone()
            .map(|place| {
                sum += sorted.magnitude(place);
                sum as f32
            })
            .collect();
        let bytes = |values: &[[u32; 2]]| bytemuck::cast_slice::<_, u8>(values).to_vec();
        let histograms = gpu::run(
            &DRAWS.replace("LABEL", &format!("{label}u")),
            &[],
            &[
                ("sums", bytemuck::cast_slice(&sums)),
                ("bucket_ends", bytemuck::cast_slice(&sorted.ends)),
                ("bucket_items", &bytes(&sorted.items)),
                ("bucket_tables", &bytes(&sorted.tables)),
            ],
            &[("by_table", n * 4), ("by_search", n * 4)],
            INVOCATIONS,
        );
        let draws = f64::from(INVOCATIONS) * 96.0;
        let table = (n as f64) * f64::from(1u32 << ((n as u32).leading_zeros() - 1));
        let reported = range.clone().map(|place| f64::from(sorted.items[place][1]) / table);
        let by_weight = range.clone().map(|place| sorted.magnitude(place) / sum);
        let expected: [Vec<f64>; 2] = [reported.collect(), by_weight.collect()];
        for ((bytes, expected), name) in histograms.iter().zip(&expected).zip(["table", "search"]) {
            let counts: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
            assert_eq!(counts.iter().map(|&count| f64::from(count)).sum::<f64>(), draws);
            let observed: Vec<u64> = counts.iter().map(|&count| u64::from(count)).collect();
            let expected: Vec<f64> = expected.iter().map(|p| p * draws).collect();
            let p = chi_square_p(&observed, &expected);
            assert!(p > level, "subspace {label} by {name}: p = {p:e} over {n} vertices");
        }
    }
}
