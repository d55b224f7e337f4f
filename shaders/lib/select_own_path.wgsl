#import bind/light_cache
#import lib/selection

// Every vertex of the light path that was traced for the eye path, once.

/// `index`, `path`: of the eye vertex's ray; `number`: of the connection among those of the eye vertex, which lies on
/// `material`.
fn select_light_vertex(index: u32, path: u32, depth: u32, number: u32, material: u32) -> Selection {
    return Selection(light_order[light_path_offsets[path] + number], 1.0);
}
