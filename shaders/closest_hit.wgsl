#import bind/queue
#import lib/traverse

// Finds where every waiting path meets its next surface.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= atomicLoad(&counts[COUNT_PATHS_IN]) {
        return;
    }
    let hit = trace(paths_in[index].origin, paths_in[index].direction, 0x1.fffffep+127);
    hits[index] = Hit(hit.t, hit.triangle, hit.b1, hit.b2);
}
