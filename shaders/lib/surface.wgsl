#if !lambert_only
#import lib/color
#import lib/ggx_albedo
#import lib/math
#endif

// The parameters of a BSDF at a hit. How they follow from glTF's (metallic-roughness, KHR_materials_ior, _specular,
// _transmission, _volume): here where textures have a say, else on the host, once for each material, by the same rules
// (`halfway::device::scene::microfacet`).

/// Nothing but delta lobes. The host decides it, for the whole material: `Material::is_delta`.
const SURFACE_DELTA: u32 = 1u;
/// The boundary of a volume, which refracts; a thin pane without it.
const SURFACE_VOLUME: u32 = 2u;

/// Cosines to the normal below this are rejected, on both sides: their f32 value has no certain digit left.
const MIN_COS: f32 = 1e-7;
/// Narrowest finite lobe, as GGX alpha and as the half angle (radians) of a refracted one, alpha |eta - 1|: what
/// is narrower would get its density from rounding errors. Pure materials below it are delta instead.
const MIN_ALPHA: f32 = 1e-3;
const MIN_REFRACTED_SPREAD: f32 = 2e-4;
/// Smallest index of refraction with a finite lobe; at 1 there is no half vector.
const MIN_ROUGH_ETA: f32 = 1.02;

struct Surface {
    base_color: vec3f,
    flags: u32,
#if !lambert_only
    /// Reflectance at normal incidence of the opaque dielectric's interface, and at grazing incidence.
    f0: vec3f,
    f90: f32,
    metallic: f32,
    /// GGX width, the square of glTF's roughness, at least MIN_ALPHA.
    alpha: f32,
    /// Share of the dielectric that transmits.
    transmission: f32,
    /// n_inside / n_outside; the shading normal points outside.
    eta: f32,
    /// 1 / (1 - average albedo of the dielectric interface): see `diffuse_layer` in lib/bsdf.
    inv_base_average: f32,
#if !surface_textures
    /// Where the table of albedos has the row of this alpha.
    albedo_row: u32,
#endif
#endif
}

/// A surface that only scatters by Lambert's law.
fn surface_lambert(base_color: vec3f) -> Surface {
    var s: Surface;
    s.base_color = base_color;
#if !lambert_only
    s.alpha = 1.0;
    s.eta = 1.0;
    s.inv_base_average = 1.0;
#endif
    return s;
}

#if surface_textures
/// The glTF parameters, factors times textures. `ior` is at least 1.
struct SurfaceFactors {
    base_color: vec3f,
    metallic: f32,
    specular_color: vec3f,
    specular: f32,
    roughness: f32,
    transmission: f32,
    ior: f32,
    flags: u32,
}

fn surface_from_factors(m: SurfaceFactors) -> Surface {
    var s: Surface;
    s.base_color = m.base_color;
    s.flags = m.flags;
    s.metallic = m.metallic;
    s.transmission = m.transmission;
    s.eta = m.ior;
    s.alpha = max(m.roughness * m.roughness, MIN_ALPHA);
    if (m.flags & SURFACE_DELTA) == 0u && (m.flags & SURFACE_VOLUME) != 0u && m.transmission > 0.0 {
        s.eta = max(m.ior, MIN_ROUGH_ETA);
        s.alpha = max(s.alpha, MIN_REFRACTED_SPREAD / (s.eta - 1.0));
    }
    let r = (m.ior - 1.0) / (m.ior + 1.0);
    s.f0 = min(r * r * m.specular_color, vec3f(1.0)) * m.specular;
    s.f90 = m.specular;
    let average = interface_albedo(s, ggx_albedo_average(s.alpha));
    s.inv_base_average = select(0.0, 1.0 / (1.0 - average), average < 1.0);
    return s;
}
#endif

#if !lambert_only
/// (a, b) of lib/ggx_albedo at a cosine to the normal.
fn lobe_albedo(s: Surface, cos_theta: f32) -> vec2f {
#if surface_textures
    return ggx_albedo(cos_theta, s.alpha);
#else
    return ggx_albedo_along(s.albedo_row, cos_theta);
#endif
}

/// Albedo of the opaque dielectric's interface from the table's (a, b): the largest channel, so that a coloured
/// interface does not tint the base with its complement (KHR_materials_specular).
fn interface_albedo(s: Surface, ab: vec2f) -> f32 {
    return max_component(s.f0) * ab.x + s.f90 * ab.y;
}
#endif

/// How much a surface scatters at all, by channel in [0, 1] and whatever the directions: for roulette, which
/// must know no direction.
fn bsdf_albedo(s: Surface) -> vec3f {
#if lambert_only
    return s.base_color;
#else
    let opaque_dielectric = s.f0 + (1.0 - max_component(s.f0)) * s.base_color;
    return mix(mix(opaque_dielectric, s.base_color, s.transmission), s.base_color, s.metallic);
#endif
}
