//! Where outcomes lie: a file each, written whole, so that a comparison goes on where it was cut off.

use std::fs;
use std::path::{Path, PathBuf};

use sindyna_record::comparison::{
    Outcome, Request, SETTINGS, merged, read_requests, read_seconds, write_requests, write_seconds,
};
use sindyna_record::run::DirLock;
use sindyna_record::{is_unfinished, json, save, sweep};

use super::{Job, MethodError};

/// The directory of a comparison, held by one process at a time.
pub struct Store {
    root: PathBuf,
    _lock: DirLock,
}

impl Store {
    /// The directory `root`, made if it is not there, for `jobs` described by `settings`.
    ///
    /// What other settings left there is not mixed with what is to come.
    pub fn open(root: &Path, settings: &str, jobs: &[Job]) -> Result<Self, MethodError> {
        make(root)?;
        let lock = DirLock::take(root)?;
        let path = root.join(SETTINGS);
        match fs::read_to_string(&path) {
            Ok(before) if before == settings => {}
            Ok(before) => return Err(other_settings(root, &before, settings)),
            Err(_) => {
                if fs::read_dir(root)
                    .is_ok_and(|mut entries| entries.any(|entry| entry.map_or(true, |e| !is_unfinished(&e))))
                {
                    return Err(MethodError::NotAComparison { path: root.to_owned() });
                }
                save(&path, settings.as_bytes())?;
            }
        }
        sweep(root)?;
        same_variants(root, jobs)?;
        keep_tasks(root, jobs)?;
        let asked: Vec<Request> = jobs.iter().map(Job::request).collect();
        write_requests(root, &merged(&read_requests(root)?, &asked))?;
        Ok(Self { root: root.to_owned(), _lock: lock })
    }

    /// The outcome of `job`, if it was done before. A file that is no outcome is done again.
    pub fn done(&self, job: &Job) -> Option<Outcome> {
        serde_json::from_slice(&fs::read(self.path(job, "json")).ok()?).ok()
    }

    /// The seconds that `job` took, if it was done before.
    pub fn seconds(&self, job: &Job) -> Option<f64> {
        read_seconds(&self.path(job, "timing.json"))
    }

    /// Keeps an outcome, the seconds it took in a file of its own, and the settings of its method.
    pub fn keep(&self, job: &Job, outcome: &Outcome, seconds: f64) -> Result<(), MethodError> {
        let path = self.path(job, "json");
        if let Some(folder) = path.parent() {
            make(folder)?;
        }
        if let Some(settings) = job.settings()? {
            let settings_path = path.with_file_name("settings.toml");
            save(&settings_path, settings.as_bytes())?;
        }
        write_seconds(&self.path(job, "timing.json"), seconds)?;
        save(&path, &json(outcome)?)?;
        Ok(())
    }

    fn path(&self, job: &Job, extension: &str) -> PathBuf {
        let folder = self.root.join("runs").join(job.task()).join(job.contender.name());
        folder.join(format!("seed-{}.{extension}", job.seed))
    }
}

/// Makes the directory `path`, with those around it.
fn make(path: &Path) -> Result<(), MethodError> {
    fs::create_dir_all(path).map_err(|source| MethodError::Folder { path: path.to_owned(), source })
}

/// Keeps the task files of `jobs` beside their runs; refuses others of the same name.
fn keep_tasks(root: &Path, jobs: &[Job]) -> Result<(), MethodError> {
    let mut kept: Vec<String> = Vec::new();
    for job in jobs {
        let task = job.task();
        if kept.contains(&task) {
            continue;
        }
        let folder = root.join("runs").join(&task);
        kept.push(task);
        for (name, contents) in job.system.files()? {
            let path = folder.join(name);
            match fs::read(&path) {
                Ok(before) if before == contents => {}
                Ok(_) => {
                    return Err(MethodError::OtherTask { path });
                }
                Err(_) => {
                    make(&folder)?;
                    save(&path, &contents)?;
                }
            }
        }
    }
    Ok(())
}

/// Refuses a variant under whose name runs with other settings lie there.
fn same_variants(root: &Path, jobs: &[Job]) -> Result<(), MethodError> {
    for job in jobs {
        let (task, name) = (job.task(), job.contender.name());
        let path = root.join("runs").join(&task).join(&name).join("settings.toml");
        let Some(settings) = job.settings()?.filter(|_| job.contender.is_variant()) else { continue };
        if fs::read_to_string(&path).is_ok_and(|before| before != settings) {
            return Err(MethodError::OtherVariant { path: root.to_owned(), name });
        }
    }
    Ok(())
}

/// Says which of the settings differ.
fn other_settings(root: &Path, before: &str, now: &str) -> MethodError {
    let table = |text: &str| text.parse::<toml::Table>().unwrap_or_default();
    let (before, now) = (table(before), table(now));
    let shown = |table: &toml::Table, name: &str| table.get(name).map_or_else(|| "none".into(), toml::Value::to_string);
    let mut names: Vec<&String> = before.keys().chain(now.keys()).collect();
    names.sort_unstable();
    names.dedup();
    let differ = names.into_iter().filter(|name| before.get(*name) != now.get(*name));
    let differ: Vec<String> =
        differ.map(|name| format!("{name} {} there, {} here", shown(&before, name), shown(&now, name))).collect();
    MethodError::OtherSettings { path: root.to_owned(), differ: differ.join("; ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_belongs_to_one_at_a_time_and_is_tidied_for_it() {
        let temp = tempfile::tempdir().unwrap();
        let root = temp.path().join("new");
        let first = Store::open(&root, "a = 1", &[]).unwrap();
        fs::create_dir(root.join("runs")).unwrap();
        let (left, other) = (root.join("runs/.unfinished-x"), root.join("runs/mine"));
        fs::write(&left, "half a").unwrap();
        fs::write(&other, "whole").unwrap();
        let refusal = Store::open(&root, "a = 1", &[]).err().unwrap().to_string();
        assert!(refusal.contains("is in use by another sindyna process") && left.exists(), "{refusal}");
        drop(first);
        assert!(Store::open(&root, "a = 1", &[]).is_ok() && !left.exists() && other.exists());
        let refusal = Store::open(&root, "a = 2", &[]).err().unwrap().to_string();
        assert!(refusal.contains("other settings: a 1 there, 2 here"), "{refusal}");
    }
}
