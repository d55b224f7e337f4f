// Directional albedo of the GGX lobe under Schlick's reflectance: E = f0 a + f90 b with (a, b) of a table that
// `halfway::math::ggx_albedo` integrates in f64. The importing kernel brings `ggx_albedo_texel`
// (bind/ggx_albedo).

const GGX_ALBEDO_SIZE: u32 = 32u;

/// (a, b) of texel (column, row): column = sqrt(cosine), row = sqrt(alpha), both on [0, 1].
/// Row GGX_ALBEDO_SIZE, column by sqrt(alpha), has the averages over the hemisphere.
struct GgxAlbedoCell {
    index: u32,
    weight: f32,
}

fn ggx_albedo_cell(x: f32) -> GgxAlbedoCell {
    let position = sqrt(x) * f32(GGX_ALBEDO_SIZE - 1u);
    let index = min(u32(position), GGX_ALBEDO_SIZE - 2u);
    return GgxAlbedoCell(index, position - f32(index));
}

fn ggx_albedo_row(row: u32, cell: GgxAlbedoCell) -> vec2f {
    let first = row * GGX_ALBEDO_SIZE + cell.index;
    return mix(ggx_albedo_texel(first), ggx_albedo_texel(first + 1u), cell.weight);
}

/// (a, b) for light or eye at `cos_theta` in (0, 1], bilinear.
fn ggx_albedo(cos_theta: f32, alpha: f32) -> vec2f {
    let column = ggx_albedo_cell(cos_theta);
    let row = ggx_albedo_cell(alpha);
    return mix(ggx_albedo_row(row.index, column), ggx_albedo_row(row.index + 1u, column), row.weight);
}

/// The cosine-weighted average 2 * integral of (a, b) cos d(cos), exact for what `ggx_albedo` interpolates: the
/// diffuse layer's energy rests on that.
fn ggx_albedo_average(alpha: f32) -> vec2f {
    return ggx_albedo_row(GGX_ALBEDO_SIZE, ggx_albedo_cell(alpha));
}
