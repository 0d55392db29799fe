//! What a comparison comes to, in sentences.

use crate::document::Block;
use crate::equations::Equations;
use crate::groups::Group;
use crate::names::method_name;
use crate::numbers::{fixed, plural, rough, significant, with_interval};
use crate::scores::{Scale, over_tasks, scores};
use crate::stats::median;
use crate::{Comparison, Figure};

/// A method that has runs on all tasks and of which real steps say something.
struct Learner<'a> {
    method: &'a str,
    /// One for each task.
    groups: Vec<&'a Group>,
}

impl Learner<'_> {
    /// Median real steps until solved on each task, infinite where the median run never solves it.
    fn medians(&self) -> impl Iterator<Item = f64> + Clone {
        self.groups.iter().map(|group| group.steps.as_ref().map_or(f64::INFINITY, |steps| steps.median))
    }

    /// Tasks that the median run solves.
    fn solved(&self) -> usize {
        self.medians().filter(|steps| steps.is_finite()).count()
    }

    /// More tasks come before fewer, then fewer real steps before more: their logarithms, added up over tasks.
    fn place(&self) -> (usize, f64) {
        let steps: f64 = self.medians().filter(|steps| steps.is_finite()).map(|steps| steps.max(1.0).ln()).sum();
        (usize::MAX - self.solved(), steps)
    }
}

/// The learners, the best first.
fn ranked<'a>(comparison: &'a Comparison<'_>) -> Vec<Learner<'a>> {
    let tasks = comparison.digest.tasks();
    let of = |method: &'a str| {
        let groups: Vec<&Group> = comparison.groups.iter().filter(|group| group.method == method).collect();
        (groups.len() == tasks.len() && groups.iter().all(|group| group.steps.is_some()))
            .then_some(Learner { method, groups })
    };
    let mut learners: Vec<Learner<'a>> = comparison.digest.methods().into_iter().filter_map(of).collect();
    learners.sort_by(|a, b| a.place().0.cmp(&b.place().0).then(a.place().1.total_cmp(&b.place().1)));
    learners
}

/// The findings: who needs fewest real steps, who comes next, how good policies are, what equations are worth, what time it takes.
pub(super) fn findings(comparison: &Comparison<'_>, found: &[Equations], scales: &[Scale]) -> Vec<Block> {
    let ranked = ranked(comparison);
    let Some((first, others)) = ranked.split_first() else { return Vec::new() };
    let mut lines = vec![leader(first)];
    lines.extend(others.first().map(|next| follower(first, next)));
    if others.len() > 1 {
        let of = |l: &Learner<'_>| format!("{} {}", method_name(l.method), l.solved());
        let list: Vec<String> = others[1..].iter().map(of).collect();
        let all = plural(first.groups.len(), "task");
        lines.push(format!("Of {all}, the median runs of the others solve: {}.", list.join(", ")));
    }
    lines.extend(returns(comparison, scales, &ranked));
    lines.extend(equations(found));
    lines.extend(times(comparison, &ranked[..ranked.len().min(2)]));
    vec![Block::Section("Findings".into()), Block::List(lines)]
}

fn leader(first: &Learner<'_>) -> String {
    let (tasks, solved) = (first.groups.len(), first.solved());
    let (runs, came): (usize, usize) =
        first.groups.iter().fold((0, 0), |sum, group| (sum.0 + group.runs, sum.1 + group.solved));
    let name = method_name(first.method);
    let what = match (solved, tasks) {
        (0, 1) => return format!("No method solves the task; {came} of {} of {name} do.", plural(runs, "run")),
        (0, _) => return format!("No method solves any of the {tasks} tasks in its median run."),
        (_, 1) => "the task".to_owned(),
        (some, all) if some == all => format!("all {all} tasks"),
        (some, all) => format!("{some} of {all} tasks"),
    };
    format!(
        "{name} solves {what} from {} real steps (medians over seeds; {came} of {} solve their task).",
        span(first.medians().filter(|steps| steps.is_finite()), |v| fixed(v, 0)),
        plural(runs, "run")
    )
}

fn follower(first: &Learner<'_>, next: &Learner<'_>) -> String {
    let name = method_name(next.method);
    if next.solved() == 0 {
        return format!("The next, {name}, solves none of them in its median run.");
    }
    let tasks = if next.solved() == next.groups.len() {
        String::new()
    } else {
        format!(" for the {} it solves", next.solved())
    };
    let steps = span(next.medians().filter(|steps| steps.is_finite()), |v| fixed(v, 0));
    let ratios = next.medians().zip(first.medians()).map(|(theirs, ours)| theirs / ours);
    let ratios = span(ratios.filter(|ratio| ratio.is_finite() && *ratio > 0.0), rough);
    format!("The next, {name}, needs {steps} real steps{tasks}: {ratios} times as many.")
}

/// `10`, or `10 to 30`.
fn span(values: impl Iterator<Item = f64>, shown: impl Fn(f64) -> String) -> String {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let (low, high) = (shown(low), shown(high));
    if low == high { low } else { format!("{low} to {high}") }
}

/// Returns at the end on the common scale.
fn returns(comparison: &Comparison<'_>, scales: &[Scale], learners: &[Learner<'_>]) -> Option<String> {
    let anchor = scales.first().map(|scale| scale.anchor)?;
    let of = |learner: &Learner<'_>| {
        let (middle, interval) = over_tasks(&scores(comparison.digest, scales, learner.method))?;
        Some(format!("{} {}", method_name(learner.method), with_interval(middle, interval, |v| fixed(v, 3))))
    };
    let all: Vec<String> = learners.iter().filter_map(of).collect();
    (!all.is_empty()).then(|| {
        format!(
            "Returns at the end, where the random policy has 0 and the {} 1 (interquartile means over all tasks and seeds): {}.",
            method_name(anchor),
            all.join(", ")
        )
    })
}

