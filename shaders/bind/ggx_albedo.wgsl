#import lib/ggx_albedo

/// `halfway::math::ggx_albedo::GgxAlbedo::texels`, two (a, b) in each vector.
@group(0) @binding(7) var<uniform> ggx_albedo_table: array<vec4f, 528>;

fn ggx_albedo_texel(index: u32) -> vec2f {
    let pair = ggx_albedo_table[index / 2u];
    return select(pair.xy, pair.zw, (index & 1u) == 1u);
}
