#import bind/buckets
#import bind/light_cache
#import bind/subspaces
#import lib/color

// Running sums of |w| over each subspace, by blocks: the error of a plain sum grows with the number of vertices.

const BLOCK: u32 = 64u;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let label = id.x;
    if label >= SUBSPACES {
        return;
    }
    let range = bucket_range(label);
    var before = 0.0;
    for (var first = range.x; first < range.y; first += BLOCK) {
        var sum = 0.0;
        for (var i = first; i < min(first + BLOCK, range.y); i++) {
            sum += magnitude(light_vertices[bucket_order[i]].weight);
            bucket_sums[i] = before + sum;
        }
        before += sum;
    }
}
