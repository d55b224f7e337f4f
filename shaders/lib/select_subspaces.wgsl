#import bind/batch
#import bind/buckets
#import bind/queue
#import bind/subspace_mis
#import bind/subspaces
#import lib/alias
#import lib/connections
#import lib/path_key
#import lib/selection

// Two stages: a light subspace by Gamma, and of it a vertex in proportion to |w|. Su, Li, Wang 2022.

/// `index`, `path`: of the eye vertex's ray; `number`: of the connection among those of the eye vertex.
fn select_light_vertex(index: u32, path: u32, depth: u32, number: u32) -> Selection {
    if number >= connections_at(depth) {
        return Selection(NO_VERTEX, 0.0);
    }
    let eye_label = eye_labels[index].x;
    let words = random4(path_key(path), bounce_dimension(depth, DIMENSION_LIGHT));
    let mixed = pcg4d(vec4u(words.xyz, number));
    let draw = alias_draw(mixed.xy, batch.subspaces);
    let slot = gamma_alias[eye_label * batch.subspaces + draw.slot];
    let light_label = alias_pick(draw, slot.x, slot.y);
    let range = bucket_range(light_label);
    // Where the subspace is empty this time, there is no connection, and no other draw: that would be a bias.
    if range.x == range.y {
        return Selection(NO_VERTEX, 0.0);
    }
    let n = range.y - range.x;
    let item = bucket_items[draw_from_bucket(range, mixed.zw)];
    let table_units = n << slot_bits(n);
    let expected = f32(batch.light_path_count) * f32(connections_at(depth))
        * gamma_pdf[eye_label * batch.subspaces + light_label];
    return Selection(item.x, f32(table_units) / f32(item.y) / expected);
}
