#import lib/math

// Colours are linear Rec.709.

/// Relative luminance, ITU-R BT.709.
fn luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

fn max_component(color: vec3f) -> f32 {
    return max(color.x, max(color.y, color.z));
}

/// |.| of a colour: what the densities of subspaces are in proportion to.
fn magnitude(color: vec3f) -> f32 {
    return color.x + color.y + color.z;
}

/// Of this magnitude there is light to give, and a finite amount.
fn is_drawable(sum: f32) -> bool {
    return sum > 0.0 && is_finite3(vec3f(sum));
}
