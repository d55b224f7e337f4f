// Directional albedo of the GGX lobe under Schlick's reflectance: E = f0 a + f90 b with (a, b) of a table that
// `halfway::math::ggx_albedo` integrates in f64: rows of all alphas where textures have a say, or else those of the
// materials. The importing kernel brings `ggx_albedo_texel` (bind/ggx_albedo).

const GGX_ALBEDO_SIZE: u32 = 32u;

/// The fourth root of the narrowest alpha, 1e-3.
const GGX_ALBEDO_LOWEST: f32 = 0.177827941;

/// The texel below a position in [0, 1] along a side of the table, and how far beyond it lies.
struct GgxAlbedoCell {
    index: u32,
    weight: f32,
}

fn ggx_albedo_cell(x: f32) -> GgxAlbedoCell {
    let position = max(x, 0.0) * f32(GGX_ALBEDO_SIZE - 1u);
    let index = min(u32(position), GGX_ALBEDO_SIZE - 2u);
    return GgxAlbedoCell(index, position - f32(index));
}

/// In a row. Columns go by the fourth root of the cosine.
fn ggx_albedo_column(cos_theta: f32) -> GgxAlbedoCell {
    return ggx_albedo_cell(sqrt(sqrt(cos_theta)));
}

fn ggx_albedo_row(row: u32, cell: GgxAlbedoCell) -> vec2f {
    let first = row * GGX_ALBEDO_SIZE + cell.index;
    return mix(ggx_albedo_texel(first), ggx_albedo_texel(first + 1u), cell.weight);
}

#if !surface_textures
/// (a, b) for light or eye at `cos_theta` in (0, 1], linear in a row.
fn ggx_albedo_along(row: u32, cos_theta: f32) -> vec2f {
    return ggx_albedo_row(row, ggx_albedo_column(cos_theta));
}
#else
/// Rows go by the fourth root of alpha.
fn ggx_albedo_alpha_cell(alpha: f32) -> GgxAlbedoCell {
    return ggx_albedo_cell((sqrt(sqrt(alpha)) - GGX_ALBEDO_LOWEST) / (1.0 - GGX_ALBEDO_LOWEST));
}

/// The same, bilinear.
fn ggx_albedo(cos_theta: f32, alpha: f32) -> vec2f {
    let column = ggx_albedo_column(cos_theta);
    let row = ggx_albedo_alpha_cell(alpha);
    return mix(ggx_albedo_row(row.index, column), ggx_albedo_row(row.index + 1u, column), row.weight);
}

/// The cosine-weighted average 2 * integral of (a, b) cos d(cos), exact for what `ggx_albedo` interpolates: the
/// diffuse layer's energy rests on that. The last row of the table.
fn ggx_albedo_average(alpha: f32) -> vec2f {
    return ggx_albedo_row(GGX_ALBEDO_SIZE, ggx_albedo_alpha_cell(alpha));
}
#endif
