//! What was asked of a comparison, by all the commands that went into it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Seeds;

/// One method on one task: a line of `asked.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Seeds.
    pub seeds: Seeds,
}

/// All that `before` and `now` ask for, each task and method once: the seeds of both.
#[must_use]
pub fn merged(before: &[Request], now: &[Request]) -> Vec<Request> {
    let mut all: BTreeMap<(&str, &str), Seeds> = BTreeMap::new();
    for Request { task, method, seeds } in before.iter().chain(now) {
        let known = all.entry((task, method)).or_default();
        *known = seeds.union(known);
    }
    let line =
        |((task, method), seeds): ((&str, &str), Seeds)| Request { task: task.into(), method: method.into(), seeds };
    all.into_iter().map(line).collect()
}
