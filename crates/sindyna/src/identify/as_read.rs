//! A log as it was read: its trajectories, and the equations found in them.

use sindyna_core::{Dataset, FitError, Rollout};
use sindyna_sindy::{EquationReport, Identified, Identifier, Recording, Watch};

use crate::logs::Samples;

/// The trajectories of `data`, whose samples were taken at `times` since the start of each \[s\].
#[must_use]
pub fn recordings(data: &Dataset, times: &[Vec<f64>]) -> Vec<Recording> {
    let recording = |(rollout, times): (Rollout<'_>, &Vec<f64>)| {
        Recording::new(times.clone(), rollout.observations.to_owned(), rollout.controls.to_owned())
            .with_intersample(data.intersample())
    };
    data.rollouts().zip(times).map(recording).collect()
}

/// Whether equations leave what none of their terms explains.
pub(super) fn is_spoilt(found: &Identified) -> bool {
    found.report.equations.iter().any(EquationReport::is_spoilt)
}

/// Equations found in `kept` as it was read.
pub(super) fn as_read(identifier: &Identifier, kept: &Samples, watch: &Watch<'_>) -> Result<Identified, FitError> {
    match &kept.times {
        None => identifier.identify_watched(&kept.data, watch),
        Some(times) => identifier.identify_recordings_watched(&recordings(&kept.data, times), watch),
    }
}
