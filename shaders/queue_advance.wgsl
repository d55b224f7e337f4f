#import bind/queue

// Between two stages: what was written becomes what is read, and the sizes of the next dispatches follow.

/// Workgroup counts of the next closest-hit and shade dispatches, then of the next occlusion dispatch.
@group(2) @binding(0) var<storage, read_write> arguments: array<vec4u, 2>;

fn workgroups(invocations: u32) -> vec4u {
    let count = (invocations + WORKGROUP - 1u) / WORKGROUP;
    return vec4u(min(count, 65535u), (count + 65534u) / 65535u, 1u, 0u);
}

fn add(total: vec2u, count: u32) -> vec2u {
    let low = total.x + count;
    return vec2u(low, total.y + select(0u, 1u, low < count));
}

@compute @workgroup_size(1)
fn main() {
    let paths = atomicExchange(&counts.paths_out, 0u);
    let shadow = atomicExchange(&counts.shadow_out, 0u);
    counts.paths_in = paths;
    counts.shadow_in = shadow;
    counts.closest_total = add(counts.closest_total, paths);
    counts.shadow_total = add(counts.shadow_total, shadow);
    arguments[0] = workgroups(paths);
    arguments[1] = workgroups(shadow);
}
