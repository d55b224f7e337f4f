//! Figures from repeated measurements, with their confidence. None of these takes an empty list.

use super::rng::{RandomKey, random4};

/// Resamples of a bootstrap.
const RESAMPLES: u32 = 10_000;

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Of positive values.
pub fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// Of the mean, from how the values scatter; `None` for a single one.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    let (count, mean) = (values.len() as f64, mean(values));
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (count - 1.0) / count).sqrt())
}

/// The middle value, of an even number the mean of the two in the middle.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.len().is_multiple_of(2) { 0.5 * (sorted[middle - 1] + sorted[middle]) } else { sorted[middle] }
}

/// The interval that holds the median of what the values are drawn from with 95 % confidence: percentiles of the
/// medians of resamples (Efron, Bootstrap Methods: Another Look at the Jackknife, Annals of Statistics 7, 1979).
/// The same values in the same order give the same interval. `None` for a single value.
pub fn median_interval(values: &[f64]) -> Option<[f64; 2]> {
    if values.len() < 2 {
        return None;
    }
    let mut medians: Vec<f64> = (0..RESAMPLES)
        .map(|resample| {
            let drawn: Vec<f64> = (0..values.len() as u32)
                .map(|draw| {
                    let word = random4(RandomKey { pixel: resample, sample: draw, seed: 0 }, 0).x;
                    values[((u64::from(word) * values.len() as u64) >> 32) as usize]
                })
                .collect();
            median(&drawn)
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    let cut = medians.len() / 40;
    Some([medians[cut], medians[medians.len() - 1 - cut]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_and_medians_of_small_lists() {
        assert_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
        let mean = geometric_mean(&[1.0, 4.0, 16.0]);
        assert!((mean - 4.0).abs() < 1e-14, "{mean}");
        assert_eq!(median(&[6.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[6.0, 1.0, 2.0, 4.0]), 3.0);
        // Deviations -2, -1, 3: variance 7, of the mean 7/3.
        let error = standard_error(&[1.0, 2.0, 6.0]).expect("three values");
        assert!((error - (7.0f64 / 3.0).sqrt()).abs() < 1e-15, "{error}");
        assert_eq!(standard_error(&[5.0]), None);
        assert_eq!(median_interval(&[5.0]), None);
        assert_eq!(median_interval(&[5.0, 5.0, 5.0]), Some([5.0, 5.0]));
    }

    /// Nine different values: the percentiles of the resamples' medians are known. Their median is at most the k-th
    /// smallest value with the probability that a binomial of 9 draws with p = k/9 is at least 5: 0.0014 and
    /// 0.0304 for k = 1, 2, so the 2.5 % percentile is the second value, and by symmetry the eighth the other.
    #[test]
    fn the_bootstrap_of_a_median_matches_its_exact_distribution() {
        let values = [4.0, 9.0, 1.0, 7.0, 3.0, 8.0, 2.0, 6.0, 5.0];
        let interval = median_interval(&values);
        assert_eq!(interval, Some([2.0, 8.0]));
        assert_eq!(median_interval(&values), interval, "the same again");
        // The units do not matter.
        assert_eq!(median_interval(&values.map(|value| 1e-6 * value)), Some([1e-6 * 2.0, 1e-6 * 8.0]));
    }

    /// The interval of medians of uniform numbers holds one half about as often as it claims. The bootstrap of a few
    /// values is known to be a little short of 95 %.
    #[test]
    fn the_bootstrap_covers_what_it_promises() {
        let (lists, count) = (100u32, 15u32);
        let holds = |list: &u32| {
            let number = |draw| f64::from(random4(RandomKey { pixel: *list, sample: draw, seed: 1 }, 7).y);
            let values: Vec<f64> = (0..count).map(|draw| number(draw) / 2f64.powi(32)).collect();
            median_interval(&values).is_some_and(|[low, high]| low <= 0.5 && 0.5 <= high)
        };
        let held = (0..lists).filter(holds).count();
        assert!((88..=99).contains(&held), "{held} of {lists}");
    }
}
