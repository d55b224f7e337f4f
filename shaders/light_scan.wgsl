#import bind/batch
#import bind/light_cache

// After the last batch of light paths: where each path's vertices begin in the cache's order: sums of the numbers of vertices before. One
// workgroup; each invocation sums a run of paths.

const THREADS: u32 = 256u;

var<workgroup> sums: array<u32, THREADS>;

@compute @workgroup_size(THREADS)
fn main(@builtin(local_invocation_index) thread: u32) {
    let paths = batch.first_light_path + batch.pixel_count * batch.sample_count;
    let run = (paths + THREADS - 1u) / THREADS;
    let first = min(thread * run, paths);
    let end = min(first + run, paths);
    var sum = 0u;
    for (var path = first; path < end; path++) {
        sum += light_path_lengths[path];
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
    for (var path = first; path < end; path++) {
        light_path_offsets[path] = offset;
        offset += light_path_lengths[path];
    }
    if thread == THREADS - 1u {
        light_path_offsets[paths] = sums[thread];
    }
}
