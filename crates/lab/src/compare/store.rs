//! Where outcomes lie: a file each, written whole, so that a comparison goes on where it was cut off.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use super::{Job, Outcome};
use crate::failure::Failure;
use crate::record::{json, sweep, write_atomic};

/// The directory of a comparison, held by one process at a time.
pub(crate) struct Store {
    root: PathBuf,
    /// Whoever has this file locked works here; the lock ends with the process, however that ends.
    _held: File,
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
        let held = File::open(&path).with_context(|| format!("cannot open {}", path.display()))?;
        match held.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Failure::new(format!("another comparison is at work in {}", root.display()))
                    .hint("wait for it, or name another directory with --out"));
            }
            // There are file systems without locks.
            Err(TryLockError::Error(_)) => {}
        }
        sweep(root).with_context(|| format!("cannot tidy {}", root.display()))?;
        Ok(Self { root: root.to_owned(), _held: held })
    }

    /// The outcome of `job`, if it was done before. A file that is no outcome is done again.
    pub(crate) fn done(&self, job: &Job) -> Option<Outcome> {
        serde_json::from_slice(&fs::read(self.path(job, "json")).ok()?).ok()
    }

    /// Keeps an outcome, the seconds it took in a file of its own, and the settings of its method.
    pub(crate) fn keep(&self, job: &Job, outcome: &Outcome, seconds: f64) -> Result<(), Failure> {
        let path = self.path(job, "json");
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| format!("cannot make the directory {}", folder.display()))?;
        }
        if let Some(settings) = job.settings()? {
            let settings_path = path.with_file_name("settings.toml");
            write_atomic(&settings_path, settings.as_bytes())
                .with_context(|| format!("cannot write {}", settings_path.display()))?;
        }
        let timing = serde_json::json!({ "wall_seconds": seconds });
        let timing_path = self.path(job, "timing.json");
        write_atomic(&timing_path, &json(&timing)?)
            .with_context(|| format!("cannot write {}", timing_path.display()))?;
        write_atomic(&path, &json(outcome)?).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(())
    }

    fn path(&self, job: &Job, extension: &str) -> PathBuf {
        let folder = self.root.join("runs").join(job.system.name()).join(job.method.name());
        folder.join(format!("seed-{}.{extension}", job.seed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_belongs_to_one_at_a_time_and_is_tidied_for_it() {
        let temp = tempfile::tempdir().unwrap();
        let root = temp.path().join("new");
        let first = Store::open(&root, "a = 1").unwrap();
        fs::create_dir(root.join("runs")).unwrap();
        let (left, other) = (root.join("runs/.unfinished-x"), root.join("runs/mine"));
        fs::write(&left, "half a").unwrap();
        fs::write(&other, "whole").unwrap();
        let refusal = Store::open(&root, "a = 1").err().unwrap().to_string();
        assert!(refusal.contains("another comparison is at work") && left.exists(), "{refusal}");
        drop(first);
        assert!(Store::open(&root, "a = 1").is_ok() && !left.exists() && other.exists());
        let refusal = Store::open(&root, "a = 2").err().unwrap().to_string();
        assert!(refusal.contains("other settings"), "{refusal}");
    }
}
