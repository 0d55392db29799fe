//! The run record: what a run leaves on the disk.

mod events;
mod lock;
mod own;
mod rollout_csv;
mod run_dir;
mod summary;
mod table_csv;

use std::path::Path;

use anyhow::Context as _;

use crate::failure::Failure;

pub(crate) use events::EventLog;
pub(crate) use lock::Held;
pub(crate) use own::Own;
pub(crate) use rollout_csv::rollout_csv;
use run_dir::write_atomic;
pub(crate) use run_dir::{RunDir, is_unfinished, sweep};
pub(crate) use summary::{Confirmation, Evaluation, Identification, Prediction, Summary, Timing, Training};
pub(crate) use table_csv::{from_csv, to_csv};

/// `value` as the JSON of a record.
pub(crate) fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, Failure> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Writes the file `path` whole or not at all.
pub(crate) fn save(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    write_atomic(path, contents).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(())
}
