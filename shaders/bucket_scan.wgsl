#import bind/buckets
#import bind/subspaces

// Where the vertices of each run begin in the order by subspace: sums of all counts before. One workgroup.

const THREADS: u32 = 256u;

var<workgroup> sums: array<u32, THREADS>;

@compute @workgroup_size(THREADS)
fn main(@builtin(local_invocation_index) thread: u32) {
    let cells = SUBSPACES * RUNS;
    let part = (cells + THREADS - 1u) / THREADS;
    let first = min(thread * part, cells);
    let end = min(first + part, cells);
    var sum = 0u;
    for (var cell = first; cell < end; cell++) {
        sum += bucket_ends[cell];
    }
    sums[thread] = sum;
    workgroupBarrier();
    // Hillis and Steele, Data Parallel Algorithms, 1986.
    for (var step = 1u; step < THREADS; step *= 2u) {
        var before = 0u;
        if thread >= step {
            before = sums[thread - step];
        }
        workgroupBarrier();
        sums[thread] += before;
        workgroupBarrier();
    }
    var offset = sums[thread] - sum;
    for (var cell = first; cell < end; cell++) {
        let count = bucket_ends[cell];
        bucket_ends[cell] = offset;
        offset += count;
    }
}
