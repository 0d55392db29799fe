//! A directory that holds a run, written so that no file is ever half there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::DirLock;
use crate::{RecordError, is_unfinished, save, sweep};

/// The directory of one run. Files appear in it whole or not at all.
#[derive(Debug)]
pub struct RunDir {
    path: PathBuf,
    _lock: DirLock,
}

impl RunDir {
    /// Makes the directory `path` with `files` in it, written in their order; what is to be written later comes after them.
    ///
    /// The directory must not exist yet, or hold nothing but what a process left that was killed while it wrote the same `files`.
    ///
    /// # Errors
    /// [`RecordError::Exists`], [`RecordError::InUse`], [`RecordError::Io`].
    pub fn create(path: &Path, files: &[(&str, Vec<u8>)]) -> Result<Self, RecordError> {
        match Self::claim(path, files)? {
            Claim::Ours(dir) => dir.begun(files),
            Claim::Taken(why) => Err(why),
        }
    }

    /// Refuses a directory that [`Self::create`] would refuse for any contents of files called `names`, before anything else is done.
    ///
    /// # Errors
    /// [`RecordError::Exists`].
    pub fn refuse_existing(path: &Path, names: &[&str]) -> Result<(), RecordError> {
        let begun = &names[..names.len().saturating_sub(1)];
        let left = |entry: &fs::DirEntry| begun.iter().any(|name| entry.file_name() == *name);
        if !path.exists() || holds_only(path, left) { Ok(()) } else { Err(exists(path)) }
    }

    /// Makes the first free one of `stem`, `stem-2`, `stem-3`, …, with `files` in it as [`Self::create`] does.
    ///
    /// # Errors
    /// [`RecordError::Io`].
    pub fn create_numbered(stem: &Path, files: &[(&str, Vec<u8>)]) -> Result<Self, RecordError> {
        let name = stem.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let numbered = (2_u32..).map(|number| stem.with_file_name(format!("{name}-{number}")));
        for path in std::iter::once(stem.to_owned()).chain(numbered) {
            if let Claim::Ours(dir) = Self::claim(&path, files)? {
                return dir.begun(files);
            }
        }
        Err(RecordError::NoNumberLeft { path: stem.to_owned() })
    }

    /// The directory `path`, if it is new or was left before the last of `files` was in it: then the record had not begun.
    fn claim(path: &Path, files: &[(&str, Vec<u8>)]) -> Result<Claim, RecordError> {
        if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
            fs::create_dir_all(parent).map_err(RecordError::io("make the directory", parent))?;
        }
        match fs::create_dir(path) {
            Ok(()) => {}
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(RecordError::io("make", path)(e)),
        }
        let lock = match DirLock::take(path) {
            Ok(lock) => lock,
            Err(why) => return Ok(Claim::Taken(why)),
        };
        let begun = &files[..files.len().saturating_sub(1)];
        let same = |entry: &fs::DirEntry| {
            let file = begun.iter().find(|(name, _)| entry.file_name() == *name);
            file.is_some_and(|(_, contents)| fs::read(entry.path()).is_ok_and(|found| found == *contents))
        };
        if !holds_only(path, same) {
            return Ok(Claim::Taken(exists(path)));
        }
        sweep(path)?;
        Ok(Claim::Ours(Self { path: path.to_owned(), _lock: lock }))
    }

    fn begun(self, files: &[(&str, Vec<u8>)]) -> Result<Self, RecordError> {
        files.iter().try_for_each(|(name, contents)| self.write(name, contents))?;
        Ok(self)
    }

    /// The directory `path` of a run that was cut off, without what a killed process was writing.
    ///
    /// # Errors
    /// [`RecordError::NotARun`], [`RecordError::InUse`].
    pub fn reopen(path: &Path) -> Result<Self, RecordError> {
        if !path.join("config.toml").is_file() {
            return Err(RecordError::NotARun { path: path.to_owned() });
        }
        let lock = DirLock::take(path)?;
        sweep(path)?;
        Ok(Self { path: path.to_owned(), _lock: lock })
    }

    /// The file `name`, if there is one.
    #[must_use]
    pub fn read(&self, name: &str) -> Option<String> {
        fs::read_to_string(self.path.join(name)).ok()
    }

    /// Where the run is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file `name` under a temporary name, sees it on the disk, and renames it.
    ///
    /// # Errors
    /// [`RecordError::Io`] if there is no room or no right to write.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), RecordError> {
        save(&self.path.join(name), contents)
    }
}

