#import lib/scan

var<workgroup> weight_sums: array<f32, SCAN_THREADS>;

/// Sum of the values of all invocations of the workgroup, which all call it.
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
