#import bind/bucket_sums
#import bind/buckets
#import bind/light_cache
#import bind/subspaces
#import lib/color
#import lib/scan

// Weights become whole units of alias tables, so that probabilities are known exactly, and the units are summed up. One
// workgroup a subspace.

/// Sums by blocks: the error of a plain sum grows with the number of vertices.
const BLOCK: u32 = 64u;

var<workgroup> weight_sums: array<f32, SCAN_THREADS>;

/// Sum of the values of all invocations of the workgroup.
fn workgroup_sum(thread: u32, value: f32) -> f32 {
    weight_sums[thread] = value;
    workgroupBarrier();
    for (var half = SCAN_THREADS / 2u; half > 0u; half /= 2u) {
        if thread < half {
            weight_sums[thread] += weight_sums[thread + half];
        }
        workgroupBarrier();
    }
    return weight_sums[0];
}

fn weight_at(place: u32) -> f32 {
    return magnitude(light_vertices[bucket_items[place].x].weight);
}

@compute @workgroup_size(SCAN_THREADS)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let range = bucket_range(group.x);
    let n = range.y - range.x;
    let part = (n + SCAN_THREADS - 1u) / SCAN_THREADS;
    let first = min(range.x + thread * part, range.y);
    let end = min(first + part, range.y);

    var weight = 0.0;
    for (var block = first; block < end; block += BLOCK) {
        var sum = 0.0;
        for (var place = block; place < min(block + BLOCK, end); place++) {
            sum += weight_at(place);
        }
        weight += sum;
    }
    let total = workgroup_sum(thread, weight);

    // A little less than there is, for the rounding of `total`, and one unit for every vertex, so that none is lost.
    let slot = 1u << slot_bits(n);
    let table = n * slot;
    let shared_units = f32(table - (table >> 12u) - n);
    var units = 0u;
    for (var place = first; place < end; place++) {
        let own = u32(weight_at(place) / total * shared_units) + 1u;
        bucket_items[place].y = own;
        units += own;
    }
    workgroup_scan(thread, units);
    let left = table - workgroup_total();

    // What is left goes to all alike.
    var sums = vec2u(0u);
    for (var place = first; place < end; place++) {
        let own = bucket_items[place].y + left / n + select(0u, 1u, place - range.x < left % n);
        bucket_items[place].y = own;
        sums += vec2u(max(slot, own) - own, max(slot, own) - slot);
    }
    var before = vec2u(workgroup_scan(thread, sums.x), 0u);
    before.y = workgroup_scan(thread, sums.y);
    before -= sums;
    for (var place = first; place < end; place++) {
        let own = bucket_items[place].y;
        before += vec2u(max(slot, own) - own, max(slot, own) - slot);
        bucket_sums[place] = before;
    }
}
