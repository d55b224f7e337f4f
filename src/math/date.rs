//! Days to dates.

/// Year, month and day, `days` after 1970-01-01 in the Gregorian calendar: Hinnant, chrono-Compatible Low-Level Date
/// Algorithms, 2013, `civil_from_days`.
pub fn date(days: u64) -> [u64; 3] {
    // Years begin in March, so that the leap day is their last; eras of 400 years have 146097 days.
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    [400 * era + year + u64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use super::date;

    /// Expected values: `date -u -d @SECONDS`.
    #[test]
    fn dates_match_the_system_s() {
        for (days, expected) in [
            (0, [1970, 1, 1]),
            (58, [1970, 2, 28]),
            (59, [1970, 3, 1]),
            (11_016, [2000, 2, 29]),
            (11_017, [2000, 3, 1]),
            (19_722, [2023, 12, 31]),
            (19_723, [2024, 1, 1]),
            (47_540, [2100, 2, 28]),
            (47_541, [2100, 3, 1]),
        ] {
            assert_eq!(date(days), expected, "day {days}");
        }
    }
}
