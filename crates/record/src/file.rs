//! Files that are there whole or not at all.

use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

use crate::RecordError;

/// How the names of files begin that are not whole yet; whoever is killed leaves one.
const UNFINISHED: &str = ".unfinished-";

/// `value` as the JSON of a record.
///
/// # Errors
/// [`RecordError::Json`] for a value without one, such as a map whose keys are no text.
pub fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, RecordError> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Writes the file `path` under a temporary name, sees it on the disk, and renames it.
///
/// # Errors
/// [`RecordError::Io`] if there is no room or no right to write.
pub fn save(path: &Path, contents: &[u8]) -> Result<(), RecordError> {
    write_atomic(path, contents).map_err(cause).map_err(RecordError::io("write", path))
}

/// What the system said of a temporary file, without the file's name.
#[must_use]
pub fn cause(error: io::Error) -> io::Error {
    if error.get_ref().is_some() { error.kind().into() } else { error }
}

/// Whether the file is one that a killed process was writing.
#[must_use]
pub fn is_unfinished(entry: &fs::DirEntry) -> bool {
    entry.file_name().to_string_lossy().starts_with(UNFINISHED)
}

/// Takes away what a killed process was writing in `directory` and below it.
///
/// # Errors
/// [`RecordError::Io`] if the directory cannot be read or a file not be removed.
pub fn sweep(directory: &Path) -> Result<(), RecordError> {
    sweep_all(directory).map_err(RecordError::io("tidy", directory))
}

fn sweep_all(directory: &Path) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            sweep_all(&entry.path())?;
        } else if is_unfinished(&entry) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

fn write_atomic(path: &Path, contents: &[u8]) -> io::Result<()> {
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
