//! The files of a comparison, read into a digest.

use std::fs;
use std::path::Path;

use anyhow::Context as _;

use super::Digest;
use crate::compare::{Method, Outcome, read_asked, read_seconds};
use crate::failure::Failure;

/// Every outcome there is in the comparison `root`, whichever command left it: tasks and methods in their usual order, seeds
/// from the lowest.
pub(crate) fn gather(root: &Path) -> Result<Digest, Failure> {
    let path = root.join("compare.toml");
    let settings = fs::read_to_string(&path)
        .with_context(|| {
            format!("{} is neither a comparison nor a digest of one: cannot read compare.toml in it", root.display())
        })
        .map_err(|error| Failure::from(error).hint("name the directory of a comparison"))?;
    let mut digest = Digest { settings, asked: read_asked(root)?, ..Digest::default() };
    let tasks: Vec<&str> = sindyna_envs::systems().iter().map(sindyna_envs::System::name).collect();
    for (task, method) in tasks.iter().flat_map(|task| Method::ALL.map(|method| (task, method))) {
        let folder = root.join("runs").join(task).join(method.name());
        if let Ok(settings) = fs::read_to_string(folder.join("settings.toml")) {
            digest.settings += &format!("\n# {} on {task}\n{settings}", method.name());
        }
        for seed in seeds(&folder) {
            let path = folder.join(format!("seed-{seed}.json"));
            let read = || anyhow::Ok(serde_json::from_slice::<Outcome>(&fs::read(&path)?)?);
            let outcome = read().with_context(|| format!("cannot read {}", path.display()))?;
            if (outcome.task.as_str(), outcome.method.as_str(), outcome.seed) != (*task, method.name(), seed) {
                return Err(Failure::new(format!(
                    "{} holds a run of {} on {} with seed {}",
                    path.display(),
                    outcome.method,
                    outcome.task,
                    outcome.seed
                ))
                .hint("take it away; `sindyna compare` makes it again"));
            }
            digest.add(&outcome, read_seconds(&folder.join(format!("seed-{seed}.timing.json"))));
        }
    }
    if digest.runs.is_empty() {
        return Err(
            Failure::new(format!("{} holds no runs", root.display())).hint("`sindyna compare --out DIR` makes some")
        );
    }
    digest.check().map_err(|what| {
        Failure::new(format!("{} is not what a comparison wrote: {what}", root.display()))
            .hint("`sindyna compare` makes again what is taken away")
    })?;
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
