//! Numbers of many runs: averages, quantiles, and how sure they are.
//!
//! A run that never solves its task counts with infinitely many steps, so medians and quantiles know infinity.

use rand::RngExt as _;
use serde::Serialize;
use sindyna_core::Seed;

pub use sindyna_record::comparison::mean;

/// The middle value, or the mean of the two in the middle.
#[must_use]
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(&ascending(values), 0.5)
}

/// The mean of the middle half of the values (Agarwal et al. 2021).
#[must_use]
pub fn interquartile_mean(values: &[f64]) -> Option<f64> {
    let cut = values.len() / 4;
    mean(ascending(values).get(cut..values.len() - cut)?)
}

/// The quantile of ascending values, with straight lines between them.
#[must_use]
pub fn quantile(ascending: &[f64], share: f64) -> Option<f64> {
    let place = share * (ascending.len().checked_sub(1)?) as f64;
    let (below, part) = (*ascending.get(place.floor() as usize)?, place.fract());
    let above = *ascending.get(place.ceil() as usize)?;
    // Between two infinite values there is no line to go along.
    Some(if above > below { below + (above - below) * part } else { below })
}

/// The values in ascending order.
#[must_use]
pub fn ascending(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values
}

/// Where a number lies with 95 % confidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Samples drawn for one interval.
const RESAMPLES: usize = 10_000;

/// The stratified percentile bootstrap: 95 % of what `statistic` comes to when every one of `strata` is drawn anew from
/// itself, with replacement (Efron 1979; strata as in Agarwal et al. 2021, whose library is rliable).
///
/// None if a stratum has fewer than two values, or if the statistic does not exist for a sample. The same values give the
/// same interval.
pub fn interval(strata: &[&[f64]], statistic: impl Fn(&[Vec<f64>]) -> Option<f64>) -> Option<Interval> {
    if strata.is_empty() || strata.iter().any(|stratum| stratum.len() < 2) {
        return None;
    }
    // Each stratum has draws of its own: the same values are drawn alike, whatever stands beside them.
    let mut rngs: Vec<_> = (0..strata.len() as u64).map(|i| Seed::new(0).stream("bootstrap", i)).collect();
    let mut sample: Vec<Vec<f64>> = strata.iter().map(|stratum| stratum.to_vec()).collect();
    let mut found = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        for ((drawn, stratum), rng) in sample.iter_mut().zip(strata).zip(&mut rngs) {
            for value in drawn {
                *value = stratum[rng.random_range(0..stratum.len())];
            }
        }
        found.push(statistic(&sample).filter(|value| !value.is_nan())?);
    }
    let found = ascending(&found);
    Some(Interval { low: quantile(&found, 0.025)?, high: quantile(&found, 0.975)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    const INFINITY: f64 = f64::INFINITY;

    #[test]
    fn averages_of_few_values() {
        assert_eq!(interquartile_mean(&[-1e9, 1.0, 3.0, 1e9]), Some(2.0));
        assert_eq!((interquartile_mean(&[5.0]), interquartile_mean(&[])), (Some(5.0), None));
        assert_eq!((median(&[4.0, 1.0]), median(&[])), (Some(2.5), None));
        assert_eq!(quantile(&[0.0, 10.0], 0.25), Some(2.5));
    }

    #[test]
    fn what_never_happens_is_infinitely_late() {
        assert_eq!(median(&[INFINITY, 100.0, 300.0]), Some(300.0));
        assert_eq!(median(&[INFINITY, INFINITY, 300.0]), Some(INFINITY));
        // The mean of a number and infinity is infinite.
        assert_eq!(median(&[INFINITY, 300.0]), Some(INFINITY));
    }

    #[test]
    fn intervals_are_those_of_the_binomial_distribution() {
        // The mean of ten draws from nine zeros and a one is B(10, 0.1)/10, whose quantiles at 2.5 and 97.5 % are 0 and 0.3:
        // P(0) = 0.349, P(≤ 2) = 0.930, P(≤ 3) = 0.987.
        let values = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let found = interval(&[&values], |s| mean(&s[0])).expect("ten values are enough");
        assert_eq!(found.low, 0.0);
        assert!((found.high - 0.3).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn intervals_of_a_mean_are_those_of_the_normal_distribution_for_many_values() {
        // 0 to 399: a standard deviation of 115.5, so ±1.96·115.5/√400 = ±11.3 about 199.5.
        let values: Vec<f64> = (0..400).map(f64::from).collect();
        let found = interval(&[&values], |s| mean(&s[0])).expect("enough values");
        assert!((found.low - 188.2).abs() < 1.0 && (found.high - 210.8).abs() < 1.0, "{found:?}");
        assert_eq!(interval(&[&values], |s| mean(&s[0])), Some(found), "the same values, the same interval");
    }

    #[test]
    fn strata_are_drawn_from_themselves() {
        let found = interval(&[&[1.0, 1.0], &[3.0, 3.0]], |s| Some(mean(&s[1])? / mean(&s[0])?));
        assert_eq!(found, Some(Interval { low: 3.0, high: 3.0 }));
    }

    #[test]
    fn intervals_reach_infinity_and_need_two_values() {
        let found = interval(&[&[100.0, 100.0, INFINITY]], |s| median(&s[0])).expect("three values");
        assert_eq!((found.low, found.high), (100.0, INFINITY));
        assert_eq!(interval(&[&[1.0]], |s| mean(&s[0])), None);
        assert_eq!(interval(&[&[INFINITY; 3]], |s| Some(s[0][0] / s[0][1])), None);
    }
}
