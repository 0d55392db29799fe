//! The files of a comparison, read into a digest.

use std::fs;
use std::path::Path;

use super::{Digest, Names, Outcome, SETTINGS, read_requests, read_seconds};
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
    for (task, method) in names.tasks.iter().flat_map(|task| names.methods.iter().map(move |method| (task, method))) {
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
            if (outcome.task.as_str(), outcome.method.as_str(), outcome.seed) != (*task, *method, seed) {
                let Outcome { method, task, seed, .. } = outcome;
                return Err(RecordError::OtherRun { path, method, task, seed });
            }
            digest.add(&outcome, read_seconds(&folder.join(format!("seed-{seed}.timing.json"))));
        }
    }
    if digest.runs.is_empty() {
        return Err(RecordError::NoRuns { path: root.to_owned() });
    }
    let inconsistent = |what| RecordError::Inconsistent { path: root.to_owned(), what, is_digest: false };
    digest.check(names).map_err(inconsistent)?;
    Ok(digest)
}

/// Seeds with an outcome in `folder`, in ascending order.
fn seeds(folder: &Path) -> Vec<u64> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let seed = |name: &str| name.strip_prefix("seed-")?.strip_suffix(".json")?.parse().ok();
    let mut seeds: Vec<u64> = entries.flatten().filter_map(|e| seed(e.file_name().to_str()?)).collect();
    seeds.sort_unstable();
    seeds
}
