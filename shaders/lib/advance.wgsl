#import bind/queue
#import bind/subpath
#import lib/medium
#import lib/subpath

// The way of a sub-path into the queue for its next surface.

/// In the place of a slot: the path ends here.
const PATH_ENDS: u32 = 0xffffffffu;

/// Queues the ray that leaves `point`, the vertex at `depth`, with what it carries; returns its slot.
fn enqueue(path: u32, depth: u32, point: SurfacePoint, bounce: Bounce, throughput: vec3f) -> u32 {
    let next_throughput = throughput * bounce.weight;
    if !bounce.goes_on || !any(next_throughput != vec3f(0.0)) {
        return PATH_ENDS;
    }
    let slot = atomicAdd(&counts.paths_out, 1u);
    paths_out[slot] = PathRay(
        ray_origin(point, bounce.direction),
        path,
        bounce.direction,
        bounce.pdf_solid,
        next_throughput,
        (depth + 1u) | (medium_towards(point, bounce.direction) << 16u),
    );
    sub_paths_out[slot] = bounce.next;
    return slot;
}
