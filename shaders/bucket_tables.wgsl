#import bind/bucket_sums
#import bind/buckets
#import lib/workgroup_sum

// The alias table of each light subspace, in whole units, so that probabilities are known exactly. One workgroup per
// subspace; each invocation makes a part of the slots. Slots that lack units are filled in their order by those that
// have some to spare, in theirs, so that running sums of both say which meets which, from any slot on: Hübschle-Schneider
// and Sanders, Parallel Weighted Random Sampling, ESA 2019.

/// Sums by blocks: the error of a plain sum grows with the number of vertices.
const BLOCK: u32 = 64u;

fn running_sum(place: u32, of_spares: bool) -> u32 {
    return select(bucket_sums[place].x, bucket_sums[place].y, of_spares);
}

/// First place where the running sum (of lacks or of spares) reaches `sum`; `range.y` where none does.
fn first_reaching(range: vec2u, of_spares: bool, sum: u32) -> u32 {
    var low = range.x;
    var high = range.y;
    while low < high {
        let middle = (low + high) / 2u;
        if running_sum(middle, of_spares) >= sum {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

/// The same from a place before it, in steps.
fn next_reaching(from_place: u32, end: u32, of_spares: bool, sum: u32) -> u32 {
    var place = from_place;
    while place < end && running_sum(place, of_spares) < sum {
        place++;
    }
    return place;
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
            sum += bitcast<f32>(bucket_items[place].y);
        }
        weight += sum;
    }
    let total = workgroup_sum(thread, weight);

    // A little less than there is, for the rounding of `total`, and one unit for every vertex, so that none is lost.
    let bits = slot_bits(n);
    let slot = 1u << bits;
    let table = n * slot;
    let shared_units = f32(table - (table >> 12u) - n);
    var units = 0u;
    for (var place = first; place < end; place++) {
        let own = u32(bitcast<f32>(bucket_items[place].y) / total * shared_units) + 1u;
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
    sums = before;
    for (var place = first; place < end; place++) {
        let own = bucket_items[place].y;
        sums += vec2u(max(slot, own) - own, max(slot, own) - slot);
        bucket_sums[place] = sums;
    }
    storageBarrier();

    // Which vertex gives to the slots of this part, and which is the first to lack after one of them has given all.
    var giver = first_reaching(range, true, max(before.x, 1u));
    var lacking = first_reaching(range, false, before.y + 1u);
    sums = before;
    for (var place = first; place < end; place++) {
        let own = bucket_items[place].y;
        // A full slot aliases to itself.
        var entry = vec2u(0u, place);
        if own < slot {
            giver = next_reaching(giver, range.y, true, max(sums.x, 1u));
            entry = vec2u(own, giver);
            sums.x += slot - own;
        } else if own > slot {
            sums.y += own - slot;
            lacking = next_reaching(lacking, range.y, false, sums.y + 1u);
            if lacking < range.y {
                // It lacks something itself now, and the next one that gives fills that.
                let kept = slot + sums.y - bucket_sums[lacking].x;
                entry = vec2u(kept, next_reaching(place + 1u, range.y, true, sums.y + 1u));
            }
        }
        bucket_tables[place] = vec2u(entry.x << (32u - bits), entry.y);
    }
}
