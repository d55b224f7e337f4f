//! Integrals in f64.

/// Nodes and weights of Gauss and Legendre's rule with five points on [0, 1].
const GAUSS5: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_46, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Integral over [a, b], `pieces` equal pieces of five points.
pub fn interval(a: f64, b: f64, pieces: usize, f: impl Fn(f64) -> f64) -> f64 {
    let step = (b - a) / pieces as f64;
    (0..pieces)
        .map(|i| {
            let start = a + i as f64 * step;
            GAUSS5.iter().map(|(x, w)| w * f(start + x * step)).sum::<f64>()
        })
        .sum::<f64>()
        * step
}

/// Integral over the rectangle with lowest corner `corner`, five by five points.
pub fn rectangle(corner: [f64; 2], size: [f64; 2], f: impl Fn([f64; 2]) -> f64) -> f64 {
    interval(corner[0], corner[0] + size[0], 1, |x| {
        interval(corner[1], corner[1] + size[1], 1, |y| f([x, y]))
    })
}
