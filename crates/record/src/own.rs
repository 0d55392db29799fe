//! Files that the user names: new ones, or what sindyna wrote there before, and never anything else.

use std::fs::{self, File, FileType};
use std::io::{self, Read as _};
use std::path::Path;

use crate::{RecordError, save};

/// Where the user said that a result goes.
#[derive(Debug, Clone, Copy)]
pub struct Own<'a> {
    /// The file.
    pub path: &'a Path,
    /// What it is, such as `report`.
    pub what: &'a str,
}

impl Own<'_> {
    /// Writes `contents` whole or not at all, where nothing is or what [`Self::check`] lets pass.
    ///
    /// # Errors
    /// [`RecordError::NotOwn`], [`RecordError::Io`].
    pub fn save(self, contents: &[u8]) -> Result<(), RecordError> {
        self.check(contents)?;
        save(self.path, contents)
    }

    /// Refuses a place with anything but a regular file whose first line is that of `contents`: all that sindyna writes tells
    /// there what it is.
    ///
    /// # Errors
    /// [`RecordError::NotOwn`], [`RecordError::Io`].
    pub fn check(self, contents: &[u8]) -> Result<(), RecordError> {
        if !self.is_there()? {
            return Ok(());
        }
        let first = contents.split_inclusive(|byte| *byte == b'\n').next().unwrap_or_default();
        let mut found = Vec::new();
        File::open(self.path)
            .and_then(|file| file.take(first.len() as u64).read_to_end(&mut found))
            .map_err(RecordError::io("read", self.path))?;
        if found == first { Ok(()) } else { Err(self.refusal(&format!("exists and is not {}", self.what))) }
    }

    /// As [`Self::save`], for what has no first line: a file that is there already must hold `mark`.
    ///
    /// # Errors
    /// [`RecordError::NotOwn`], [`RecordError::Io`].
    pub fn save_marked(self, contents: &[u8], mark: &[u8]) -> Result<(), RecordError> {
        if self.is_there()? {
            let found = fs::read(self.path).map_err(RecordError::io("read", self.path))?;
            if !found.windows(mark.len().max(1)).any(|window| window == mark) {
                return Err(self.refusal(&format!("exists and is not {}", self.what)));
            }
        }
        save(self.path, contents)
    }

    /// Whether there is a file; refuses anything else.
    fn is_there(self) -> Result<bool, RecordError> {
        let kind = match fs::symlink_metadata(self.path) {
            Ok(found) => found.file_type(),
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(false),
            Err(e) => return Err(RecordError::io("look at", self.path)(e)),
        };
        if kind.is_file() { Ok(true) } else { Err(self.refusal(&format!("is {}, not a file", name_of(kind)))) }
    }

    fn refusal(self, why: &str) -> RecordError {
        RecordError::NotOwn { path: self.path.to_owned(), why: why.to_owned() }
    }
}

/// What stands where a file should be.
fn name_of(kind: FileType) -> &'static str {
    if kind.is_dir() {
        "a directory"
    } else if kind.is_symlink() {
        "a symbolic link"
    } else {
        "a device, a pipe or a socket"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_lines_is_known_by_its_mark() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("a.onnx");
        let own = Own { path: &path, what: "an export" };
        own.save_marked(b"\x08\x08\x12by sindyna\n1", b"by sindyna").unwrap();
        own.save_marked(b"\x08\x09\x12by sindyna\n2", b"by sindyna").unwrap();
        fs::write(&path, b"\x08\x08\x12by pytorch").unwrap();
        let refusal = own.save_marked(b"\x08\x09\x12by sindyna", b"by sindyna").unwrap_err().to_string();
        assert!(refusal.contains("exists and is not an export"), "{refusal}");
    }

    #[test]
    fn only_what_begins_as_the_new_contents_do_is_written_over() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("a.md");
        let own = Own { path: &path, what: "a report" };
        own.save(b"# Report\n\none\n").unwrap();
        own.save(b"# Report\n\nanother\n").unwrap();
        for mine in [&b"# Reports\n"[..], b"# Rep", b"", b"\xff\xfe"] {
            fs::write(&path, mine).unwrap();
            let refusal = own.save(b"# Report\n").unwrap_err().to_string();
            assert!(refusal.contains("exists and is not a report"), "{refusal}");
            assert_eq!(fs::read(&path).unwrap(), mine);
        }
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        assert!(own.save(b"# Report\n").unwrap_err().to_string().contains("is a directory, not a file"));
    }
}
