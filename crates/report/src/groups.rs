//! What a comparison comes to, in numbers: a group for each task and method.

use serde::Serialize;
use sindyna_record::comparison::{Digest, Run};

use crate::Catalog;
use crate::stats::{Interval, interquartile_mean, interval, mean, median};

/// All seeds of one method on one task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Number of runs.
    pub runs: usize,
    /// Runs that solved the task.
    pub solved: usize,
    /// Real steps at the end, the largest number of any seed.
    pub real_steps: usize,
    /// Real steps until solved; none for methods of which real steps say nothing.
    pub steps: Option<Steps>,
    /// Returns at the end, of the runs that came to an evaluation.
    pub returns: Option<Returns>,
    /// Median number of gradient updates.
    pub updates_median: Option<f64>,
    /// Median number of simulated steps in the model.
    pub model_steps_median: Option<f64>,
    /// Median number of parameters of the model.
    pub parameters_median: Option<f64>,
    /// Runs that came to nothing or stopped short.
    pub failures: usize,
}

/// Real steps until solved. Runs that never solve the task count as infinite, which JSON writes as null.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Steps {
    /// Median over seeds.
    pub median: f64,
    /// 95 % bootstrap interval.
    pub interval: Option<Interval>,
    /// Least and most of those that solved it.
    pub range: Option<(usize, usize)>,
    /// Real steps before which nothing can be solved: those of the first check of a policy that has learned something.
    pub first_check: Option<usize>,
    /// Median over the median of `sindy`.
    pub over_sindy: Option<Ratio>,
}

/// A ratio of medians.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ratio {
    /// The estimate.
    pub value: f64,
    /// Both medians are drawn anew.
    pub interval: Option<Interval>,
    /// What the ratio is at least, where it is infinite: runs that did not solve the task count as if they had done so when the
    /// budget was spent.
    pub at_least: Option<f64>,
}

/// Mean returns of seeds, each over the start states of the last evaluation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Returns {
    /// Mean over seeds.
    pub mean: f64,
    /// None where a run came to no policy.
    pub lowest: Option<f64>,
    /// Interquartile mean over seeds.
    pub interquartile_mean: f64,
    /// 95 % bootstrap interval.
    pub interval: Option<Interval>,
    /// How much more the seeds have than those of `sindy`.
    pub beside_sindy: Option<Difference>,
}

/// The interquartile mean of differences, each of two runs of the same seed, which begin at the same start states.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The estimate.
    pub value: f64,
    /// 95 % bootstrap interval.
    pub interval: Option<Interval>,
}

/// One group for each task and method there are runs of.
pub(crate) fn groups(digest: &Digest, catalog: &dyn Catalog) -> Vec<Group> {
    let methods = digest.methods();
    let pairs = digest.tasks().into_iter().flat_map(|task| methods.iter().map(move |method| (task, *method)));
    pairs
        .filter(|(task, method)| digest.of(task, method).next().is_some())
        .map(|(t, m)| group(digest, catalog, t, m))
        .collect()
}

fn group(digest: &Digest, catalog: &dyn Catalog, task: &str, method: &str) -> Group {
    let runs = || digest.of(task, method);
    let numbers = |of: &dyn Fn(&Run) -> Option<f64>| runs().filter_map(of).collect::<Vec<f64>>();
    Group {
        task: task.into(),
        method: method.into(),
        runs: runs().count(),
        solved: runs().filter(|run| run.solved_after.is_some()).count(),
        real_steps: runs().map(|run| run.real_steps).max().unwrap_or(0),
        steps: if catalog.is_reference(method) { None } else { steps(digest, catalog, task, method) },
        returns: returns(digest, task, method),
        updates_median: median(&numbers(&|run| Some(run.updates as f64))),
        model_steps_median: median(&numbers(&|run| Some(run.model_steps as f64))),
        parameters_median: median(&numbers(&|run| run.parameters.map(|count| count as f64))),
        failures: runs().filter(|run| run.failure.is_some()).count(),
    }
}

/// Real steps until solved, infinite for runs that never do.
fn until_solved(digest: &Digest, task: &str, method: &str) -> Vec<f64> {
    digest.of(task, method).map(|run| run.solved_after.map_or(f64::INFINITY, |steps| steps as f64)).collect()
}

fn steps(digest: &Digest, catalog: &dyn Catalog, task: &str, method: &str) -> Option<Steps> {
    let until = until_solved(digest, task, method);
    let solved = || digest.of(task, method).filter_map(|run| run.solved_after);
    Some(Steps {
        median: median(&until)?,
        interval: interval(&[&until], |sample| median(&sample[0])),
        range: solved().min().zip(solved().max()),
        first_check: catalog.first_check(method, task),
        over_sindy: ratio(digest, catalog, task, method),
    })
}

fn ratio(digest: &Digest, catalog: &dyn Catalog, task: &str, method: &str) -> Option<Ratio> {
    let (theirs, ours) = (until_solved(digest, task, method), until_solved(digest, task, "sindy"));
    let over = |theirs: &[f64], ours: &[f64]| {
        let (theirs, ours) = (median(theirs)?, median(ours)?);
        (ours > 0.0 && ours.is_finite()).then(|| theirs / ours)
    };
    let value = over(&theirs, &ours)?;
    let bounds: Vec<f64> =
        digest.of(task, method).map(|run| run.solved_after.unwrap_or(run.real_steps) as f64).collect();
    let at_least = || catalog.is_online(method).then(|| over(&bounds, &ours))?;
    let interval = if method == "sindy" { None } else { interval(&[&theirs, &ours], |s| over(&s[0], &s[1])) };
    Some(Ratio { value, interval, at_least: if value.is_finite() { None } else { at_least() } })
}

