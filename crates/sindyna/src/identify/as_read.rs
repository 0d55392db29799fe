//! A log as it was read: its trajectories, and the equations found in them.

use sindyna_core::{Dataset, FitError, Rollout};
use sindyna_sindy::{Doubt, EquationReport, Identified, Identifier, Recording, Watch};

use crate::logs::{Log, Samples};

/// The trajectories of `data`, whose samples were taken at `times` since the start of each \[s\].
#[must_use]
pub fn recordings(data: &Dataset, times: &[Vec<f64>]) -> Vec<Recording> {
    let recording = |(rollout, times): (Rollout<'_>, &Vec<f64>)| {
        Recording::new(times.clone(), rollout.observations.to_owned(), rollout.controls.to_owned())
            .with_intersample(data.intersample())
    };
    data.rollouts().zip(times).map(recording).collect()
}

/// The trajectories of `samples` as they were observed.
pub(super) fn recordings_of(samples: &Samples) -> Vec<Recording> {
    match &samples.times {
        None => Recording::of(&samples.data),
        Some(times) => recordings(&samples.data, times),
    }
}

/// Whether what equations leave is noise, and inputs that are not held leave no less; there may be better ones where the search ended early.
pub(super) fn is_explained(found: &Identified) -> bool {
    let leaves_more = |equation: &EquationReport| match equation.doubt {
        Some(Doubt::Unfinished) => false,
        Some(Doubt::NotHeld) => true,
        _ => equation.is_spoilt(),
    };
    !found.report.equations.iter().any(leaves_more)
}

/// Whether they leave more, or the search ended early.
pub(super) fn is_spoilt(found: &Identified) -> bool {
    let ended_early = |equation: &EquationReport| equation.doubt == Some(Doubt::Unfinished);
    !is_explained(found) || found.report.equations.iter().any(ended_early)
}

/// Whether they leave nothing that another reading of their log may explain: noise alone, and where inputs act no steps left out as outliers, among which those after changes of inputs are where inputs act late.
pub(super) fn is_settled(found: &Identified, log: &Log) -> bool {
    !is_spoilt(found) && (found.report.rows_astray == 0 || log.spec.control_dim() == 0)
}

/// Whether they are those of pieces of a disturbed system.
pub(super) fn is_disturbed(found: &Identified) -> bool {
    found.report.equations.iter().any(|equation| equation.doubt == Some(Doubt::Disturbed))
}

/// Equations found in `kept` as it was read.
pub(super) fn as_read(identifier: &Identifier, kept: &Samples, watch: &Watch<'_>) -> Result<Identified, FitError> {
    match &kept.times {
        None => identifier.identify_watched(&kept.data, watch),
        Some(times) => identifier.identify_recordings_watched(&recordings(&kept.data, times), watch),
    }
}
