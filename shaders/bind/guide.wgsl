// What light paths have learnt of where the light that they carry is wanted: lib/guide.

/// A light's slot of the alias table that light paths pick their light from.
struct GuidePick {
    threshold: u32,
    alias_index: u32,
    /// Probability of the light.
    pdf_select: f32,
    pad: u32,
}

/// For each light subspace 8 numbers for the columns of the square that directions are drawn from, then 8 for the cells of
/// each column: upper bounds of their shares, the last of them 1.
@group(3) @binding(19) var<storage, read> guide_bounds: array<f32>;
@group(3) @binding(20) var<storage, read> guide_picks: array<GuidePick>;
