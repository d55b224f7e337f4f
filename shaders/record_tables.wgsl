#import bind/batch
#import bind/light_cache
#import bind/records
#import lib/color
#import lib/workgroup_sum

// Each record's table: running sums in whole units, so that probabilities are known exactly. One workgroup per record.

/// Units of a table, at most: rounding may add some 2^-18 of them to a running sum.
const TABLE_UNITS: f32 = 0x1p+31;
/// Sums by blocks: the error of a plain sum grows with the number of vertices.
const BLOCK: u32 = 64u;

/// Whole units of a table of so many.
fn units_of(weight: f32, total: f32, units: f32) -> u32 {
    let share = u32(weight / total * units);
#if at_records
    // What weights count has to be drawn.
    return max(share, select(0u, 1u, weight > 0.0 && units > 0.0));
#else
    return share;
#endif
}

@compute @workgroup_size(SCAN_THREADS)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let record = group.x + group.y * 65535u;
    if record >= batch.records {
        return;
    }
    let vertices = light_path_offsets[batch.light_path_count];
    let part = (vertices + SCAN_THREADS - 1u) / SCAN_THREADS;
    let first = record * vertices + min(thread * part, vertices);
    let end = record * vertices + min((thread + 1u) * part, vertices);
    var weight = 0.0;
    for (var block = first; block < end; block += BLOCK) {
        var sum = 0.0;
        for (var i = block; i < min(block + BLOCK, end); i++) {
            sum += record_weights[i];
        }
        weight += sum;
    }
    let arriving = workgroup_sum(thread, weight);
    // Nothing arrives, or more than there are numbers: then the record draws nothing.
    let units = select(0.0, TABLE_UNITS, is_drawable(arriving));
    let total = select(1.0, arriving, is_drawable(arriving));
#if resampling
    if thread == 0u {
        record_sums[record] = select(0.0, arriving, is_drawable(arriving));
    }
#endif
    var sum = 0u;
    for (var i = first; i < end; i++) {
        sum += units_of(record_weights[i], total, units);
    }
    var running = workgroup_scan(thread, sum) - sum;
    for (var i = first; i < end; i++) {
        running += units_of(record_weights[i], total, units);
        record_ends[i] = running;
    }
}
