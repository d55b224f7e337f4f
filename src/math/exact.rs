//! Sums of `f64` whose rounding is not lost, so that they do not depend on the order of their terms.

/// a + b as it is rounded, and what that leaves out: both together are a + b exactly (Knuth, The Art of Computer
/// Programming 2, 4.2.2, theorem B). A sum that is not finite leaves out nothing.
pub fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    if !sum.is_finite() {
        return [sum, 0.0];
    }
    let b_rounded = sum - a;
    let a_rounded = sum - b_rounded;
    [sum, (a - a_rounded) + (b - b_rounded)]
}

/// The `f64` next to the exact sum, of two that are as near the even one: the same in any order of the parts.
pub fn rounded_sum(parts: impl IntoIterator<Item = f64>) -> f64 {
    // Shewchuk's expansions, as Python's math.fsum has them: partial sums without common digits, the smallest first.
    let mut partials: Vec<f64> = Vec::new();
    let mut plain = 0.0;
    for mut part in parts {
        plain += part;
        partials.retain_mut(|partial| {
            let [sum, rest] = two_sum(part, *partial);
            (part, *partial) = (sum, rest);
            rest != 0.0
        });
        partials.push(part);
    }
    if !f64::is_finite(plain) {
        return plain;
    }
    let mut sum = 0.0;
    while let Some(partial) = partials.pop() {
        let rest;
        [sum, rest] = two_sum(sum, partial);
        if rest == 0.0 {
            continue;
        }
        // Half-way between two numbers, what follows decides.
        if let Some(next) = partials.pop()
            && (rest < 0.0) == (next < 0.0)
        {
            let twice = 2.0 * rest;
            let other = sum + twice;
            if other - sum == twice {
                sum = other;
            }
        }
        break;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_leaves_out_is_kept() {
        let [sum, rest] = two_sum(1.0, 1e-20);
        assert_eq!((sum, rest), (1.0, 1e-20));
        assert_eq!(two_sum(f64::INFINITY, 1.0), [f64::INFINITY, 0.0]);
    }

    #[test]
    fn sums_are_rounded_once() {
        assert_eq!(rounded_sum([]), 0.0);
        assert_eq!(rounded_sum([1e100, 1.0, -1e100]), 1.0);
        let half = f64::EPSILON / 2.0;
        // Ties go to the even one, and what is beyond them decides, in any order.
        assert_eq!(rounded_sum([1.0, half]), 1.0);
        for parts in [[1.0, half, 1e-60], [1e-60, 1.0, half], [half, 1e-60, 1.0]] {
            assert_eq!(rounded_sum(parts), 1.0 + f64::EPSILON, "{parts:?}");
        }
        assert_eq!(rounded_sum([1.0, half, -1e-60]), 1.0);
        assert!(rounded_sum([f64::INFINITY, 1.0]).is_infinite());
    }
}
