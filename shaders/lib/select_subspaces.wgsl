#import bind/batch
#import bind/buckets
#import bind/queue
#import bind/subspace_mis
#import bind/subspaces
#import lib/alias
#import lib/connections
#import lib/path_key
#import lib/selection

// Two stages: a light subspace by Gamma, and of it a vertex in proportion to |w|. Su, Li, Wang 2022. The subspaces of a
// vertex's connections are systematic draws: evenly spaced in the row's running sum, from one random number.

/// A light subspace by the row `first / K` of Gamma.
fn draw_column(first: u32, word: u32) -> u32 {
    let below = min(word, 0xfffffffeu);
    var column = gamma_cutpoints[first + mul_high(below, batch.subspaces)].y;
    while below >= gamma_cutpoints[first + column].x {
        column++;
    }
    return column;
}

/// `index`, `path`: of the eye vertex's ray; `number`: of the connection among those of the eye vertex, which lies on
/// `material`.
fn select_light_vertex(index: u32, path: u32, depth: u32, number: u32, material: u32) -> Selection {
    let eye_label = eye_labels[index].x;
    let words = path_words(path, bounce_dimension(depth, DIMENSION_LIGHT));
    let count = connections_drawn(depth, material, pcg4d(vec4u(words.yzw, 0xffffffffu)).x);
    if number >= count {
        return Selection(NO_VERTEX, 0.0);
    }
#if independent
    let light_label = draw_column(eye_label * batch.subspaces, pcg4d(vec4u(words.yzw, number)).z);
#else
    // Units that the draws are apart. What is left over, N units of 2^32 at most, is never drawn.
    let step = 0xffffffffu / count;
    let light_label = draw_column(eye_label * batch.subspaces, number * step + mul_high(words.x, step));
#endif
    let range = bucket_range(light_label);
    // Where the subspace is empty this time, there is no connection, and no other draw: that would be a bias.
    if range.x == range.y {
        return Selection(NO_VERTEX, 0.0);
    }
    let n = range.y - range.x;
    let item = bucket_items[draw_from_bucket(range, pcg4d(vec4u(words.yzw, number)).xy)];
    let table_units = n << slot_bits(n);
    let expected = f32(batch.light_path_count) * connections_expected(depth, material)
        * gamma_pdf[eye_label * batch.subspaces + light_label];
    return Selection(item.x, f32(table_units) / f32(item.y) / expected);
}
