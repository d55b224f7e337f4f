#import lib/alias

// The light cache sorted by light subspace, with an alias table for each subspace that draws its vertices in proportion
// to |w|. Vertices without weight are left out.

/// Parts that the cache is cut into while it is sorted.
const RUNS: u32 = 256u;

/// For each light subspace and run: how many vertices; then where they begin; then, after sorting, where they end.
@group(3) @binding(10) var<storage, read_write> bucket_ends: array<u32>;
/// By subspace: index into the cache, and the vertex's units in the alias table; before there is one, |w| as bits.
@group(3) @binding(11) var<storage, read_write> bucket_items: array<vec2u>;
/// Threshold and alias (a place in `bucket_items`) of each slot: lib/alias.
@group(3) @binding(12) var<storage, read_write> bucket_tables: array<vec2u>;

/// First place of a light subspace, and the one after its last.
fn bucket_range(label: u32) -> vec2u {
    let first = select(bucket_ends[max(label, 1u) * RUNS - 1u], 0u, label == 0u);
    return vec2u(first, bucket_ends[label * RUNS + RUNS - 1u]);
}

/// First place of a run in a cache of `vertices`, and the one after its last.
fn run_range(run: u32, vertices: u32) -> vec2u {
    let length = (vertices + RUNS - 1u) / RUNS;
    return min(vec2u(run, run + 1u) * length, vec2u(vertices));
}

/// Place of a vertex of a range that is not empty, drawn with two random words.
fn draw_from_bucket(range: vec2u, words: vec2u) -> u32 {
    var draw = alias_draw(words, range.y - range.x);
    draw.slot += range.x;
    let entry = bucket_tables[draw.slot];
    return alias_pick(draw, entry.x, entry.y);
}

/// Each of a table's `n` slots holds 2^k units; their sum stays below 2^31.
fn slot_bits(n: u32) -> u32 {
    return countLeadingZeros(n) - 1u;
}
