#import bind/lights
#import lib/color
#import lib/equal_area
#import lib/math

// The environment's texels: what they radiate, and how likely they are drawn.

/// The colour that `math::shared_exponent` packed.
fn unpack_color(packed: vec2u) -> vec3f {
    let channels = vec3u(
        packed.x & 0x3ffffu,
        ((packed.x >> 18u) | (packed.y << 14u)) & 0x3ffffu,
        (packed.y >> 4u) & 0x3ffffu,
    );
    return vec3f(channels) * bitcast<f32>((packed.y >> 22u) << 23u);
}

fn environment_texel(direction: vec3f) -> u32 {
    let size = f32(environment_map.size);
    let at = min(vec2u(sphere_to_square(direction) * size), vec2u(environment_map.size - 1u));
    return at.y * environment_map.size + at.x;
}

fn texel_radiance(texel: u32) -> vec3f {
    return unpack_color(environment_texels[texel]);
}

/// Density per solid angle, in a texel of that radiance, of drawing texels by the table.
fn texel_pdf_solid(radiance: vec3f) -> f32 {
    let power = luminance(radiance);
    return select(0.0, power * environment_map.pdf_scale + environment_map.pdf_floor, power > 0.0);
}

fn environment_radiance(direction: vec3f) -> vec3f {
    return texel_radiance(environment_texel(direction));
}
