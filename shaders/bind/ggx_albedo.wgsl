#import lib/ggx_albedo

/// `halfway::math::ggx_albedo::GgxAlbedo`: its texels, or rows of the alphas that materials have.
@group(0) @binding(7) var<storage, read> ggx_albedo_table: array<vec2f>;

fn ggx_albedo_texel(index: u32) -> vec2f {
    return ggx_albedo_table[index];
}