/// Mean returns of the seeds that came to an evaluation.
pub(crate) fn seed_returns(digest: &Digest, task: &str, method: &str) -> Vec<f64> {
    digest.of(task, method).filter_map(|run| run.mean_return).collect()
}

fn returns(digest: &Digest, task: &str, method: &str) -> Option<Returns> {
    let theirs = seed_returns(digest, task, method);
    let beside = || {
        let ours = |seed: u64| digest.of(task, "sindy").find(|run| run.seed == seed)?.mean_return;
        let more = |run: &Run| Some(run.mean_return? - ours(run.seed)?);
        let differences: Vec<f64> = digest.of(task, method).filter(|_| method != "sindy").filter_map(more).collect();
        let value = interquartile_mean(&differences)?;
        Some(Difference { value, interval: interval(&[&differences], |sample| interquartile_mean(&sample[0])) })
    };
    Some(Returns {
        mean: mean(&theirs)?,
        lowest: theirs
            .iter()
            .copied()
            .min_by(f64::total_cmp)
            .filter(|_| digest.of(task, method).all(|run| run.mean_return.is_some())),
        interquartile_mean: interquartile_mean(&theirs)?,
        interval: interval(&[&theirs], |sample| interquartile_mean(&sample[0])),
        beside_sindy: beside(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::tests::Some7;
    use sindyna_record::comparison::Outcome;

    fn groups(digest: &Digest) -> Vec<Group> {
        super::groups(digest, &Some7)
    }

    fn digest(runs: &[(&str, u64, Option<usize>, f64)]) -> Digest {
        let mut digest = Digest::default();
        for &(method, seed, solved_after, score) in runs {
            let outcome = Outcome {
                solved_after,
                real_steps: solved_after.unwrap_or(5_000),
                returns: vec![score; 4],
                ..Outcome::new("pendulum", method, seed)
            };
            digest.add(&outcome, None);
        }
        digest
    }

    fn steps_of(digest: &Digest, method: &str) -> Steps {
        let found = groups(digest).into_iter().find(|group| group.method == method);
        found.and_then(|group| group.steps).expect("the method counts real steps")
    }

    #[test]
    fn medians_count_those_that_never_solve_it() {
        let mostly = digest(&[("sac", 0, Some(100), 0.0), ("sac", 1, None, 1.0), ("sac", 2, Some(300), 2.0)]);
        let group = &groups(&mostly)[0];
        assert_eq!((group.runs, group.solved, group.failures), (3, 2, 0));
        let steps = group.steps.as_ref().expect("sac counts real steps");
        assert_eq!((steps.median, steps.range), (300.0, Some((100, 300))));
        let returns = group.returns.as_ref().expect("there are returns");
        assert_eq!((returns.mean, returns.lowest), (1.0, Some(0.0)));
        let rarely = digest(&[("sac", 0, None, 0.0), ("sac", 1, None, 0.0), ("sac", 2, Some(300), 0.0)]);
        assert_eq!(steps_of(&rarely, "sac").median, f64::INFINITY);
    }

    #[test]
    fn speed_ups_are_ratios_of_medians() {
        let both = digest(&[
            ("sindy", 0, Some(10), 0.0),
            ("sindy", 1, Some(10), 0.0),
            ("sac", 0, Some(1_000), 0.0),
            ("sac", 1, Some(1_000), 0.0),
            ("mbpo", 0, None, 0.0),
            ("mbpo", 1, None, 0.0),
        ]);
        let sac = steps_of(&both, "sac").over_sindy.expect("both have medians");
        assert_eq!((sac.value, sac.interval), (100.0, Some(Interval { low: 100.0, high: 100.0 })));
        let never = steps_of(&both, "mbpo").over_sindy.expect("both have medians");
        assert_eq!((never.value, never.at_least), (f64::INFINITY, Some(500.0)));
        assert_eq!(steps_of(&both, "mbpo").first_check, Some(500), "250 random steps, and a check every 250");
        let unsolved = digest(&[("sindy", 0, None, 0.0), ("sac", 0, Some(1_000), 0.0)]);
        assert_eq!(steps_of(&unsolved, "sac").over_sindy, None);
    }

    #[test]
    fn returns_are_compared_seed_by_seed() {
        let both = digest(&[
            ("sindy", 0, Some(10), -200.0),
            ("sindy", 1, Some(10), -100.0),
            ("sac", 0, None, -205.0),
            ("sac", 1, None, -105.0),
            ("sac", 2, None, -900.0),
        ]);
        let sac = groups(&both).into_iter().find(|group| group.method == "sac").and_then(|group| group.returns);
        let found = sac.and_then(|returns| returns.beside_sindy).expect("two seeds are in both");
        let expected = Difference { value: -5.0, interval: Some(Interval { low: -5.0, high: -5.0 }) };
        assert_eq!(found, expected, "seeds differ much more than methods");
    }

    #[test]
    fn what_is_known_beforehand_costs_no_real_steps_worth_counting() {
        let known = digest(&[("truth", 0, Some(10), 0.0)]);
        assert_eq!((groups(&known)[0].steps.clone(), groups(&known)[0].solved), (None, 1));
    }
}
