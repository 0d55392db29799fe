//! How good the policies are in the end.

use sindyna_record::comparison::Run;

use crate::Comparison;
use crate::document::Block;
use crate::figure;
use crate::groups::Group;
use crate::numbers::{fixed, or_none, with_interval};
use crate::scores::{Scale, over_tasks, scores, share};

pub(super) fn returns(comparison: &Comparison<'_>) -> Vec<Block> {
    let Comparison { digest, groups, .. } = comparison;
    let one = |value: f64| fixed(value, 1);
    let row = |group: &Group| {
        let returns = group.returns.as_ref();
        [
            group.task.clone(),
            group.method.clone(),
            fixed(group.real_steps as f64, 0),
            or_none(returns.map(|r| with_interval(r.interquartile_mean, r.interval, one))),
            or_none(returns.and_then(|r| r.beside_sindy.as_ref()).map(|d| with_interval(d.value, d.interval, one))),
            or_none(returns.map(|r| r.lowest.map_or_else(|| "no policy".into(), one))),
        ]
    };
    let head = [
        "task",
        "method",
        "real steps, most",
        "100 starts: interquartile mean",
        "minus sindy's, seed by seed",
        "lowest seed",
    ];
    let mut blocks = vec![
        Block::Section("Returns at the end".into()),
        Block::text(
            "The policy that a run ends with, from 100 start states that are the same for every method with the same \
             seed; the return of a seed is their mean, and the interquartile mean is taken over seeds that came to a policy. Methods that learn on the system have spent the real \
             steps of the third column by then; “minus sindy's” is how much better or worse they are in the end.",
        ),
        Block::table(2, head, groups.iter().map(row).collect()),
    ];
    let told =
        |run: &Run| Some(format!("{} on {}, seed {}: {}", run.method, run.task, run.seed, run.failure.as_ref()?));
    let failures: Vec<String> = digest.runs.iter().filter_map(told).collect();
    if !failures.is_empty() {
        blocks.push(Block::text(format!("Stopped short: {}.", failures.join("; "))));
    }
    blocks
}

/// Interquartile means over all tasks, and performance profiles.
pub(super) fn one_scale(comparison: &Comparison<'_>, scales: &[Scale]) -> Vec<Block> {
    let Comparison { digest, catalog, .. } = *comparison;
    let mut blocks = vec![Block::Section("All tasks on one scale".into())];
    if scales.is_empty() {
        blocks.push(Block::text(
            "Returns of different tasks have no common scale here: it takes runs of `random`, and of `truth` or `hand`.",
        ));
        return blocks;
    }
    let ends: Vec<String> = scales
        .iter()
        .map(|s| format!("{} {} to {} ({})", s.task, fixed(s.zero, 1), fixed(s.one, 1), s.anchor))
        .collect();
    blocks.push(Block::text(format!(
        "The random policy scores 0, soft actor-critic inside the true equations 1 (or the controller written by hand, where \
         there are no such runs): {}. A run that came to no policy scores 0. The profile shows which share of runs reaches \
         at least a score τ; a curve further to the right and higher is better. Methods that are not for all of these tasks are \
         measured on those they are for.",
        ends.join("; ")
    )));
    let methods: Vec<(&str, Vec<Vec<f64>>)> = digest
        .methods()
        .into_iter()
        .map(|method| (method, scores(digest, scales, method)))
        .filter(|(_, strata)| !strata.is_empty())
        .collect();
    let row = |(method, strata): &(&str, Vec<Vec<f64>>)| {
        let all = strata.concat();
        [
            (*method).to_owned(),
            strata.len().to_string(),
            all.len().to_string(),
            or_none(over_tasks(strata).map(|(middle, interval)| with_interval(middle, interval, |v| fixed(v, 3)))),
            fixed(100.0 * share(&all, 0.9), 0),
            fixed(100.0 * share(&all, 0.99), 0),
        ]
    };
    let head = ["method", "tasks", "runs", "interquartile mean", "% of runs ≥ 0.9", "% of runs ≥ 0.99"];
    blocks.push(Block::table(1, head, methods.iter().map(row).collect()));
    let curves: Vec<(&str, Vec<f64>)> = methods.iter().map(|(method, strata)| (*method, strata.concat())).collect();
    blocks.push(Block::Figures(figure::profiles(catalog, &curves)));
    blocks
}
