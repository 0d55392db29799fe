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
    /// Makes the directory `path` with `files` in it, written in their order; what is to be written later comes after them.
    ///
    /// The directory must not exist yet, or hold nothing but what a process left that was killed while it wrote the same `files`.
    pub(crate) fn create(path: &Path, files: &[(&str, Vec<u8>)]) -> Result<Self, Failure> {
        match Self::claim(path, files)? {
            Claim::Ours(dir) => dir.begun(files),
            Claim::Taken(why) => Err(why),
        }
    }

    /// Refuses a directory that [`Self::create`] would refuse for any contents of files called `names`, before anything else is done.
    pub(crate) fn refuse_existing(path: &Path, names: &[&str]) -> Result<(), Failure> {
        let begun = &names[..names.len().saturating_sub(1)];
        let left = |entry: &fs::DirEntry| begun.iter().any(|name| entry.file_name() == *name);
        if !path.exists() || holds_only(path, left) { Ok(()) } else { Err(exists(path)) }
    }

    /// Makes the first free one of `stem`, `stem-2`, `stem-3`, …, with `files` in it as [`Self::create`] does.
    pub(crate) fn create_numbered(stem: &Path, files: &[(&str, Vec<u8>)]) -> Result<Self, Failure> {
        let name = stem.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let numbered = (2_u32..).map(|number| stem.with_file_name(format!("{name}-{number}")));
        for path in std::iter::once(stem.to_owned()).chain(numbered) {
            if let Claim::Ours(dir) = Self::claim(&path, files)? {
                return dir.begun(files);
            }
        }
        Err(Failure::new(format!("no number is left for {}", stem.display())))
    }

    /// The directory `path`, if it is new or was left before the last of `files` was in it: then the record had not begun.
    fn claim(path: &Path, files: &[(&str, Vec<u8>)]) -> Result<Claim, Failure> {
        if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
            fs::create_dir_all(parent).with_context(|| format!("cannot make the directory {}", parent.display()))?;
        }
        match fs::create_dir(path) {
            Ok(()) => {}
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(anyhow::Error::new(e).context(format!("cannot make {}", path.display())).into()),
        }
        let held = match Held::take(path) {
            Ok(held) => held,
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
        sweep(path).with_context(|| format!("cannot tidy {}", path.display()))?;
        Ok(Claim::Ours(Self { path: path.to_owned(), _held: held }))
    }

    fn begun(self, files: &[(&str, Vec<u8>)]) -> Result<Self, Failure> {
        files.iter().try_for_each(|(name, contents)| self.write(name, contents))?;
        Ok(self)
    }

    /// The directory `path` of a run that was cut off, without what a killed process was writing.
    pub(crate) fn reopen(path: &Path) -> Result<Self, Failure> {
        if !path.join("config.toml").is_file() {
            return Err(Failure::new(format!("{} holds no run: there is no config.toml in it", path.display()))
                .hint("`sindyna train TASK` prints the directory of its run; killed before that file was there, it is given again"));
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

/// Whether a directory can be had.
enum Claim {
    Ours(RunDir),
    /// It is somebody else's, and why.
    Taken(Failure),
}

/// Whether the directory `path` holds nothing but files that a killed process was writing, and those that `known` knows.
fn holds_only(path: &Path, known: impl Fn(&fs::DirEntry) -> bool) -> bool {
    let left = |entry: &fs::DirEntry| {
        entry.file_type().is_ok_and(|kind| kind.is_file()) && (is_unfinished(entry) || known(entry))
    };
    fs::read_dir(path).is_ok_and(|mut entries| entries.all(|entry| entry.is_ok_and(|entry| left(&entry))))
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
    let mut builder = tempfile::Builder::new();
    // A temporary file is private to its owner; a result is as readable as any other file, as the umask says.
    #[cfg(unix)]
    let mode = {
        use std::os::unix::fs::PermissionsExt as _;
        fs::Permissions::from_mode(0o666)
    };
    #[cfg(unix)]
    builder.permissions(mode);
    let mut file = builder.prefix(UNFINISHED).tempfile_in(directory)?;
    file.write_all(contents)?;
    file.as_file().sync_all()?;
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
        RunDir::create(&path, &[]).unwrap().write("x", b"1").unwrap();
        let refusal = RunDir::create(&path, &[]).unwrap_err().to_string();
        assert!(refusal.contains("exists already") && refusal.contains("--out"), "{refusal}");
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
        assert!(refusal.contains("at work in"), "{refusal}");
        drop(run);
        assert!(RunDir::reopen(&path).is_ok());
    }

    #[test]
    fn a_failed_write_leaves_no_file() {
        let temp = tempfile::tempdir().unwrap();
        let run = RunDir::create(&temp.path().join("a"), &[]).unwrap();
        fs::remove_dir(run.path()).unwrap();
        let failure = run.write("x", b"1").unwrap_err().to_string();
        assert!(failure.contains("cannot write") && failure.contains('x'), "{failure}");
    }
}
