#import bind/batch
#import bind/light_cache
#import bind/queue
#import lib/alias
#import lib/connections
#import lib/path_key
#import lib/selection

// Any vertex of the cache, all alike. Davidovic et al. 2014.

/// `index`, `path`: of the eye vertex's ray; `number`: of the connection among those of the eye vertex, which lies on
/// `material`.
fn select_light_vertex(index: u32, path: u32, depth: u32, number: u32, material: u32) -> Selection {
    let vertices = light_path_offsets[batch.light_path_count];
    let words = random4(path_key(path), bounce_dimension(depth, DIMENSION_LIGHT));
    if number >= connections_drawn(depth, material, pcg4d(vec4u(words.xyz, 0xffffffffu)).x) {
        return Selection(NO_VERTEX, 0.0);
    }
    let draw = alias_draw(pcg4d(vec4u(words.xyz, number)).xy, vertices);
    let inv_density = f32(vertices) / (f32(batch.light_path_count) * connections_expected(depth, material));
    return Selection(light_order[draw.slot], inv_density);
}
