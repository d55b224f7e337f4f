// Counts to numbers known beforehand; see src/device/probe.rs.
// The trips come from a buffer and each step depends on data, so that no compiler can count for the loop.

@group(0) @binding(0) var<storage, read> loop_trips: array<u32>;
@group(0) @binding(1) var<storage, read_write> loop_counts: array<u32>;

fn count(trips: u32) -> u32 {
    var state = trips;
    var steps = 0u;
    for (var i = 0u; i < trips; i++) {
        state = state * 747796405u + 2891336453u;
        steps += select(1u, 2u, state == 0u && i > trips);
    }
    return steps;
}

@compute @workgroup_size(1)
fn main() {
    loop_counts[0] = count(loop_trips[0]);
    loop_counts[1] = count(loop_trips[1]);
    var nested = 0u;
    for (var i = 0u; i < 300u; i++) {
        nested += count(loop_trips[2] / 300u);
    }
    loop_counts[2] = nested;
}
