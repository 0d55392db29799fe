//! A training run: its directory and the files in it.

mod directory;
mod events;
mod lock;
mod rollout_csv;
mod summary;

pub use directory::RunDir;
pub use events::EventLog;
pub use lock::DirLock;
pub use rollout_csv::rollout_csv;
pub use summary::{Confirmation, Evaluation, Identification, Prediction, Summary, Timing, Training};
