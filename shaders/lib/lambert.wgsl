#import lib/hit
#import lib/roulette

// Surfaces that scatter by Lambert's law alone, as bidirectional weights see them: with the two directions apart. It is
// the BSDF of lib/bsdf and lib/shading.

/// Cosines of a direction to both normals of a point: lib/shading says why there are two.
struct Cosines {
    shading: f32,
    geometric: f32,
}

fn cosines(point: SurfacePoint, normal: vec3f, direction: vec3f) -> Cosines {
    return Cosines(dot(direction, normal), dot(direction, point.world_ng));
}

/// Light passes, as far as this direction says.
fn is_open(c: Cosines) -> bool {
    return sides_agree(c.shading, c.geometric);
}

/// f for the cosines of the direction to the light.
fn lambert_f(surface: Surface, to_light: Cosines) -> vec3f {
    return surface.base_color * (INV_PI * abs(to_light.shading / to_light.geometric));
}

/// Density per solid angle of scattering to a direction over its (shading) cosine, roulette included.
fn lambert_pdf_scale(surface: Surface) -> f32 {
    return INV_PI * survival(surface);
}
