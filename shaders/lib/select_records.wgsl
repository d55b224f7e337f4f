#import bind/batch
#import bind/eye_records
#import bind/light_cache
#import bind/queue
#import bind/records
#import lib/alias
#import lib/connections
#import lib/path_key
#import lib/record_draws
#import lib/selection

// By the tables of the three nearest records, or in a quarter of all cases any vertex of the cache, all alike: what no
// record sees is drawn as well. The whole mixture's probability is what counts. Popov et al. 2015.

/// Share of the connections that any vertex may have: 1 / this.
const UNIFORM_PARTS: u32 = 4u;

/// `index`, `path`: of the eye vertex's ray; `number`: of the connection among those of the eye vertex, which lies on
/// `material`.
fn select_light_vertex(index: u32, path: u32, depth: u32, number: u32, material: u32) -> Selection {
    let keys = random4(path_key(path), bounce_dimension(depth, DIMENSION_LIGHT));
    if number >= connections_drawn(depth, material, pcg4d(vec4u(keys.xyz, 0xffffffffu)).x) {
        return Selection(NO_VERTEX, 0.0);
    }
    let vertices = light_path_offsets[batch.light_path_count];
    // Those that some light reaches.
    let nearest = eye_records[index];
    var lit: array<u32, 3>;
    var lit_count = 0u;
    for (var i = 0u; i < 3u; i++) {
        if nearest[i] != NO_RECORD && record_ends[nearest[i] * vertices + vertices - 1u] > 0u {
            lit[lit_count] = nearest[i];
            lit_count++;
        }
    }
    let words = pcg4d(vec4u(keys.xyz, number));
    let part = words.z / (0xffffffffu / UNIFORM_PARTS + 1u);
    var place: u32;
    if part == 0u || lit_count == 0u {
        place = alias_draw(words.xy, vertices).slot;
    } else {
        // The part's number is known to be another, the rest of the word is not.
        let chosen = lit[mul_high(words.z * UNIFORM_PARTS, lit_count)];
        place = draw_from_record(chosen, vertices, words.w);
    }
    let uniform_share = select(1.0 / f32(UNIFORM_PARTS), 1.0, lit_count == 0u);
    var pdf_select = uniform_share / f32(vertices);
    for (var i = 0u; i < lit_count; i++) {
        let units = record_units(lit[i], place, vertices);
        pdf_select += (1.0 - uniform_share) / f32(lit_count) * (f32(units.x) / f32(units.y));
    }
    let expected = f32(batch.light_path_count) * connections_expected(depth, material) * pdf_select;
    return Selection(light_order[place], 1.0 / expected);
}
