// The light cache sorted by light subspace, each subspace with the running sums of |w| over its vertices.

/// Parts that the cache is cut into while it is sorted.
const RUNS: u32 = 256u;

/// For each light subspace and run: how many vertices; then where they begin; then, after sorting, where they end.
@group(3) @binding(10) var<storage, read_write> bucket_ends: array<u32>;
/// Indices into the cache, by subspace.
@group(3) @binding(11) var<storage, read_write> bucket_order: array<u32>;
/// Sums of |w| from the subspace's first vertex on.
@group(3) @binding(12) var<storage, read_write> bucket_sums: array<f32>;

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