/// Whether a directory can be had.
enum Claim {
    Ours(RunDir),
    /// It is somebody else's, and why.
    Taken(RecordError),
}

/// Whether the directory `path` holds nothing but files that a killed process was writing, and those that `known` knows.
fn holds_only(path: &Path, known: impl Fn(&fs::DirEntry) -> bool) -> bool {
    let left = |entry: &fs::DirEntry| {
        entry.file_type().is_ok_and(|kind| kind.is_file()) && (is_unfinished(entry) || known(entry))
    };
    fs::read_dir(path).is_ok_and(|mut entries| entries.all(|entry| entry.is_ok_and(|entry| left(&entry))))
}

fn exists(path: &Path) -> RecordError {
    RecordError::Exists { path: path.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_never_overwrites_another() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("runs/a");
        RunDir::create(&path, &[]).unwrap().write("x", b"1").unwrap();
        let refusal = RunDir::create(&path, &[]).unwrap_err().to_string();
        assert!(refusal.contains("exists already"), "{refusal}");
        for name in ["runs/a-2", "runs/a-3"] {
            let run = RunDir::create_numbered(&path, &files("1")).unwrap();
            assert_eq!(run.path(), temp.path().join(name));
        }
        assert_eq!(fs::read(path.join("x")).unwrap(), b"1");
    }

    /// The files that a run begins with.
    fn files(seed: &str) -> [(&'static str, Vec<u8>); 2] {
        [("task.toml", b"task".to_vec()), ("config.toml", seed.into())]
    }

    #[test]
    fn what_was_left_before_a_record_began_is_taken_over() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("a");
        let check = |left: &[(&str, &str)], taken: bool| {
            drop(fs::remove_dir_all(&path));
            fs::create_dir(&path).unwrap();
            left.iter().for_each(|(name, text)| fs::write(path.join(name), text).unwrap());
            assert_eq!(RunDir::create(&path, &files("1")).is_ok(), taken, "{left:?}");
            let names = fs::read_dir(&path).unwrap().count();
            assert_eq!(names, if taken { 2 } else { left.len() }, "{left:?}");
        };
        check(&[], true);
        check(&[(".unfinished-x", "ta")], true);
        check(&[(".unfinished-x", "1"), ("task.toml", "task")], true);
        check(&[("task.toml", "another")], false);
        check(&[("task.toml", "task"), ("mine", "")], false);
        check(&[("task.toml", "task"), ("config.toml", "1")], false);
        let may = |name: &str| {
            fs::write(path.join(name), "").unwrap();
            RunDir::refuse_existing(&path, &["task.toml", "last"]).is_ok()
        };
        fs::remove_file(path.join("config.toml")).unwrap();
        assert_eq!((may("task.toml"), may("last")), (true, false));
    }

    #[test]
    fn a_run_that_is_not_over_is_not_opened_again() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("a");
        let run = RunDir::create(&path, &[]).unwrap();
        run.write("config.toml", b"").unwrap();
        let refusal = RunDir::reopen(&path).unwrap_err().to_string();
        assert!(refusal.contains("is in use by another sindyna process"), "{refusal}");
        drop(run);
        assert!(RunDir::reopen(&path).is_ok());
    }

    #[test]
    fn a_failed_write_leaves_no_file() {
        let temp = tempfile::tempdir().unwrap();
        let run = RunDir::create(&temp.path().join("a"), &[]).unwrap();
        fs::remove_dir(run.path()).unwrap();
        let failure = run.write("x", b"1").unwrap_err().to_string();
        assert!(failure.starts_with("cannot write ") && failure.ends_with("x"), "{failure}");
    }
}
