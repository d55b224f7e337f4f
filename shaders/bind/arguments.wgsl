#import bind/queue

// Sizes of dispatches that the device decides.

/// Workgroup counts of kernels with one invocation per path, per connection in the queue, and per connection where each
/// path has one, two, up to CONNECTIONS_IN_FLIGHT of them.
@group(2) @binding(0) var<storage, read_write> arguments: array<vec4u, 6>;

const ARGUMENTS_PATHS: u32 = 0u;
const ARGUMENTS_SHADOW: u32 = 1u;
const ARGUMENTS_CONNECTIONS: u32 = 2u;

fn workgroups(invocations: u32) -> vec4u {
    let count = (invocations + WORKGROUP - 1u) / WORKGROUP;
    return vec4u(min(count, 65535u), (count + 65534u) / 65535u, 1u, 0u);
}

/// A 64-bit total (low word, high word) with something added.
fn add(total: vec2u, count: u32) -> vec2u {
    let low = total.x + count;
    return vec2u(low, total.y + select(0u, 1u, low < count));
}
