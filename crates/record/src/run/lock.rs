//! One process at a time in a directory.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::RecordError;

/// A directory that nobody else works in. The lock ends with the process, however that ends.
#[derive(Debug)]
pub struct DirLock {
    /// Locked, where there are such locks: not every file system has them, nor every system for directories.
    _directory: Option<File>,
}

impl DirLock {
    /// Takes the directory `path`, which must be there.
    ///
    /// # Errors
    /// [`RecordError::InUse`] while another process has it.
    pub fn take(path: &Path) -> Result<Self, RecordError> {
        let Ok(directory) = File::open(path) else { return Ok(Self { _directory: None }) };
        match directory.try_lock() {
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Self { _directory: Some(directory) }),
            Err(TryLockError::WouldBlock) => Err(RecordError::InUse { path: path.to_owned() }),
        }
    }
}
