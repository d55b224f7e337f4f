//! Honest statistics: p-values, multiple tests, means with standard errors.

/// Probability of a false alarm that a whole family of tests may have.
pub const FAMILY_ALPHA: f64 = 1e-4;

/// The level for each of `count` tests such that the family stays at `family_alpha` (Sidak).
pub fn sidak(family_alpha: f64, count: usize) -> f64 {
    -(f64::ln_1p(-family_alpha) / count as f64).exp_m1()
}

/// ln Gamma(x), x > 0: Lanczos' approximation, g = 7, nine terms; relative error below 1e-14.
pub fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let sum = C[0] + (1..9).map(|i| C[i] / (x + i as f64)).sum::<f64>();
    let t = x + 7.5;
    0.5 * (2.0 * std::f64::consts::PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Regularised upper incomplete gamma function Q(a, x): series below a + 1, Lentz' continued fraction above.
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-17 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (1.0 - front * sum).clamp(0.0, 1.0);
    }
    let tiny = f64::MIN_POSITIVE;
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1.0 / tiny, 1.0 / b);
    let mut h = d;
    for i in 1..100_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = an * d + b;
        d = if d == 0.0 { tiny } else { d };
        c = b + an / c;
        c = if c == 0.0 { tiny } else { c };
        d = 1.0 / d;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// Probability that a chi-square variable exceeds `statistic`.
pub fn chi_square_survival(statistic: f64, degrees: f64) -> f64 {
    gamma_q(0.5 * degrees, 0.5 * statistic)
}

/// Probability that a standard normal variable is further from 0 than z.
pub fn normal_two_sided(z: f64) -> f64 {
    gamma_q(0.5, 0.5 * z * z)
}

/// Probability that a Student variable is further from 0 than t, from the incomplete beta function.
pub fn student_two_sided(t: f64, degrees: f64) -> f64 {
    incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t))
}

/// Regularised incomplete beta function I_x(a, b), by its continued fraction.
fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p()).exp() / a;
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut h = d;
    for m in 1..10_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for numerator in [even, odd] {
            d = 1.0 / (1.0 + numerator * d);
            c = 1.0 + numerator / c;
            change = d * c;
            h *= change;
        }
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// Pearson's test of counts against expectations that sum to the same total. Cells that expect fewer than five are
/// pooled. Returns the p-value; 0 where something fell into a cell that expects nothing.
pub fn chi_square_p(observed: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len());
    if observed.iter().zip(expected).any(|(&o, &e)| o > 0 && e <= 0.0) {
        return 0.0;
    }
    let (mut statistic, mut cells) = (0.0, 0);
    let (mut pooled_observed, mut pooled_expected) = (0, 0.0);
    let mut add = |o: u64, e: f64| {
        statistic += (o as f64 - e).powi(2) / e;
        cells += 1;
    };
    for (&o, &e) in observed.iter().zip(expected) {
        if e >= 5.0 {
            add(o, e);
        } else {
            pooled_observed += o;
            pooled_expected += e;
        }
        if pooled_expected >= 5.0 {
            add(pooled_observed, pooled_expected);
            (pooled_observed, pooled_expected) = (0, 0.0);
        }
    }
    if pooled_expected > 0.0 {
        add(pooled_observed, pooled_expected);
    }
    assert!(cells > 1, "a chi-square test needs two cells that expect five each");
    chi_square_survival(statistic, f64::from(cells - 1))
}

/// Mean and variance of a stream of numbers (Welford).
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    pub count: u64,
    pub mean: f64,
    sum_of_sq: f64,
}

impl Moments {
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.sum_of_sq += delta * (x - self.mean);
    }

    /// The moments of both streams together (Chan et al.).
    pub fn merge(self, other: Self) -> Self {
        if self.count == 0 || other.count == 0 {
            return if self.count == 0 { other } else { self };
        }
        let count = self.count + other.count;
        let delta = other.mean - self.mean;
        let (n, m) = (self.count as f64, other.count as f64);
        Self {
            count,
            mean: self.mean + delta * m / count as f64,
            sum_of_sq: self.sum_of_sq + other.sum_of_sq + delta * delta * n * m / count as f64,
        }
    }

    /// Unbiased sample variance.
    pub fn variance(&self) -> f64 {
        self.sum_of_sq / (self.count - 1) as f64
    }

    /// Standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }

    /// Asserts that the mean is `expected` within five standard errors, and that the standard error is at most
    /// `max_relative_error` of it: a test that cannot see a fault must not pass. Values that hardly vary are allowed
    /// 1e-9 of rounding.
    #[track_caller]
    pub fn assert_mean(&self, what: &str, expected: f64, max_relative_error: f64) {
        let error = self.standard_error();
        assert!(
            error <= max_relative_error * expected.abs(),
            "{what}: standard error {error:e} is too large to judge {expected:e}"
        );
        let tolerance = 5.0 * error + 1e-9 * expected.abs();
        assert!(
            (self.mean - expected).abs() <= tolerance,
            "{what}: mean {:.9e} +- {error:.1e} instead of {expected:.9e}",
            self.mean
        );
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        values.into_iter().for_each(|x| moments.push(x));
        moments
    }
}

/// Two-sided p-value of equal means (Welch). Two constant streams are equal only where their means are.
pub fn welch_p(a: &Moments, b: &Moments) -> f64 {
    let (va, vb) = (a.variance() / a.count as f64, b.variance() / b.count as f64);
    if va + vb == 0.0 {
        return if a.mean == b.mean { 1.0 } else { 0.0 };
    }
    let t = (a.mean - b.mean) / (va + vb).sqrt();
    let degrees = (va + vb).powi(2) / (va * va / (a.count - 1) as f64 + vb * vb / (b.count - 1) as f64);
    student_two_sided(t, degrees)
}

