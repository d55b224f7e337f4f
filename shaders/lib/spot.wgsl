#import bind/lights

/// Intensity of a spot light in a unit direction, as a share of its largest.
fn spot_falloff(light: PunctualLight, direction: vec3f) -> f32 {
    // The cosine of a small angle is 1 in f32; the chord between both directions keeps the angle's digits.
    let chord = direction - light.direction;
    let falloff = clamp((light.cone - 0.5 * dot(chord, chord)) * light.falloff_scale, 0.0, 1.0);
    return falloff * falloff;
}
