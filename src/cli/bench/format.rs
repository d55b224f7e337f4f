//! Figures as the tables of pages have them, and the tables.

use crate::bench::trade::Estimate;
use crate::cli::bench::runs::CandidateResult;
use crate::cli::text::{grouped, short};

/// A table in Markdown; columns after the first `left` are numbers.
pub fn table(heads: &[String], left: usize, rows: &[Vec<String>]) -> String {
    let rule = |column: usize| if column < left { "---" } else { "--:" };
    let rules: Vec<&str> = (0..heads.len()).map(rule).collect();
    let rows: String = rows.iter().map(|row| format!("| {} |\n", row.join(" | "))).collect();
    format!("| {} |\n|{}|\n{rows}", heads.join(" | "), rules.join("|"))
}

/// 0.05 is 5.00 %.
pub fn percent(value: f64) -> String {
    format!("{} %", short(100.0 * value))
}

/// A share as it was asked for: 0.12 is 12 %.
pub fn level(value: f64) -> String {
    format!("{} %", (1e6 * value).round() / 1e4)
}

pub fn seconds(value: f64) -> String {
    // Minutes where a tenth of one is exact.
    if value >= 120.0 && value % 6.0 == 0.0 { format!("{} min", value / 60.0) } else { format!("{value} s") }
}

pub fn tilde(estimate: &Estimate) -> &'static str {
    if estimate.extrapolated { "~" } else { "" }
}

pub fn share(estimate: &Estimate) -> String {
    format!("{}{}", tilde(estimate), percent(estimate.value))
}

pub fn share_spread(estimate: &Estimate) -> String {
    let interval = estimate
        .interval
        .map_or(String::new(), |[low, high]| format!(" ({} to {})", short(100.0 * low), short(100.0 * high)));
    share(estimate) + &interval
}

/// A value with its interval; what was not met is infinite.
pub fn spread(estimate: &Estimate) -> String {
    if estimate.value.is_infinite() {
        return "not met".into();
    }
    let bound = |value: f64| if value.is_finite() { short(value) } else { "never".into() };
    let interval = estimate
        .interval
        .map_or(String::new(), |[low, high]| format!(" ({} to {})", bound(low), bound(high)));
    format!("{}{}{interval}", tilde(estimate), short(estimate.value))
}

/// When an error is met, and by how many where not by all.
pub fn met(one: &CandidateResult) -> String {
    let target = &one.summary.target;
    let seconds = spread(&target.seconds);
    match target.met {
        0 => seconds,
        met if met == one.runs.len() => seconds,
        met => format!("{seconds}, {met} of {}", one.runs.len()),
    }
}

pub fn count(estimate: &Estimate) -> String {
    if estimate.value.is_infinite() {
        return "-".into();
    }
    format!("{}{}", tilde(estimate), grouped(estimate.value))
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn times_are_short() {
        let texts = [1.5, 60.0, 120.0, 150.0, 400.0].map(seconds);
        assert_eq!(texts, ["1.5 s", "60 s", "2 min", "2.5 min", "400 s"]);
    }
}
