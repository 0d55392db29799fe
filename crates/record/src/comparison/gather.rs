//! The files of a comparison, read into a digest.

use std::fs;
use std::path::Path;

use super::{Digest, Names, Outcome, SETTINGS, base, read_requests, read_seconds};
use crate::{RecordError, format};

/// Every outcome there is in the comparison `root`, whichever command left it: tasks and methods in their usual order, seeds
/// from the lowest. Directories of other `names` are left alone.
///
/// # Errors
/// [`RecordError::NotAComparison`], [`RecordError::NoRuns`], or what is wrong with a file in it.
pub fn gather(root: &Path, names: &Names<'_>) -> Result<Digest, RecordError> {
    let settings = fs::read_to_string(root.join(SETTINGS))
        .map_err(|source| RecordError::NotAComparison { path: root.to_owned(), source })?;
    let mut digest = Digest { settings, asked: read_requests(root)?, ..Digest::default() };
    for task in tasks(root, names) {
        for method in methods(root, &task, names) {
            gather_one(root, &task, &method, &mut digest)?;
        }
    }
    if digest.runs.is_empty() {
        return Err(RecordError::NoRuns { path: root.to_owned() });
    }
    let inconsistent = |what| RecordError::Inconsistent { path: root.to_owned(), what, is_digest: false };
    digest.check(names).map_err(inconsistent)?;
    Ok(digest)
}

/// The tasks in their usual order, those of task files after them, each followed by what there is of it with noise.
fn tasks(root: &Path, names: &Names<'_>) -> Vec<String> {
    let mut found = names_in(&root.join("runs"));
    found.retain(|name| names.has_task(name));
    let place = |name: &str| names.tasks.iter().position(|task| *task == base(name)).unwrap_or(names.tasks.len());
    // Names are in order already, and a task's own comes before those that begin with it.
    found.sort_by_key(|name| place(name));
    found
}

/// Names of what lies in `folder`, in order.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    found.sort_unstable();
    found
}

/// The methods in their usual order, each followed by the variants there are runs of on `task`.
fn methods(root: &Path, task: &str, names: &Names<'_>) -> Vec<String> {
    let mut found = names_in(&root.join("runs").join(task));
    found.retain(|name| names.has_method(name));
    let of = |method: &str| found.iter().filter(move |name| base(name) == method).cloned().collect::<Vec<_>>();
    names.methods.iter().flat_map(|method| of(method)).collect()
}

/// Adds the runs of `method` on `task` to `digest`.
fn gather_one(root: &Path, task: &str, method: &str, digest: &mut Digest) -> Result<(), RecordError> {
    let folder = root.join("runs").join(task).join(method);
    if let Ok(settings) = fs::read_to_string(folder.join("settings.toml")) {
        digest.settings += &format!("\n# {method} on {task}\n{settings}");
    }
    for seed in seeds(&folder) {
        let path = folder.join(format!("seed-{seed}.json"));
        let contents = fs::read(&path).map_err(RecordError::io("read", &path))?;
        let outcome: Outcome = serde_json::from_slice(&contents)
            .map_err(|e| RecordError::Malformed { path: path.clone(), source: e.into() })?;
        format::check("the outcome of a run", outcome.format)?;
        if (outcome.task.as_str(), outcome.method.as_str(), outcome.seed) != (task, method, seed) {
            let Outcome { method, task, seed, .. } = outcome;
            return Err(RecordError::OtherRun { path, method, task, seed });
        }
        digest.add(&outcome, read_seconds(&folder.join(format!("seed-{seed}.timing.json"))));
    }
    Ok(())
}

/// Seeds with an outcome in `folder`, in ascending order.
fn seeds(folder: &Path) -> Vec<u64> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let seed = |name: &str| name.strip_prefix("seed-")?.strip_suffix(".json")?.parse().ok();
    let mut seeds: Vec<u64> = entries.flatten().filter_map(|e| seed(e.file_name().to_str()?)).collect();
    seeds.sort_unstable();
    seeds
}
