//! One process at a time in a directory.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::failure::Failure;

/// A directory that nobody else works in. The lock ends with the process, however that ends.
#[derive(Debug)]
pub(crate) struct Held {
    /// Locked, where there are such locks: not every file system has them, nor every system for directories.
    _directory: Option<File>,
}

impl Held {
    /// Takes the directory `path`, which must be there.
    pub(crate) fn take(path: &Path) -> Result<Self, Failure> {
        let Ok(directory) = File::open(path) else { return Ok(Self { _directory: None }) };
        match directory.try_lock() {
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Self { _directory: Some(directory) }),
            Err(TryLockError::WouldBlock) => {
                Err(Failure::new(format!("another sindyna is at work in {}", path.display()))
                    .hint("wait for it, or name another directory"))
            }
        }
    }
}
