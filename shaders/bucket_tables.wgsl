#import bind/bucket_sums
#import bind/buckets
#import bind/light_cache
#import bind/queue

// The alias tables of the light subspaces, every slot on its own: slots that lack units are filled in their order by those
// that have some to spare, in theirs, so that the running sums of both say which meets which. Hübschle-Schneider and
// Sanders, Parallel Weighted Random Sampling, ESA 2019.

/// First place where the running sum (x: of lacks, y: of spares) reaches `sum`; `range.y` where none does.
fn first_reaching(range: vec2u, of_spares: bool, sum: u32) -> u32 {
    var low = range.x;
    var high = range.y;
    while low < high {
        let middle = (low + high) / 2u;
        let there = select(bucket_sums[middle].x, bucket_sums[middle].y, of_spares);
        if there >= sum {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let place = invocation(id);
    if place >= bucket_ends[arrayLength(&bucket_ends) - 1u] {
        return;
    }
    let item = bucket_items[place];
    let range = bucket_range(light_vertices[item.x].number_label >> 16u);
    let bits = slot_bits(range.y - range.x);
    let slot = 1u << bits;
    let sums = bucket_sums[place];
    // A full slot aliases to itself.
    var entry = vec2u(0u, place);
    if item.y < slot {
        // Filled by the first with something left after all lacks before.
        entry = vec2u(item.y, first_reaching(range, true, max(sums.x - (slot - item.y), 1u)));
    } else if item.y > slot {
        // Gives until it lacks something itself; the next one fills that.
        let lacking = first_reaching(range, false, sums.y + 1u);
        if lacking < range.y {
            let kept = slot + sums.y - bucket_sums[lacking].x;
            entry = vec2u(kept, first_reaching(range, true, sums.y + 1u));
        }
    }
    bucket_tables[place] = vec2u(entry.x << (32u - bits), entry.y);
}
