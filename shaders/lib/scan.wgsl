// Sums over a workgroup.

#if software
// A software device runs a workgroup's invocations one after the other, and changes between them at every barrier.
const SCAN_THREADS: u32 = 1u;
#else
const SCAN_THREADS: u32 = 256u;
#endif

var<workgroup> scan_sums: array<u32, SCAN_THREADS>;

/// Sum of the values of all invocations up to this one, its own included. All SCAN_THREADS invocations of the workgroup
/// call it. Hillis and Steele, Data Parallel Algorithms, 1986.
fn workgroup_scan(thread: u32, value: u32) -> u32 {
    // All have read the last sums.
    workgroupBarrier();
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

/// Sum of the values that all invocations had in the last scan.
fn workgroup_total() -> u32 {
    return scan_sums[SCAN_THREADS - 1u];
}
