// What can be sampled as a light, and how likely each is picked.

struct Light {
    /// LIGHT_*
    kind: u32,
    /// Index into `triangles` or `punctual_lights`.
    index: u32,
    /// Slot of the alias table over all lights.
    threshold: u32,
    alias_index: u32,
    /// Probability of this light.
    pdf_select: f32,
}

const LIGHT_TRIANGLE: u32 = 0u;
const LIGHT_ENVIRONMENT: u32 = 1u;
const LIGHT_POINT: u32 = 2u;
const LIGHT_SPOT: u32 = 3u;
const LIGHT_DIRECTIONAL: u32 = 4u;

@group(0) @binding(8) var<storage, read> lights: array<Light>;

#if punctual_lights
struct PunctualLight {
    position: vec3f,
    /// 1 - cosine of the half angle of the cone that it shines into; 2 of a point light. A narrow cone's cosine alone
    /// would have lost its digits.
    cone: f32,
    intensity: vec3f,
    /// Spot falloff: what `cone` leaves of 1 - cosine, times this, clamped and squared. (glTF's formula, with the
    /// differences of cosines written as what they differ from one.)
    falloff_scale: f32,
    direction: vec3f,
    pad: u32,
}

@group(0) @binding(9) var<storage, read> punctual_lights: array<PunctualLight>;
#endif

#if environment
/// An equal-area square of directions (lib/equal_area): radiance, constant over a texel, as lib/environment unpacks it.
@group(0) @binding(10) var<storage, read> environment_texels: array<vec2u>;
/// Threshold and alias of each texel.
@group(0) @binding(11) var<storage, read> environment_alias: array<vec2u>;

struct EnvironmentMap {
    /// Texels along a side.
    size: u32,
    /// Index of the environment in `lights`.
    light: u32,
    /// Density per solid angle of a texel, where it is not black: its luminance times the one, plus the other.
    pdf_scale: f32,
    pdf_floor: f32,
}

@group(0) @binding(13) var<uniform> environment_map: EnvironmentMap;
#endif
