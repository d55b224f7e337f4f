#import lib/hit
#import lib/roulette

// Surfaces that scatter by Lambert's law alone, as bidirectional weights see them: with the two directions apart. It is
// the BSDF of lib/bsdf and lib/shading.

/// f for the direction to the light.
fn lambert_f(surface: Surface, to_light: ShadingDirection) -> vec3f {
    return surface.base_color * (INV_PI * abs(to_light.cos_shading / to_light.cos_geometric));
}

/// Density per solid angle of scattering to a direction over its (shading) cosine, roulette included.
fn lambert_pdf_scale(surface: Surface) -> f32 {
    return INV_PI * survival(surface);
}
