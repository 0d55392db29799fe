//! Time stamps that are dates.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// Nanoseconds since 1970 of the date that `cell` writes as ISO 8601 does, such as `2026-03-01T12:00:00.5Z` or `2026-03-01 12:00:00`; in UTC where it has no offset. `None`
/// if it is a number, or no date between 1678 and 2262.
pub(crate) fn nanoseconds(cell: &str) -> Option<i64> {
    if cell.parse::<f64>().is_ok() {
        return None;
    }
    let at = |date: DateTime| TimeZone::UTC.to_timestamp(date).ok();
    let stamp = cell.parse::<Timestamp>().ok().or_else(|| cell.parse::<DateTime>().ok().and_then(at))?;
    i64::try_from(stamp.as_nanosecond()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_told_from_numbers_and_words() {
        for (cell, since) in [
            ("1970-01-01T00:00:01Z", Some(1_000_000_000)),
            ("1970-01-01 00:00:00.25", Some(250_000_000)),
            ("1970-01-01T01:00:00+01:00", Some(0)),
            ("1970-01-02", Some(86_400_000_000_000)),
            ("2026-03-01T12:00:00.100Z", Some(1_772_366_400_100_000_000)),
            ("12:00:00", None),
            ("20.5", None),
            ("20260301", None),
            ("2026-13-01", None),
            ("auto", None),
            ("", None),
        ] {
            assert_eq!(nanoseconds(cell), since, "{cell}");
        }
    }
}
