//! Numbers of result files and of pages.

use serde::{Deserialize, Serialize};
use sindyna_core::number::{fixed, significant};
use sindyna_report::stats;

/// Three digits are enough for a result file; none of what is not finite.
#[must_use]
pub fn rounded(value: f64) -> Option<f64> {
    format!("{value:.2e}").parse().ok().filter(|v: &f64| v.is_finite())
}

/// The median of numbers that may be missing, which are infinitely large; none of nothing.
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    stats::median(&values.into_iter().collect::<Vec<_>>())
}

/// A number as a table shows it: two digits, all digits before the point.
#[must_use]
pub fn short(value: Option<f64>) -> String {
    value.map_or_else(|| "—".into(), |v| if (10.0..1e6).contains(&v.abs()) { fixed(v, 0) } else { significant(v, 2) })
}

/// A return as a table shows it.
#[must_use]
pub fn plain(value: Option<f64>) -> String {
    value.map_or_else(|| "—".into(), |v| fixed(v, 1))
}

/// Of figures that were measured several times, four digits each; none where infinite.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The middle one.
    pub median: Option<f64>,
    /// The least.
    pub least: Option<f64>,
    /// The largest.
    pub largest: Option<f64>,
    /// How many there are.
    #[serde(default)]
    pub repeats: usize,
}

impl Spread {
    /// Of these.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let four = |value: f64| format!("{value:.3e}").parse().ok().filter(|v: &f64| v.is_finite());
        Self {
            median: stats::median(values).and_then(four),
            least: values.iter().copied().min_by(f64::total_cmp).and_then(four),
            largest: values.iter().copied().max_by(f64::total_cmp).and_then(four),
            repeats: values.len(),
        }
    }

    /// Median (least–largest), so many digits each.
    #[must_use]
    pub fn shown(&self, digits: usize) -> String {
        let one = |value: Option<f64>| value.map_or_else(|| "∞".into(), |v| figure(v, digits));
        format!("{} ({}–{})", one(self.median), one(self.least), one(self.largest))
    }
}

/// A measured number with so many digits, and all of them before the point.
#[must_use]
pub(super) fn figure(value: f64, digits: usize) -> String {
    if value.abs() >= 10_f64.powi(digits as i32) { fixed(value, 0) } else { significant(value, digits) }
}

/// A share as a level of noise: `0.1 %`, `none`.
#[must_use]
pub fn percent(value: f64) -> String {
    if value == 0.0 { "none".into() } else { format!("{} %", significant(100.0 * value, 6)) }
}

/// A share in whole percent; all and nothing are said only of all and nothing.
#[must_use]
pub fn share(part: usize, of: usize) -> String {
    let percent = 100.0 * part as f64 / of.max(1) as f64;
    let digits = usize::from(part > 0 && part < of && !(0.5..99.5).contains(&percent));
    format!("{percent:.digits$} %")
}

/// How many of `rows` there are for which `holds`.
pub fn count<'a, T: 'a>(rows: impl IntoIterator<Item = &'a T>, holds: impl Fn(&T) -> bool) -> usize {
    rows.into_iter().filter(|row| holds(row)).count()
}

/// Groups of the rows by a number, from the least.
pub fn by<T>(rows: &[T], number: impl Fn(&T) -> f64) -> Vec<(f64, Vec<&T>)> {
    let mut found: Vec<(f64, Vec<&T>)> = Vec::new();
    for row in rows {
        let level = number(row);
        match found.iter_mut().find(|(of, _)| of.total_cmp(&level).is_eq()) {
            Some((_, group)) => group.push(row),
            None => found.push((level, vec![row])),
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// A count with thousands set apart.
#[must_use]
pub fn many(value: usize) -> String {
    fixed(value as f64, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_what_a_reader_needs() {
        assert_eq!(rounded(0.000_123_456), Some(0.000_123));
        assert_eq!((rounded(f64::INFINITY), rounded(f64::NAN)), (None, None));
        let shown = [Some(100.4), Some(9.64), Some(1720.0), Some(4.17e-11), Some(-0.02), Some(0.0), None].map(short);
        assert_eq!(shown, ["100", "9.6", "1,720", "4.2e−11", "−0.02", "0", "—"]);
        assert_eq!((percent(0.001), percent(0.0), share(98, 100)), ("0.1 %".into(), "none".into(), "98 %".into()));
        assert_eq!((share(239, 240), share(240, 240), share(0, 3)), ("99.6 %".into(), "100 %".into(), "0 %".into()));
    }
}
