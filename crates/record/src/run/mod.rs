//! A training run: its directory and the files in it.

mod directory;
mod episode;
mod events;
mod lock;
mod moments;
mod rollout_csv;
mod summary;

pub use directory::RunDir;
pub use episode::{EpisodeRow, EpisodeTable, Watched, labels_of};
pub use events::EventLog;
pub use lock::DirLock;
pub use moments::Moment;
pub use rollout_csv::{log_csv, rollout_csv};
pub use summary::{
    ChannelRange, Collect, Confirmation, Coverage, Evaluation, Identification, Improvable, PlannerReturn, Prediction,
    Span, Summary, Timing, Training,
};
