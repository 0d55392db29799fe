//! What was asked of a comparison, by all the commands that went into it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// One method on one task: a line of `asked.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Number of seeds, from 0 on.
    pub seeds: u64,
}

/// All that `before` and `now` ask for, each task and method once: of both the larger number of seeds.
#[must_use]
pub fn merged(before: &[Request], now: &[Request]) -> Vec<Request> {
    let mut most: BTreeMap<(&str, &str), u64> = BTreeMap::new();
    for Request { task, method, seeds } in before.iter().chain(now) {
        let known = most.entry((task, method)).or_insert(0);
        *known = (*seeds).max(*known);
    }
    let line =
        |((task, method), seeds): ((&str, &str), u64)| Request { task: task.into(), method: method.into(), seeds };
    most.into_iter().map(line).collect()
}
