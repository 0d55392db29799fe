//! Why a run ended without a result.

use std::io;

use sindyna_core::{CheckpointError, EnvError, FitError, Unseen};

use crate::ScheduleError;
use crate::collect::CollectError;

/// Why a run ended without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DynaError {
    /// No run can have the schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// The system failed.
    #[error("collecting real data failed")]
    Collect(#[source] CollectError),
    /// No model could be made of the data.
    #[error("identification failed")]
    Fit(#[from] FitError),
    /// Rollouts cannot branch off from states that are not seen.
    #[error(transparent)]
    Unseen(#[from] Unseen),
    /// A trial in the model failed.
    #[error("a trial in the model failed")]
    Trial(#[source] EnvError),
    /// Bytes are no checkpoint of such a run.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// What was found could not be written down.
    #[error("recording failed")]
    Record(#[source] io::Error),
}

impl DynaError {
    /// What went wrong with the system or in a trial, if it was that.
    #[must_use]
    pub fn environment(&self) -> Option<&EnvError> {
        match self {
            Self::Collect(CollectError::Environment(error)) | Self::Trial(error) => Some(error),
            _ => None,
        }
    }
}

impl From<CollectError> for DynaError {
    fn from(error: CollectError) -> Self {
        Self::Collect(error)
    }
}

impl From<io::Error> for DynaError {
    fn from(error: io::Error) -> Self {
        Self::Record(error)
    }
}
