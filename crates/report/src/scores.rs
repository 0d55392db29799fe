//! Returns of different tasks on one scale, and what share of runs reaches how much of it.

use crate::groups::seed_returns;
use crate::stats::{Interval, interquartile_mean, interval, mean};
use sindyna_record::comparison::Digest;

/// The scale of one task: the random policy is 0, the anchor 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    pub(crate) task: String,
    pub(crate) zero: f64,
    pub(crate) one: f64,
    /// The method that scores 1.
    pub(crate) anchor: &'static str,
}

/// Methods a return can be measured by, the best first.
const ANCHORS: [&str; 4] = ["oracle", "truth", "expert", "hand"];

/// The scales of the tasks of which there are runs with random actions, and of an anchor that is better.
pub(crate) fn scales(digest: &Digest) -> Vec<Scale> {
    let scale = |task: &str| {
        let zero = mean(&seed_returns(digest, task, "random"))?;
        let anchored = |anchor: &'static str| {
            let one = mean(&seed_returns(digest, task, anchor)).filter(|one| *one > zero)?;
            Some(Scale { task: task.into(), zero, one, anchor })
        };
        ANCHORS.into_iter().find_map(anchored)
    };
    digest.tasks().into_iter().filter_map(scale).collect()
}

/// Scores of one method, on every task of `scales` it was used on: one stratum for each, one value for each seed. A run that came to
/// no policy scores as the random one does.
pub(crate) fn scores(digest: &Digest, scales: &[Scale], method: &str) -> Vec<Vec<f64>> {
    let of = |scale: &Scale| {
        let score = |value: f64| (value - scale.zero) / (scale.one - scale.zero);
        digest.of(&scale.task, method).map(|run| run.mean_return.map_or(0.0, score)).collect::<Vec<f64>>()
    };
    scales.iter().map(of).filter(|scores| !scores.is_empty()).collect()
}

/// Interquartile mean over tasks and seeds, with its interval.
pub(crate) fn over_tasks(strata: &[Vec<f64>]) -> Option<(f64, Option<Interval>)> {
    let borrowed: Vec<&[f64]> = strata.iter().map(Vec::as_slice).collect();
    let middle = interquartile_mean(&strata.concat())?;
    Some((middle, interval(&borrowed, |sample| interquartile_mean(&sample.concat()))))
}

/// The share of `scores` that are at least `threshold`.
pub(crate) fn share(scores: &[f64], threshold: f64) -> f64 {
    scores.iter().filter(|score| **score >= threshold).count() as f64 / scores.len().max(1) as f64
}

/// The performance profile (Dolan, Moré 2002; Agarwal et al. 2021): for every threshold at which it changes, and at `from` and `to`,
/// the share of runs that score at least so much.
pub(crate) fn profile(scores: &[f64], from: f64, to: f64) -> Vec<(f64, f64)> {
    let mut thresholds: Vec<f64> = scores.iter().copied().filter(|score| (from..to).contains(score)).collect();
    thresholds.push(to);
    thresholds.sort_by(f64::total_cmp);
    thresholds.dedup();
    let mut points = vec![(from, share(scores, from))];
    for threshold in thresholds {
        // Up to the score of a run, itself included, the share stays; after it, it falls.
        let before = share(scores, threshold);
        points.push((threshold, before));
        let after = scores.iter().filter(|score| **score > threshold).count() as f64 / scores.len().max(1) as f64;
        if after < before && threshold < to {
            points.push((threshold, after));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_record::comparison::Outcome;

    fn digest(runs: &[(&str, &str, u64, Option<f64>)]) -> Digest {
        let mut digest = Digest::default();
        for &(task, method, seed, score) in runs {
            let outcome = Outcome { returns: score.into_iter().collect(), ..Outcome::new(task, method, seed) };
            digest.add(&outcome, None);
        }
        digest
    }

    #[test]
    fn profiles_are_those_computed_by_hand() {
        let scores = [0.2, 0.5, 0.5, 1.0];
        for (threshold, expected) in
            [(0.0, 1.0), (0.2, 1.0), (0.3, 0.75), (0.5, 0.75), (0.7, 0.25), (1.0, 0.25), (1.1, 0.0)]
        {
            assert_eq!(share(&scores, threshold), expected, "at {threshold}");
        }
        let expected = [(0.0, 1.0), (0.2, 1.0), (0.2, 0.75), (0.5, 0.75), (0.5, 0.25), (1.0, 0.25)];
        assert_eq!(profile(&scores, 0.0, 1.0), expected);
        assert_eq!(profile(&[-1.0, 3.0], 0.0, 1.0), [(0.0, 0.5), (1.0, 0.5)]);
    }

    #[test]
    fn random_scores_zero_and_the_truth_one() {
        let found = digest(&[
            ("pendulum", "random", 0, Some(-1_200.0)),
            ("pendulum", "truth", 0, Some(-200.0)),
            ("pendulum", "hand", 0, Some(-100.0)),
            ("pendulum", "sac", 0, Some(-700.0)),
            ("pendulum", "sac", 1, None),
            ("cart-pole", "random", 0, Some(20.0)),
            ("cart-pole", "hand", 0, Some(500.0)),
            ("cart-pole", "sac", 0, Some(260.0)),
            ("mountain-car", "truth", 0, Some(94.0)),
            ("mountain-car", "sac", 0, Some(90.0)),
        ]);
        let scales = scales(&found);
        let named: Vec<_> = scales.iter().map(|s| (s.task.as_str(), s.anchor)).collect();
        assert_eq!(named, [("pendulum", "truth"), ("cart-pole", "hand")], "without random runs there is no zero");
        assert_eq!(scores(&found, &scales, "sac"), [vec![0.5, 0.0], vec![0.5]]);
        assert_eq!(scores(&found, &scales, "truth"), [vec![1.0]]);
        assert!(scores(&found, &scales, "lqr").is_empty());
    }

    #[test]
    fn intervals_over_tasks_draw_each_task_from_itself() {
        let (middle, found) = over_tasks(&[vec![0.0, 0.0], vec![1.0, 1.0]]).expect("there are scores");
        assert_eq!((middle, found), (0.5, Some(Interval { low: 0.5, high: 0.5 })));
        assert_eq!(over_tasks(&[]), None);
    }
}
