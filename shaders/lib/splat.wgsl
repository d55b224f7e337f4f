#import bind/page
#import bind/splats
#import lib/math
#import lib/rng

// Sums that many invocations add to, in 64-bit fixed point: integers commute, so no addition is lost and the
// sum does not depend on the order. A unit is 2^-44 of device radiance, which is one at the strongest light, or of a
// multiple of it where the picture is much dimmer (`batch.splat_scale`); what lies between two units goes to either with
// the chance that makes the mean right.

const SPLAT_UNIT: f32 = 0x1p-44;
/// A high word counts in 2^32 units.
const SPLAT_HIGH_UNIT: f32 = 0x1p-12;
/// What is not below this is counted instead of added; sums reach four times as far.
const SPLAT_LIMIT: f32 = 0x1p+18;

#if splats_atomic
/// Adds a contribution of channels that are not negative to a pixel.
fn add_splat(pixel: u32, contribution: vec3f) {
    let first = in_page(pixel) * SPLAT_WORDS;
    if !is_finite3(contribution) || any(contribution >= vec3f(SPLAT_LIMIT)) {
        atomicAdd(&splats[first + SPLAT_LOST], 1u);
        return;
    }
    let bits = bitcast<vec3u>(contribution);
    let random = pcg4d(vec4u(bits, pixel));
    for (var channel = 0u; channel < 3u; channel++) {
        let high = floor(contribution[channel] / SPLAT_HIGH_UNIT);
        // Exact, since both have the last place of the contribution.
        let rest = (contribution[channel] - high * SPLAT_HIGH_UNIT) / SPLAT_UNIT;
        let whole = floor(rest);
        let up = uniform_from_word(random[channel]) < rest - whole;
        let low = u32(whole) + select(0u, 1u, up);
        let old_low = atomicAdd(&splats[first + 2u * channel], low);
        let carried = u32(high) + select(0u, 1u, old_low + low < old_low);
        let old_high = atomicAdd(&splats[first + 2u * channel + 1u], carried);
        if old_high + carried < old_high {
            atomicAdd(&splats[first + SPLAT_LOST], 1u);
        }
    }
}
#else
/// What the pixel at this place of the page has gathered. w: how many contributions were not finite, or too large, and not
/// counted yet.
fn splat_of(place: u32) -> vec4f {
    let first = place * SPLAT_WORDS;
    var sum: vec3f;
    for (var channel = 0u; channel < 3u; channel++) {
        let low = f32(splats[first + 2u * channel]) * SPLAT_UNIT;
        sum[channel] = f32(splats[first + 2u * channel + 1u]) * SPLAT_HIGH_UNIT + low;
    }
    let lost = splats[first + SPLAT_LOST];
    splats[first + SPLAT_LOST] = 0u;
    return vec4f(sum, f32(lost));
}
#endif
