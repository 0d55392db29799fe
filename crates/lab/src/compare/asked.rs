//! What was asked of a comparison, by all the commands that went into it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Job;

/// One method on one task: a line of `asked.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Asked {
    pub(crate) task: String,
    pub(crate) method: String,
    /// Seeds, from 0 on.
    pub(crate) seeds: u64,
}

/// What is asked with `jobs`, if `before` was asked already: of both the larger number of seeds.
pub(super) fn with(before: &[Asked], jobs: &[Job]) -> Vec<Asked> {
    let before = before.iter().map(|asked| (asked.task.as_str(), asked.method.as_str(), asked.seeds));
    let now = jobs.iter().map(|job| (job.system.name(), job.method.name(), job.seed + 1));
    let mut most: BTreeMap<(&str, &str), u64> = BTreeMap::new();
    for (task, method, seeds) in before.chain(now) {
        let known = most.entry((task, method)).or_insert(0);
        *known = seeds.max(*known);
    }
    let line = |((task, method), seeds): ((&str, &str), u64)| Asked { task: task.into(), method: method.into(), seeds };
    most.into_iter().map(line).collect()
}
