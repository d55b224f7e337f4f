// Sums over a workgroup.

const SCAN_THREADS: u32 = 256u;

var<workgroup> scan_sums: array<u32, SCAN_THREADS>;

/// Sum of the values of all invocations up to this one, its own included. All SCAN_THREADS invocations of the workgroup
/// call it, once. Hillis and Steele, Data Parallel Algorithms, 1986.
fn workgroup_scan(thread: u32, value: u32) -> u32 {
    scan_sums[thread] = value;
    workgroupBarrier();
    for (var step = 1u; step < SCAN_THREADS; step *= 2u) {
        var before = 0u;
        if thread >= step {
            before = scan_sums[thread - step];
        }
        workgroupBarrier();
        scan_sums[thread] += before;
        workgroupBarrier();
    }
    return scan_sums[thread];
}
