//! The small files of a comparison's directory.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Request;
use crate::{RecordError, from_csv, json, save, to_csv};

/// The file with what runs depend on besides task, method and seed.
pub const SETTINGS: &str = "compare.toml";

/// The file with what was asked for.
const REQUESTS: &str = "asked.csv";

/// How long a run took, in a file apart from its outcome because no two are the same.
#[derive(Serialize, Deserialize)]
struct Timing {
    wall_seconds: f64,
}

/// The seconds in the file `path`, if it is there.
#[must_use]
pub fn read_seconds(path: &Path) -> Option<f64> {
    Some(serde_json::from_slice::<Timing>(&fs::read(path).ok()?).ok()?.wall_seconds)
}

/// Writes the seconds that a run took into the file `path`.
///
/// # Errors
/// [`RecordError::Io`] if there is no room or no right to write.
pub fn write_seconds(path: &Path, wall_seconds: f64) -> Result<(), RecordError> {
    save(path, &json(&Timing { wall_seconds })?)
}

/// What was asked of the comparison in `root`; nothing if it is older than such records.
///
/// # Errors
/// [`RecordError::Io`], [`RecordError::Malformed`].
pub fn read_requests(root: &Path) -> Result<Vec<Request>, RecordError> {
    let path = root.join(REQUESTS);
    match fs::read_to_string(&path) {
        Ok(text) => from_csv(&text).map_err(|e| RecordError::Malformed { path, source: e.into() }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(RecordError::io("read", path)(error)),
    }
}

/// Writes what was asked of the comparison in `root`.
///
/// # Errors
/// [`RecordError::Io`] if there is no room or no right to write.
pub fn write_requests(root: &Path, requests: &[Request]) -> Result<(), RecordError> {
    save(&root.join(REQUESTS), &to_csv(requests)?)
}
