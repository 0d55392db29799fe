//! How good the policies are in the end.

use sindyna_record::comparison::Run;

use crate::Comparison;
use crate::document::Block;
use crate::figure;
use crate::groups::Group;
use crate::names::method_name;
use crate::numbers::{fixed, or_none, with_interval};
use crate::scores::{Scale, over_tasks, scores, share};

pub(super) fn returns(comparison: &Comparison<'_>) -> Vec<Block> {
    let Comparison { digest, groups, .. } = comparison;
    let one = |value: f64| fixed(value, 1);
    let row = |group: &Group| {
        let returns = group.returns.as_ref();
        [
            group.task.clone(),
            method_name(&group.method),
            fixed(group.real_steps as f64, 0),
            or_none(returns.map(|r| with_interval(r.interquartile_mean, r.interval, one))),
            or_none(returns.and_then(|r| r.beside_sindy.as_ref()).map(|d| with_interval(d.value, d.interval, one))),
            or_none(returns.map(|r| r.lowest.map_or_else(|| "no policy".into(), one))),
        ]
    };
    let head = [
        "task",
        "method",
        "real steps, maximum",
        "100 starts: interquartile mean",
        "difference to sindy, by seed",
        "worst seed",
    ];
    let mut blocks = vec![
        Block::Section("Returns at the end".into()),
        Block::text(
            "Evaluation of the policy that a run ends with, from 100 start states that are the same for every method with the same \
             seed. The return of a seed is their mean; the interquartile mean is over the seeds that have a policy. The third column has the real steps spent by then. \
             The difference to sindy is that of runs with the same seed.",
        ),
        Block::table(2, head, groups.iter().map(row).collect()),
    ];
    let told = |run: &Run| {
        Some(format!("{} on {}, seed {}: {}", method_name(&run.method), run.task, run.seed, run.failure.as_ref()?))
    };
    let failures: Vec<String> = digest.runs.iter().filter_map(told).collect();
    if !failures.is_empty() {
        blocks.push(Block::text(format!("Ended early: {}.", failures.join("; "))));
    }
    blocks
}

/// Interquartile means over all tasks, and performance profiles.
pub(super) fn one_scale(comparison: &Comparison<'_>, scales: &[Scale]) -> Vec<Block> {
    let Comparison { digest, catalog, .. } = *comparison;
    let mut blocks = vec![Block::Section("All tasks on one scale".into())];
    if scales.is_empty() {
        blocks.push(Block::text(
            "Returns of different tasks have no common scale here: it takes runs of random, and of the oracle or the expert.",
        ));
        return blocks;
    }
    let ends: Vec<String> = scales
        .iter()
        .map(|s| format!("{} {} to {} ({})", s.task, fixed(s.zero, 1), fixed(s.one, 1), method_name(s.anchor)))
        .collect();
    blocks.push(Block::text(format!(
        "The random policy has 0, the oracle 1 (soft actor-critic in the true equations; the expert, a controller written by hand, where \
         there are no such runs): {}. A run without a policy has 0. The performance profile is the share of runs with a normalised return of \
         at least τ; further to the right and higher is better. Methods that are not for all of these tasks are \
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
            method_name(method),
            strata.len().to_string(),
            all.len().to_string(),
            or_none(over_tasks(strata).map(|(middle, interval)| with_interval(middle, interval, |v| fixed(v, 3)))),
            fixed(100.0 * share(&all, 0.9), 0),
            fixed(100.0 * share(&all, 0.99), 0),
        ]
    };
    let head = ["method", "tasks", "runs", "interquartile mean", "% of runs ≥ 0.9", "% of runs ≥ 0.99"];
    blocks.push(Block::table(1, head, methods.iter().map(row).collect()));
    let curves: Vec<(String, Vec<f64>)> =
        methods.iter().map(|(method, strata)| (method_name(method), strata.concat())).collect();
    blocks.push(Block::Figures(figure::profiles(catalog, &curves)));
    blocks
}