fn equations(found: &[Equations]) -> Option<String> {
    let (terms, runs) = found.iter().fold((0, 0), |(t, r), task| (t + task.true_terms(), r + task.judged.len()));
    let largest = found.iter().filter_map(|task| Some(task.errors()?.1)).fold(0.0, f64::max);
    (runs > 0).then(|| {
        let errors = if terms > 0 {
            format!("; in these, the largest relative error of a coefficient is {}", significant(largest, 2))
        } else {
            String::new()
        };
        format!("The equations of sindy have the true terms in {terms} of {}{errors}.", plural(runs, "run"))
    })
}

/// Wall-clock time of a run of the best two.
fn times(comparison: &Comparison<'_>, learners: &[Learner<'_>]) -> Option<String> {
    let of = |learner: &Learner<'_>| {
        let medians: Vec<f64> = learner.groups.iter().filter_map(|group| median(&seconds(comparison, group))).collect();
        let shown = |v: f64| format!("{} s", rough(v));
        (!medians.is_empty()).then(|| format!("{} {}", method_name(learner.method), span(medians.into_iter(), shown)))
    };
    let all: Vec<String> = learners.iter().filter_map(of).collect();
    (!all.is_empty())
        .then(|| format!("Wall-clock time of a whole run on one core, median over seeds: {}.", all.join(", ")))
}

/// Wall-clock times of the runs of `group`.
pub(super) fn seconds(comparison: &Comparison<'_>, group: &Group) -> Vec<f64> {
    let of_group = comparison.digest.times.iter().filter(|t| t.task == group.task && t.method == group.method);
    of_group.map(|t| t.wall_seconds).collect()
}

/// Real steps and wall-clock time side by side.
pub(super) fn costs(comparison: &Comparison<'_>, task: &str) -> Option<Figure> {
    let Comparison { digest, catalog, groups } = comparison;
    let row = |group: &Group| {
        let until = digest.of(task, &group.method).map(|run| run.solved_after.map_or(f64::INFINITY, |s| s as f64));
        crate::figure::CostRow {
            method: method_name(&group.method),
            class: crate::figure::colour(*catalog, &group.method),
            steps: if group.steps.is_some() { until.collect() } else { Vec::new() },
            seconds: seconds(comparison, group),
        }
    };
    let rows: Vec<_> = groups.iter().filter(|group| group.task == task).map(row).collect();
    crate::figure::costs(task, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::tests::Some7;
    use crate::scores::scales;
    use sindyna_record::comparison::{Digest, Outcome};

    /// Three runs of each method on both tasks, with these real steps until solved and returns.
    fn digest(methods: &[(&str, [Option<usize>; 2], f64)]) -> Digest {
        let mut digest = Digest::default();
        for (at, task) in ["pendulum", "cart-pole"].into_iter().enumerate() {
            for &(method, solved, mean) in methods {
                for seed in 0..3 {
                    let outcome = Outcome {
                        solved_after: solved[at],
                        real_steps: 5_000,
                        returns: vec![mean; 2],
                        ..Outcome::new(task, method, seed)
                    };
                    digest.add(&outcome, Some(if method == "sac" { 30.0 } else { 2.0 }));
                }
            }
        }
        digest
    }

    fn told(digest: &Digest) -> Vec<String> {
        let comparison = Comparison::new(digest, &Some7);
        let blocks = findings(&comparison, &[], &scales(digest));
        match blocks.into_iter().next_back() {
            Some(Block::List(lines)) => lines,
            _ => Vec::new(),
        }
    }

    #[test]
    fn the_best_the_next_and_the_others_are_told_with_their_numbers() {
        let all = digest(&[
            ("sindy", [Some(10), Some(20)], 100.0),
            ("mbpo", [Some(5_000), None], 50.0),
            ("sac", [Some(1_000), Some(3_000)], 90.0),
            ("truth", [Some(10), Some(10)], 100.0),
            ("random", [None, None], 0.0),
        ]);
        assert_eq!(
            told(&all),
            [
                "sindy solves all 2 tasks from 10 to 20 real steps (medians over seeds; 6 of 6 runs solve their task).",
                "The next, sac, needs 1,000 to 3,000 real steps: 100 to 150 times as many.",
                "Of 2 tasks, the median runs of the others solve: mbpo 1.",
                "Returns at the end, where the random policy has 0 and the oracle 1 (interquartile means over all tasks and seeds): \
                 sindy 1.000 [1.000, 1.000], sac 0.900 [0.900, 0.900], mbpo 0.500 [0.500, 0.500].",
                "Wall-clock time of a whole run on one core, median over seeds: sindy 2 s, sac 30 s.",
            ]
        );
    }

    #[test]
    fn who_loses_is_told_too() {
        let lost = digest(&[("sindy", [Some(10), None], 1.0), ("sac", [Some(1_000), Some(500)], 1.0)]);
        let told = told(&lost);
        assert_eq!(
            told[..2],
            [
                "sac solves all 2 tasks from 500 to 1,000 real steps (medians over seeds; 6 of 6 runs solve their task).",
                "The next, sindy, needs 10 real steps for the 1 it solves: 0.01 times as many.",
            ]
        );
        let none = digest(&[("sac", [None, None], 1.0)]);
        assert_eq!(super::tests::told(&none)[0], "No method solves any of the 2 tasks in its median run.");
    }
}
