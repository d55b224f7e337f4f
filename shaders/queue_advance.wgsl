#import bind/arguments
#import bind/queue

// Between two bounces: the paths that were written become those that are read.

@compute @workgroup_size(1)
fn main() {
    let paths = atomicExchange(&counts.paths_out, 0u);
    counts.paths_in = paths;
    counts.connection_round = 0u;
    counts.closest_total = add(counts.closest_total, paths);
    arguments[ARGUMENTS_PATHS] = workgroups(paths);
    for (var slot = 0u; slot < CONNECTIONS_IN_FLIGHT; slot++) {
        arguments[ARGUMENTS_CONNECTIONS + slot] = workgroups(paths * (slot + 1u));
    }
}
