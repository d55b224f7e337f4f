#import bind/arguments
#import bind/queue

// Between connecting and testing connections: those that were written become those that are read.

@compute @workgroup_size(1)
fn main() {
    let shadow = atomicExchange(&counts.shadow_out, 0u);
    counts.shadow_in = shadow;
    counts.shadow_total = add(counts.shadow_total, shadow);
    counts.connection_round++;
    arguments[ARGUMENTS_SHADOW] = workgroups(shadow);
}
