//! Numbers as a report shows them.

use super::stats::Interval;
use crate::number::significant;

/// What there is not.
pub(super) const NONE: &str = "–";

/// `value` with so many digits behind the point.
pub(crate) fn fixed(value: f64, digits: usize) -> String {
    if value.is_infinite() {
        return if value > 0.0 { "∞".into() } else { "−∞".into() };
    }
    let text = format!("{value:.digits$}");
    // What is rounded to zero has no sign.
    let bare = text.trim_start_matches('-');
    let zero = bare.chars().all(|c| matches!(c, '0' | '.'));
    grouped(if zero { bare } else { &text })
}

/// `value` with two significant digits.
pub(super) fn rough(value: f64) -> String {
    if value.abs() >= 10.0 { fixed(value, 0) } else { significant(value, 2).replace('-', "−") }
}

pub(super) fn or_none(value: Option<String>) -> String {
    value.unwrap_or_else(|| NONE.into())
}

/// `value [low, high]`, the interval as far as there is one.
pub(super) fn with_interval(value: f64, interval: Option<Interval>, shown: impl Fn(f64) -> String) -> String {
    match interval {
        Some(Interval { low, high }) => format!("{} [{}, {}]", shown(value), shown(low), shown(high)),
        None => shown(value),
    }
}

/// `count` and `what`, with an s unless there is one of it.
pub(crate) fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Thousands set apart, and a true minus.
fn grouped(text: &str) -> String {
    let (whole, rest) = text.split_once('.').map_or((text, String::new()), |(whole, rest)| (whole, format!(".{rest}")));
    let (sign, digits) = whole.strip_prefix('-').map_or(("", whole), |digits| ("−", digits));
    let mut found = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            found.push(',');
        }
        found.push(digit);
    }
    format!("{sign}{found}{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_signed() {
        for (value, digits, text) in [
            (-1234.56, 1, "−1,234.6"),
            (613_036.0, 0, "613,036"),
            (-0.04, 1, "0.0"),
            (f64::INFINITY, 0, "∞"),
            (12_345.5, 1, "12,345.5"),
        ] {
            assert_eq!(fixed(value, digits), text);
        }
        assert_eq!((rough(3.04), rough(437.6)), ("3".into(), "438".into()));
        let interval = Some(Interval { low: 1.0, high: f64::INFINITY });
        assert_eq!(with_interval(2.0, interval, |v| fixed(v, 0)), "2 [1, ∞]");
        assert_eq!((plural(1, "run"), plural(2, "run")), ("1 run".into(), "2 runs".into()));
    }
}
