//! How long frames of the window take.

use std::time::Duration;

/// Quantiles are those of the last so many frames.
const KEPT: usize = 2000;

/// See the module.
#[derive(Default)]
pub struct Frames {
    count: u64,
    worst: Duration,
    last: Vec<Duration>,
}

impl Frames {
    pub fn add(&mut self, taken: Duration) {
        let place = self.count as usize % KEPT;
        match self.last.get_mut(place) {
            Some(old) => *old = taken,
            None => self.last.push(taken),
        }
        self.count += 1;
        self.worst = self.worst.max(taken);
    }

    /// The time that a fraction of the last frames takes at most.
    fn quantile(&self, fraction: f64) -> Duration {
        let mut sorted = self.last.clone();
        sorted.sort_unstable();
        let place = (fraction * sorted.len().saturating_sub(1) as f64).round() as usize;
        sorted.get(place).copied().unwrap_or_default()
    }

    /// One line, for the panel and for the terminal.
    pub fn summary(&self) -> String {
        let ms = |time: Duration| 1e3 * time.as_secs_f64();
        format!(
            "{} frames: median {:.1} ms, 99 % within {:.1} ms, longest {:.1} ms",
            self.count,
            ms(self.quantile(0.5)),
            ms(self.quantile(0.99)),
            ms(self.worst)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_last_frames() {
        let mut frames = Frames::default();
        (1..=100).for_each(|ms| frames.add(Duration::from_millis(ms)));
        assert_eq!(frames.summary(), "100 frames: median 51.0 ms, 99 % within 99.0 ms, longest 100.0 ms");
        (0..KEPT).for_each(|_| frames.add(Duration::from_millis(7)));
        assert_eq!(frames.summary(), "2100 frames: median 7.0 ms, 99 % within 7.0 ms, longest 100.0 ms");
    }
}
