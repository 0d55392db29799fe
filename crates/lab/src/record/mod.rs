//! The run record: what a run leaves on the disk.

mod events;
mod rollout_csv;
mod run_dir;
mod summary;

use crate::failure::Failure;

pub(crate) use events::EventLog;
pub(crate) use rollout_csv::rollout_csv;
pub(crate) use run_dir::{RunDir, sweep, write_atomic};
pub(crate) use summary::{Evaluation, Identification, Summary, Timing, Training};

/// `value` as the JSON of a record.
pub(crate) fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, Failure> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}
