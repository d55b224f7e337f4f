#import bind/subpath
#import bind/surface

// Thinning: the share of its connections that an eye vertex makes, by its material. Most connections to a narrow lobe
// find nothing that sampling the lobe would not find better. In whole units of 1 / THINNING_UNITS, so that all who ask
// get the same number; materials without narrow lobes have all of them.

const THINNING_UNITS: u32 = 256u;
/// In the flags of a material and of a sub-path.
const THINNING_SHIFT: u32 = 8u;
const_assert (((SUBPATH_RUN_MOST << SUBPATH_RUN_SHIFT) >> THINNING_SHIFT) == 0u);

/// Of a vertex on such a material.
fn thinning_units(material: u32) -> u32 {
#if thinning
    return materials[material].flags >> THINNING_SHIFT;
#else
    return THINNING_UNITS;
#endif
}

fn thinning_at(material: u32) -> f32 {
#if thinning
    return f32(thinning_units(material)) / f32(THINNING_UNITS);
#else
    return 1.0;
#endif
}

/// What a sub-path that leaves a vertex on such a material has in its flags.
fn thinning_flags(material: u32) -> u32 {
#if thinning
    return thinning_units(material) << THINNING_SHIFT;
#else
    return 0u;
#endif
}

/// Of the vertex that a sub-path with these flags has left.
fn thinning_before(flags: u32) -> f32 {
#if thinning
    return f32(flags >> THINNING_SHIFT) / f32(THINNING_UNITS);
#else
    return 1.0;
#endif
}
