//! Numbers as a report shows them.

pub(crate) use sindyna_core::number::{fixed, plural, significant};

use sindyna_record::identification::Quality;

use crate::stats::Interval;

/// What there is not.
pub(crate) const NONE: &str = "–";

/// `value` with two significant digits.
pub(crate) fn rough(value: f64) -> String {
    if value.abs() >= 10.0 { fixed(value, 0) } else { significant(value, 2) }
}

/// RMSE, R² and fit percent of predictions.
pub(crate) fn measures(quality: Option<&Quality>) -> [String; 3] {
    let part = |of: &dyn Fn(&Quality) -> Option<String>| or_none(quality.and_then(of));
    [
        part(&|q| Some(significant(q.rmse, 3))),
        part(&|q| q.r2.map(|r2| short(r2, 4))),
        part(&|q| q.fit_percent.map(|fit| short(fit, 1))),
    ]
}

/// `value` with `decimals`, or where it would fill a line with two significant digits.
fn short(value: f64, decimals: usize) -> String {
    /// Magnitude up to which decimals are shown.
    const LARGE: f64 = 1e5;
    if value.abs() < LARGE { fixed(value, decimals) } else { significant(value, 2) }
}

pub(crate) fn or_none(value: Option<String>) -> String {
    value.unwrap_or_else(|| NONE.into())
}

/// `value [low, high]`, the interval as far as there is one.
pub(crate) fn with_interval(value: f64, interval: Option<Interval>, shown: impl Fn(f64) -> String) -> String {
    match interval {
        Some(Interval { low, high }) => format!("{} [{}, {}]", shown(value), shown(low), shown(high)),
        None => shown(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_leaves_its_data_has_short_numbers() {
        let far = Quality { samples: 9, rmse: 1e36, r2: Some(-3.2e71), fit_percent: Some(-5e37) };
        assert_eq!(measures(Some(&far)), ["1e36", "\u{2212}3.2e71", "\u{2212}5e37"]);
    }

    #[test]
    fn intervals_stand_behind_their_value() {
        assert_eq!((rough(3.04), rough(437.6)), ("3".into(), "438".into()));
        let interval = Some(Interval { low: 1.0, high: f64::INFINITY });
        assert_eq!(with_interval(2.0, interval, |v| fixed(v, 0)), "2 [1, ∞]");
    }
}
