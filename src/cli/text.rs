//! Numbers and dates as people read them.

use std::time::SystemTime;

use crate::bench::efficiency::Ratio;
use crate::math::date::date;

/// Three significant digits.
pub fn short(value: f64) -> String {
    match value.abs() {
        size if (1e-4..1000.0).contains(&size) => {
            let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
            format!("{value:.decimals$}")
        }
        size if (1000.0..1e9).contains(&size) => grouped(value),
        0.0 => "0".into(),
        _ => format!("{value:.2e}"),
    }
}

/// A whole number with a comma at every thousand.
pub fn grouped(value: f64) -> String {
    let digits = format!("{value:.0}");
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) && !text.ends_with('-') {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A ratio with its interval.
pub fn ratio(ratio: Option<Ratio>) -> String {
    match ratio.map(|ratio| (ratio.median, ratio.interval)) {
        Some((median, Some([low, high]))) if [low, high] != [median; 2] => {
            format!("{} ({} to {})", short(median), short(low), short(high))
        }
        Some((median, _)) => short(median),
        None => "-".into(),
    }
}

/// In UTC.
pub fn today() -> String {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let [year, month, day] = date(since.as_secs() / 86_400);
    format!("{year:04}-{month:02}-{day:02}")
}

/// As it was given, but for where the program lies.
pub fn command_line() -> String {
    format!("halfway {}", words().join(" "))
}

/// What was given, without the program. What is no Unicode has a replacement in it.
pub fn words() -> Vec<String> {
    std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_the_table() {
        assert_eq!(
            [0.0, 0.001_234_5, 0.999, 1.0, 12.345, 999.0, 12345.6, 1.5e-7, 2e12, f64::NAN].map(short),
            ["0", "0.00123", "0.999", "1.00", "12.3", "999", "12,346", "1.50e-7", "2.00e12", "NaN"]
        );
        assert_eq!(
            [0.0, 999.0, 1000.0, -123_456.0, -1_234_567.0].map(grouped),
            ["0", "999", "1,000", "-123,456", "-1,234,567"]
        );
    }
}
