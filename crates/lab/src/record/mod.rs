//! The run record: what a run leaves on the disk.

mod events;
mod rollout_csv;
mod run_dir;
mod summary;

pub(crate) use events::EventLog;
pub(crate) use rollout_csv::rollout_csv;
pub(crate) use run_dir::RunDir;
pub(crate) use summary::{Evaluation, Identification, Summary, Timing, Training};