/// Mean grey values of the tiles of a picture, `edge` pixels wide and high (fewer at the borders), row by row.
pub fn tile_means(pixels: &[glam::DVec3], [width, height]: [u32; 2], edge: u32) -> Vec<f64> {
    let columns = width.div_ceil(edge);
    let mut tiles = vec![Moments::default(); (columns * height.div_ceil(edge)) as usize];
    for (index, pixel) in (0..).zip(pixels) {
        let tile = index / width / edge * columns + index % width / edge;
        tiles[tile as usize].push(pixel.element_sum() / 3.0);
    }
    tiles.iter().map(|tile| tile.mean).collect()
}

/// Asserts that two families of independently seeded values (renders x tiles) have equal means tile by tile, by
/// Welch's test at [`FAMILY_ALPHA`] over all tiles.
#[track_caller]
pub fn assert_equal_tiles(what: &str, a: &[Vec<f64>], b: &[Vec<f64>]) {
    let tiles = a[0].len();
    let level = sidak(FAMILY_ALPHA, tiles);
    for tile in 0..tiles {
        let ma: Moments = a.iter().map(|run| run[tile]).collect();
        let mb: Moments = b.iter().map(|run| run[tile]).collect();
        let p = welch_p(&ma, &mb);
        assert!(
            p > level,
            "{what}: tile {tile}: {:e} against {:e}, p = {p:e} (level {level:e})",
            ma.mean,
            mb.mean
        );
    }
}

/// Counts of `n` samples on a grid of the unit square against the integral of a density over its cells.
///
/// `sample` gives a point of the unit square or `None` where it has no sample (a rejected one); `density` is with
/// respect to the square's own area. The expectation that is left over is that of rejected samples.
/// Returns the p-value.
pub fn grid_chi_square(
    [rows, columns]: [usize; 2],
    n: u64,
    mut sample: impl FnMut() -> Option<[f64; 2]>,
    density: impl Fn([f64; 2]) -> f64,
) -> f64 {
    let mut observed = vec![0u64; rows * columns + 1];
    for _ in 0..n {
        let cell = sample().map_or(rows * columns, |[x, y]| {
            assert!((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y), "({x}, {y}) left the square");
            let row = ((x * rows as f64) as usize).min(rows - 1);
            row * columns + ((y * columns as f64) as usize).min(columns - 1)
        });
        observed[cell] += 1;
    }
    let [height, width] = [1.0 / rows as f64, 1.0 / columns as f64];
    let mut expected: Vec<f64> = (0..rows * columns)
        .map(|cell| {
            let corner = [(cell / columns) as f64 * height, (cell % columns) as f64 * width];
            // Wide cells in pieces: a lobe may be much narrower than they are.
            let (rows, columns) = (100usize.div_ceil(rows), 200usize.div_ceil(columns));
            let piece = [height / rows as f64, width / columns as f64];
            let integral: f64 = (0..rows * columns)
                .map(|i| {
                    let (row, column) = ((i / columns) as f64, (i % columns) as f64);
                    let corner = [corner[0] + row * piece[0], corner[1] + column * piece[1]];
                    crate::quadrature::rectangle(corner, piece, &density)
                })
                .sum();
            n as f64 * integral
        })
        .collect();
    let rejected = n as f64 - expected.iter().sum::<f64>();
    // What quadrature itself leaves over is not an expectation.
    expected.push(if rejected > 1e-6 * n as f64 { rejected } else { 0.0 });
    chi_square_p(&observed, &expected)
}

/// [`grid_chi_square`] for directions: rows are equal steps of z over the whole sphere, columns of the azimuth.
pub fn direction_chi_square(
    grid: [usize; 2],
    n: u64,
    mut sample: impl FnMut() -> Option<glam::DVec3>,
    pdf_solid: impl Fn(glam::DVec3) -> f64,
) -> f64 {
    use std::f64::consts::{PI, TAU};
    let to_square =
        |d: glam::DVec3| [(0.5 * (d.z + 1.0)).clamp(0.0, 1.0), (d.y.atan2(d.x) / TAU).rem_euclid(1.0)];
    grid_chi_square(
        grid,
        n,
        || sample().map(to_square),
        |[x, y]| {
            let z = 2.0 * x - 1.0;
            let r = (1.0 - z * z).sqrt();
            let (sin, cos) = (TAU * y).sin_cos();
            4.0 * PI * pdf_solid(glam::DVec3::new(r * cos, r * sin, z))
        },
    )
}

#[test]
fn statistics_match_tables() {
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a:e} is not {b:e}");
    close(ln_gamma(0.5), 0.572_364_942_924_700_1);
    close(ln_gamma(10.5), 13.940_625_219_403_763);
    // Tables of the chi-square, normal and Student distributions.
    close(chi_square_survival(3.841_458_820_694_124, 1.0), 0.05);
    // An even number of degrees: a Poisson variable of mean x / 2 below degrees / 2.
    for x in [150.0f64, 200.0, 300.0] {
        let poisson: f64 = (0..100)
            .map(|k| (f64::from(k) * (0.5 * x).ln() - 0.5 * x - ln_gamma(f64::from(k) + 1.0)).exp())
            .sum();
        close(chi_square_survival(x, 200.0), poisson);
    }
    close(normal_two_sided(5.0), 5.733_031_437_583_875e-7);
    close(student_two_sided(2.131_449_545_559_323_4, 15.0), 0.05);
    close(student_two_sided(12.706_204_736_432_095, 1.0), 0.05);
    close(sidak(1e-4, 1), 1e-4);
    close(1.0 - (1.0 - sidak(0.05, 20)).powi(20), 0.05);
}
