#if light_guide
#import bind/guide
#import lib/frame
#import lib/math
#import lib/sampling
#endif

// Where light paths go: the numbers that a direction (or the place of parallel light) is made of are drawn from a histogram
// over their square, one for each light subspace, in place of evenly. Weights do not notice: no density of a light path is in
// them but in that of connecting it to the camera, which takes it for unguided (lib/weights_subspaces). After Vorba et al.,
// On-line Learning of Parametric Mixture Models for Light Transport Simulation, ACM TOG 33(4), 2014, in its purpose, not in
// its model.

/// A point of the unit square, and its density over that of an even choice.
struct GuideDraw {
    square: vec2f,
    density: f32,
}

#if light_guide
const GUIDE_SIDE: u32 = 8u;
/// Numbers for each light subspace.
const GUIDE_STRIDE: u32 = GUIDE_SIDE * (1u + GUIDE_SIDE);

/// Which of the intervals from `first` on.
struct GuideInterval {
    index: u32,
    low: f32,
    width: f32,
}

fn guide_interval(first: u32, index: u32) -> GuideInterval {
    var low = 0.0;
    if index > 0u {
        low = guide_bounds[first + index - 1u];
    }
    return GuideInterval(index, low, guide_bounds[first + index] - low);
}

/// The interval that holds u of [0, 1).
fn find_interval(first: u32, u: f32) -> GuideInterval {
    var index = select(0u, 4u, u >= guide_bounds[first + 3u]);
    index += select(0u, 2u, u >= guide_bounds[first + index + 1u]);
    index += select(0u, 1u, u >= guide_bounds[first + index]);
    return guide_interval(first, index);
}

/// Draws a point of the square of a light subspace.
fn guide_draw(label: u32, u: vec2f) -> GuideDraw {
    let first = label * GUIDE_STRIDE;
    let column = find_interval(first, u.x);
    let cell = find_interval(first + GUIDE_SIDE * (1u + column.index), u.y);
    let inside = vec2f((u.x - column.low) / column.width, (u.y - cell.low) / cell.width);
    let square = (vec2f(f32(column.index), f32(cell.index)) + clamp(inside, vec2f(0.0), vec2f(0x1.fffffep-1)))
        / f32(GUIDE_SIDE);
    // On the grid of `uniform4`, whose points no warp turns into NaN.
    let on_grid = min(floor(square * 0x1p+24) * 0x1p-24, vec2f(0x1.fffffep-1));
    return GuideDraw(on_grid, column.width * cell.width * f32(GUIDE_SIDE * GUIDE_SIDE));
}

/// Density of a point of the square over that of an even choice.
fn guide_density(label: u32, square: vec2f) -> f32 {
    let first = label * GUIDE_STRIDE;
    let at = min(vec2u(max(square, vec2f(0.0)) * f32(GUIDE_SIDE)), vec2u(GUIDE_SIDE - 1u));
    let column = guide_interval(first, at.x);
    let cell = guide_interval(first + GUIDE_SIDE * (1u + at.x), at.y);
    return column.width * cell.width * f32(GUIDE_SIDE * GUIDE_SIDE);
}

/// A direction from a surface about the normal of `frame`: `label` is the vertex's.
fn guide_direction(label: u32, frame: Frame, u: vec2f) -> vec3f {
    return to_world(frame, sample_cosine_hemisphere(guide_draw(label, u).square));
}

/// Its density per solid angle.
fn guide_pdf_solid(label: u32, frame: Frame, direction: vec3f) -> f32 {
    let local = to_local(frame, direction);
    return max(local.z, 0.0) * INV_PI * guide_density(label, disk_to_square(local.xy));
}
#else
/// Evenly.
fn guide_draw(label: u32, u: vec2f) -> GuideDraw {
    return GuideDraw(u, 1.0);
}
#endif
