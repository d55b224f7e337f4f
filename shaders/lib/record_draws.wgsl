#import bind/records
#import lib/alias

// Draws by a record's table.

/// Units that a record's table has for a place in the cache's order, and all of its units.
fn record_units(record: u32, place: u32, vertices: u32) -> vec2u {
    let first = record * vertices;
    var before = 0u;
    if place > 0u {
        before = record_ends[first + place - 1u];
    }
    return vec2u(record_ends[first + place] - before, record_ends[first + vertices - 1u]);
}

/// The place that a random word draws from a record's table, which has units.
fn draw_from_record(record: u32, vertices: u32, word: u32) -> u32 {
    let first = record * vertices;
    let unit = mul_high(word, record_ends[first + vertices - 1u]);
    var low = 0u;
    var high = vertices - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if record_ends[first + middle] > unit {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}
