//! Where outcomes lie: a file each, written whole, so that a comparison goes on where it was cut off.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use super::{Job, Outcome};
use crate::failure::Failure;
use crate::record::{json, write_atomic};

/// The directory of a comparison.
pub(crate) struct Store {
    root: PathBuf,
}

impl Store {
    /// The directory `root`, made if it is not there, for runs described by `settings`.
    ///
    /// What other settings left there is not mixed with what is to come.
    pub(crate) fn open(root: &Path, settings: &str) -> Result<Self, Failure> {
        let path = root.join("compare.toml");
        match fs::read_to_string(&path) {
            Ok(before) if before == settings => {}
            Ok(_) => {
                return Err(Failure::new(format!(
                    "{} holds runs of other settings or another version",
                    root.display()
                ))
                .hint("name another directory with --out, or take this one away"));
            }
            Err(_) => {
                let strange = fs::read_dir(root).is_ok_and(|mut entries| entries.next().is_some());
                if strange {
                    return Err(Failure::new(format!("{} holds something that is no comparison", root.display()))
                        .hint("name another directory with --out"));
                }
                fs::create_dir_all(root).with_context(|| format!("cannot make the directory {}", root.display()))?;
                write_atomic(&path, settings.as_bytes()).with_context(|| format!("cannot write {}", path.display()))?;
            }
        }
        Ok(Self { root: root.to_owned() })
    }

    /// The outcome of `job`, if it was done before. A file that is no outcome is done again.
    pub(crate) fn done(&self, job: &Job) -> Option<Outcome> {
        serde_json::from_slice(&fs::read(self.path(job, "json")).ok()?).ok()
    }

    /// Keeps an outcome, and the seconds it took in a file of its own.
    pub(crate) fn keep(&self, job: &Job, outcome: &Outcome, seconds: f64) -> Result<(), Failure> {
        let path = self.path(job, "json");
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| format!("cannot make the directory {}", folder.display()))?;
        }
        let timing = serde_json::json!({ "wall_seconds": seconds });
        let timing_path = self.path(job, "timing.json");
        write_atomic(&timing_path, &json(&timing)?)
            .with_context(|| format!("cannot write {}", timing_path.display()))?;
        write_atomic(&path, &json(outcome)?).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(())
    }

    /// Writes a file beside the outcomes.
    pub(crate) fn write(&self, name: &str, contents: &[u8]) -> Result<(), Failure> {
        let path = self.root.join(name);
        write_atomic(&path, contents).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(())
    }

    fn path(&self, job: &Job, extension: &str) -> PathBuf {
        let folder = self.root.join("runs").join(job.system.name()).join(job.method.name());
        folder.join(format!("seed-{}.{extension}", job.seed))
    }
}
