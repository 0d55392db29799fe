//! Learning curves: what a method's policies score after so many real steps.

use sindyna_record::comparison::{Check, Digest};

use crate::stats::{Interval, interval, mean};

/// Mean over seeds at one number of real steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) real_steps: usize,
    pub(crate) mean: f64,
    /// Of the mean; the mean itself where there are too few seeds to tell.
    pub(crate) interval: Interval,
}

/// The curve of one method on one task, at every number of real steps at which one of its seeds was looked at. A seed whose run has
/// ended keeps its last score; points begin where all have been looked at once.
pub(crate) fn curve(digest: &Digest, task: &str, method: &str) -> Vec<Point> {
    let checks: Vec<&Check> = digest.checks.iter().filter(|c| c.task == task && c.method == method).collect();
    let mut seeds: Vec<u64> = checks.iter().map(|c| c.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let mut places: Vec<usize> = checks.iter().map(|c| c.real_steps).collect();
    places.sort_unstable();
    places.dedup();
    let at = |real_steps: usize| {
        let score = |seed: &u64| {
            let mut before = checks.iter().filter(|c| c.seed == *seed && c.real_steps <= real_steps);
            before.next_back().map(|c| c.mean_return)
        };
        let scores: Vec<f64> = seeds.iter().map(score).collect::<Option<_>>()?;
        let mean_of_all = mean(&scores)?;
        let unknown = Interval { low: mean_of_all, high: mean_of_all };
        let interval = interval(&[&scores], |sample| mean(&sample[0])).unwrap_or(unknown);
        Some(Point { real_steps, mean: mean_of_all, interval })
    };
    places.into_iter().filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn digest(runs: &[&[(usize, f64)]]) -> Digest {
        let mut digest = Digest::default();
        for (seed, points) in runs.iter().enumerate() {
            digest.checks.extend(points.iter().map(|&(real_steps, mean_return)| Check {
                task: "any".into(),
                method: "sac".into(),
                seed: seed as u64,
                real_steps,
                updates: 0,
                mean_return,
            }));
        }
        digest
    }

    #[test]
    fn runs_that_ended_keep_their_last_score() {
        let both = digest(&[&[(100, 1.0), (200, 3.0)], &[(100, 0.0), (200, 1.0), (300, 5.0)]]);
        let found = curve(&both, "any", "sac");
        let means: Vec<_> = found.iter().map(|point| (point.real_steps, point.mean)).collect();
        assert_eq!(means, [(100, 0.5), (200, 2.0), (300, 4.0)]);
        // Of two values a sample has the one, the other, or both with equal probability of a quarter, a quarter and a half.
        assert_eq!(found[2].interval, Interval { low: 3.0, high: 5.0 });
        assert!(curve(&both, "any", "mbpo").is_empty());
    }

    #[test]
    fn a_curve_begins_where_every_seed_has_a_score() {
        let late = digest(&[&[(100, 1.0), (200, 3.0)], &[(200, 1.0)]]);
        let places: Vec<usize> = curve(&late, "any", "sac").iter().map(|point| point.real_steps).collect();
        assert_eq!(places, [200]);
        let single = digest(&[&[(10, 4.0)]]);
        assert_eq!(curve(&single, "any", "sac")[0].interval, Interval { low: 4.0, high: 4.0 });
    }
}
