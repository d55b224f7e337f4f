//! Colours in 64 bits: three whole numbers of 18 bits and a power of two that they are times. Mirrors `unpack_color` of
//! `lib/environment.wgsl`.

/// Bits of a channel.
const BITS: i32 = 18;
const CHANNEL: u32 = (1 << BITS) - 1;
/// Exponents as `f32` has them: biased, in eight bits.
const BIAS: i32 = 127;
/// The largest: that of the largest `f32`'s last bit of [`BITS`].
const MOST: i32 = 2 * BIAS - (BITS - 1);

/// The colour whose largest channel is within 2^-18 of `color`'s as a share, and the others within as much of that. All of
/// it is finite and not negative; what has no channel above 2^-108 becomes black.
pub fn pack(color: [f32; 3]) -> [u32; 2] {
    let largest = color.into_iter().fold(0.0, f32::max);
    let exponent = (largest.to_bits() >> 23) as i32 - (BITS - 1);
    if exponent < 1 {
        return [0; 2];
    }
    let whole = |exponent: i32| {
        let unit = f64::from(f32::from_bits((exponent as u32) << 23));
        color.map(|channel| (f64::from(channel) / unit).round() as u32)
    };
    let mut exponent = exponent;
    let mut channels = whole(exponent);
    if channels.into_iter().any(|channel| channel > CHANNEL) {
        if exponent < MOST {
            exponent += 1;
            channels = whole(exponent);
        } else {
            // Up would be infinite.
            channels = channels.map(|channel| channel.min(CHANNEL));
        }
    }
    let [r, g, b] = channels;
    [r | g << BITS, g >> (32 - BITS) | b << 4 | (exponent as u32) << 22]
}

/// The colour that is meant.
pub fn unpack([low, high]: [u32; 2]) -> [f32; 3] {
    let channels = [low & CHANNEL, (low >> BITS | high << (32 - BITS)) & CHANNEL, high >> 4 & CHANNEL];
    let unit = 2f64.powi((high >> 22) as i32 - BIAS);
    channels.map(|channel| (f64::from(channel) * unit) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_what_they_were() {
        let channels = [0.0, 1.0, 0.999_999_9, 0.3, 1e-4, 3e-9, f32::MAX, 2f32.powi(-107), 1.5e-30, 7.1e20];
        for r in channels {
            for g in channels {
                for b in channels {
                    let color = [r, g, b];
                    let largest = r.max(g).max(b);
                    for (have, want) in unpack(pack(color)).into_iter().zip(color) {
                        assert!(
                            (have - want).abs() <= 2f32.powi(-18) * largest,
                            "{color:?}: {have} for {want}"
                        );
                    }
                }
            }
        }
        assert_eq!(unpack(pack([1e-35; 3])), [0.0; 3]);
        assert_eq!(unpack(pack([0.5, 0.25, 0.0])), [0.5, 0.25, 0.0]);
    }
}
