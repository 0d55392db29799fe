//! A log as it was read: its trajectories, and the equations found in them.

use sindyna_core::{Dataset, FitError, Rollout};
use sindyna_sindy::{Doubt, EquationReport, Identified, Identifier, Recording, Watch};

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

/// Whether equations leave what none of their terms explains, or are better with inputs that are not held.
pub(super) fn is_spoilt(found: &Identified) -> bool {
    let is = |equation: &EquationReport| equation.is_spoilt() || equation.doubt == Some(Doubt::NotHeld);
    found.report.equations.iter().any(is)
}

/// Whether what equations leave is noise, and no other reading of the inputs leaves less; there may be better ones where the search ended early.
pub(super) fn is_explained(found: &Identified) -> bool {
    let leaves = |equation: &EquationReport| {
        (equation.is_spoilt() && equation.doubt != Some(Doubt::Unfinished)) || equation.doubt == Some(Doubt::NotHeld)
    };
    !found.report.equations.iter().any(leaves)
}

/// Equations found in `kept` as it was read.
pub(super) fn as_read(identifier: &Identifier, kept: &Samples, watch: &Watch<'_>) -> Result<Identified, FitError> {
    match &kept.times {
        None => identifier.identify_watched(&kept.data, watch),
        Some(times) => identifier.identify_recordings_watched(&recordings(&kept.data, times), watch),
    }
}
