//! A directory that holds a run, written so that no file is ever half there.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use super::Held;
use crate::failure::Failure;

/// The directory of one run. Files appear in it whole or not at all.
#[derive(Debug)]
pub(crate) struct RunDir {
    path: PathBuf,
    _held: Held,
}

impl RunDir {
    /// Makes the directory `path`, which must not exist yet.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
            fs::create_dir_all(parent).with_context(|| format!("cannot make the directory {}", parent.display()))?;
        }
        match fs::create_dir(path) {
            Ok(()) => Ok(Self { path: path.to_owned(), _held: Held::take(path)? }),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(exists(path)),
            Err(e) => Err(anyhow::Error::new(e).context(format!("cannot make {}", path.display())).into()),
        }
    }

    /// Refuses a directory that [`Self::create`] would refuse, before anything else is done.
    pub(crate) fn refuse_existing(path: &Path) -> Result<(), Failure> {
        if path.exists() { Err(exists(path)) } else { Ok(()) }
    }

    /// Makes the first free one of `stem`, `stem-2`, `stem-3`, …
    pub(crate) fn create_numbered(stem: &Path) -> Result<Self, Failure> {
        let name = stem.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let numbered = (2_u32..).map(|number| stem.with_file_name(format!("{name}-{number}")));
        for path in std::iter::once(stem.to_owned()).chain(numbered) {
            match Self::create(&path) {
                // Somebody else may have taken the name in between: the next one, then.
                Err(_) if path.exists() => {}
                result => return result,
            }
        }
        Err(Failure::new(format!("no number is left for {}", stem.display())))
    }

    /// The directory `path` of a run that was cut off, without what a killed process was writing.
    pub(crate) fn reopen(path: &Path) -> Result<Self, Failure> {
        if !path.join("config.toml").is_file() {
            return Err(Failure::new(format!("{} holds no run: there is no config.toml in it", path.display()))
                .hint("`sindyna train TASK` prints the directory of its run"));
        }
        let held = Held::take(path)?;
        sweep(path).with_context(|| format!("cannot tidy {}", path.display()))?;
        Ok(Self { path: path.to_owned(), _held: held })
    }

    /// The file `name`, if there is one.
    pub(crate) fn read(&self, name: &str) -> Option<String> {
        fs::read_to_string(self.path.join(name)).ok()
    }

    /// Where the run is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file `name` under a temporary name, sees it on the disk, and renames it.
    pub(crate) fn write(&self, name: &str, contents: &[u8]) -> io::Result<()> {
        let path = self.path.join(name);
        write_atomic(&path, contents)
            .map_err(|e| io::Error::new(e.kind(), format!("cannot write {}: {e}", path.display())))
    }
}

fn exists(path: &Path) -> Failure {
    Failure::new(format!("{} exists already; a run never overwrites another", path.display()))
        .hint("name another directory with --out, or remove this one")
}

/// How the names of files begin that are not whole yet; whoever is killed leaves one.
const UNFINISHED: &str = ".unfinished-";

/// Whether the file is one that a killed process was writing.
pub(crate) fn is_unfinished(entry: &fs::DirEntry) -> bool {
    entry.file_name().to_string_lossy().starts_with(UNFINISHED)
}

/// Takes away what a killed process was writing in `directory` and below it.
pub(crate) fn sweep(directory: &Path) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            sweep(&entry.path())?;
        } else if is_unfinished(&entry) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Writes the file `path` under a temporary name, sees it on the disk, and renames it.
pub(crate) fn write_atomic(path: &Path, contents: &[u8]) -> io::Result<()> {
    let directory = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(UNFINISHED).tempfile_in(directory)?;
    file.write_all(contents)?;
    file.as_file().sync_all()?;
    // A temporary file is private to its owner; a result is as readable as any other file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
    }
    file.persist(path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_never_overwrites_another() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("runs/a");
        RunDir::create(&path).unwrap().write("x", b"1").unwrap();
        let refusal = RunDir::create(&path).unwrap_err().to_string();
        assert!(refusal.contains("exists already") && refusal.contains("--out"), "{refusal}");
        assert_eq!(RunDir::create_numbered(&path).unwrap().path(), temp.path().join("runs/a-2"));
        assert_eq!(RunDir::create_numbered(&path).unwrap().path(), temp.path().join("runs/a-3"));
        assert_eq!(fs::read(path.join("x")).unwrap(), b"1");
    }

    #[test]
    fn a_run_that_is_not_over_is_not_opened_again() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("a");
        let run = RunDir::create(&path).unwrap();
        run.write("config.toml", b"").unwrap();
        let refusal = RunDir::reopen(&path).unwrap_err().to_string();
        assert!(refusal.contains("at work in"), "{refusal}");
        drop(run);
        assert!(RunDir::reopen(&path).is_ok());
    }

    #[test]
    fn a_failed_write_leaves_no_file() {
        let temp = tempfile::tempdir().unwrap();
        let run = RunDir::create(&temp.path().join("a")).unwrap();
        fs::remove_dir(run.path()).unwrap();
        let failure = run.write("x", b"1").unwrap_err().to_string();
        assert!(failure.contains("cannot write") && failure.contains('x'), "{failure}");
    }
}
