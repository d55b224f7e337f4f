#import bind/batch
#import bind/eye_records
#import bind/light_cache
#import bind/queue
#import bind/records
#import lib/alias
#import lib/connections
#import lib/path_key
#import lib/record_draws
#import lib/record_shares
#import lib/selection

// By the table of one of the three nearest records, or any vertex of the cache, all alike: lib/record_shares. The
// probability by the choice that was made is what counts, and weights are those of that choice. A record that no light
// reaches draws nothing, and no other is drawn in its place: weights do not know of it.

fn no_selection_by_record() -> Selection {
    return Selection(NO_VERTEX, 0.0, vec3f(0.0), CHOICE_ALL);
}

/// `index`, `path`: of the eye vertex's ray; `number`: of the connection among those of the eye vertex, which lies on
/// `material`.
fn select_light_vertex(index: u32, path: u32, depth: u32, number: u32, material: u32) -> Selection {
    let keys = random4(path_key(path), bounce_dimension(depth, DIMENSION_LIGHT));
    if number >= connections_drawn(depth, material, pcg4d(vec4u(keys.xyz, 0xffffffffu)).x) {
        return no_selection_by_record();
    }
    let vertices = light_path_offsets[batch.light_path_count];
    let near = eye_records[index].xyz;
    let shares = choice_shares(near);
    let words = pcg4d(vec4u(keys.xyz, number));
    var choice = words.z / (0xffffffffu / CHOICES + 1u);
    if shares[choice] == 0.0 {
        choice = CHOICE_ALL;
    }
    var place = 0u;
    var units = vec2u(1u, vertices);
    if choice == CHOICE_ALL {
        place = alias_draw(words.xy, vertices).slot;
    } else {
        let record = near[choice];
        if record_ends[record * vertices + vertices - 1u] == 0u {
            return no_selection_by_record();
        }
        place = draw_from_record(record, vertices, words.w);
        units = record_units(record, place, vertices);
    }
    var light = vec3f(0.0);
    for (var k = 0u; k < CHOICE_ALL; k++) {
        if shares[k] > 0.0 {
            light[k] = record_weights[near[k] * vertices + place];
        }
    }
    let pdf_select = shares[choice] * (f32(units.x) / f32(units.y));
    let expected = f32(batch.light_path_count) * connections_expected(depth, material) * pdf_select;
    return Selection(light_order[place], 1.0 / expected, light, choice);
}
