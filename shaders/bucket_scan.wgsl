#import bind/batch
#import bind/buckets
#import lib/scan

// Where the vertices of each run begin in the order by subspace: sums of all counts before. One workgroup.

@compute @workgroup_size(SCAN_THREADS)
fn main(@builtin(local_invocation_index) thread: u32) {
    let cells = batch.subspaces * RUNS;
    let part = (cells + SCAN_THREADS - 1u) / SCAN_THREADS;
    let first = min(thread * part, cells);
    let end = min(first + part, cells);
    var sum = 0u;
    for (var cell = first; cell < end; cell++) {
        sum += bucket_ends[cell];
    }
    let through = workgroup_scan(thread, sum);
    var offset = through - sum;
    for (var cell = first; cell < end; cell++) {
        let count = bucket_ends[cell];
        bucket_ends[cell] = offset;
        offset += count;
    }
}
