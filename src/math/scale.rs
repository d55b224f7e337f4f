//! Exact powers of two. A scene is brought to unit size, and its light to unit power, by a power of two: no bit of
//! any number changes but its exponent, and every kernel sees numbers of one size.

/// The k for which `magnitude * 2^k` lies in [0.5, 1); `None` for zero, negative and non-finite magnitudes, for
/// which there is nothing to bring to size.
pub fn normalising_exponent(magnitude: f64) -> Option<i32> {
    if !(magnitude > 0.0 && magnitude.is_finite()) {
        return None;
    }
    // A subnormal number has no implicit bit: shift it into the normal range and count the shift.
    let (normal, shift) =
        if magnitude < f64::MIN_POSITIVE { (magnitude * 2f64.powi(64), 64) } else { (magnitude, 0) };
    let exponent = (normal.to_bits() >> 52) as i32 - 1022;
    Some(shift - exponent)
}

/// `x * 2^k`, exact wherever the result is a normal number, for every k.
pub fn scale_by_power_of_two(x: f64, k: i32) -> f64 {
    // Two or three factors, since 2^k itself may be out of range where the product is not.
    let (first, rest) = (k.clamp(-1000, 1000), k - k.clamp(-1000, 1000));
    x * 2f64.powi(first) * 2f64.powi(rest.clamp(-1000, 1000)) * 2f64.powi(rest - rest.clamp(-1000, 1000))
}
