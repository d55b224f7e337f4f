#import bind/batch
#import bind/light_cache
#import lib/scan

// After the last batch of light paths, where each path's vertices begin in the cache's order: the sums of the numbers of
// vertices before. One workgroup; each invocation sums a run of paths.

@compute @workgroup_size(SCAN_THREADS)
fn main(@builtin(local_invocation_index) thread: u32) {
    let paths = batch.first_light_path + batch.pixel_count * batch.sample_count;
    let run = (paths + SCAN_THREADS - 1u) / SCAN_THREADS;
    let first = min(thread * run, paths);
    let end = min(first + run, paths);
    var sum = 0u;
    for (var path = first; path < end; path++) {
        sum += light_path_lengths[path];
    }
    let through = workgroup_scan(thread, sum);
    var offset = through - sum;
    for (var path = first; path < end; path++) {
        light_path_offsets[path] = offset;
        offset += light_path_lengths[path];
    }
    if thread == SCAN_THREADS - 1u {
        light_path_offsets[paths] = through;
    }
}
