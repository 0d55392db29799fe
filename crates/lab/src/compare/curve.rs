//! Learning curves: what a method's policies score after so many real steps.

use super::Outcome;
use super::outcome::mean;

/// Median and quartiles over seeds at one number of real steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quartiles {
    pub(crate) real_steps: usize,
    pub(crate) low: f64,
    pub(crate) middle: f64,
    pub(crate) high: f64,
}

/// The curve of all `runs` of one method on one task, at every number of real steps at which one of them was looked at. A run
/// that has ended keeps its last score.
pub(crate) fn curve(runs: &[&Outcome]) -> Vec<Quartiles> {
    let mut places: Vec<usize> = runs.iter().flat_map(|run| run.curve.iter().map(|p| p.real_steps)).collect();
    places.sort_unstable();
    places.dedup();
    let at = |real_steps: usize| {
        let score =
            |run: &&Outcome| run.curve.iter().rev().find(|p| p.real_steps <= real_steps).map(|p| mean(&p.returns));
        let mut scores: Vec<f64> = runs.iter().filter_map(score).collect();
        scores.sort_by(f64::total_cmp);
        Some(Quartiles {
            real_steps,
            low: quantile(&scores, 0.25)?,
            middle: quantile(&scores, 0.5)?,
            high: quantile(&scores, 0.75)?,
        })
    };
    places.into_iter().filter_map(at).collect()
}

/// The quantile of ascending values, with straight lines between them.
fn quantile(ascending: &[f64], share: f64) -> Option<f64> {
    let place = share * (ascending.len().checked_sub(1)?) as f64;
    let (below, part) = (place.floor() as usize, place.fract());
    let above = ascending.get(below + 1).unwrap_or(ascending.last()?);
    Some(ascending.get(below)? * (1.0 - part) + above * part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::outcome::Point;

    #[test]
    fn runs_that_ended_keep_their_last_score() {
        let run = |points: &[(usize, f64)]| Outcome {
            curve: points.iter().map(|(s, r)| Point { real_steps: *s, updates: 0, returns: vec![*r; 2] }).collect(),
            ..Outcome::new("any", "sac", 0)
        };
        let (short, long) = (run(&[(100, 1.0), (200, 3.0)]), run(&[(100, 0.0), (200, 1.0), (300, 5.0)]));
        let curve = curve(&[&short, &long]);
        let middles: Vec<_> = curve.iter().map(|q| (q.real_steps, q.middle)).collect();
        assert_eq!(middles, [(100, 0.5), (200, 2.0), (300, 4.0)]);
        assert_eq!((curve[2].low, curve[2].high), (3.5, 4.5));
        assert_eq!(quantile(&[], 0.5), None);
    }
}
