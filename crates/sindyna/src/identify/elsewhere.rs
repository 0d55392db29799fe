//! Other logs of the system, in which no equation was looked for.

use sindyna_core::{FitError, InterSample};
use sindyna_sindy::Recording;

use super::between::linear;
use super::delay::delayed;
use super::hypotheses::Looked;
use super::unmeasured::hidden;
use crate::logs::{Log, Note, Samples};

/// The samples of `other`, read as the log of `looked` was first, as that was read in the end: with inputs that act later, and with the rates that were not
/// measured as the equations tell them.
///
/// # Errors
/// [`FitError`] if inputs that act later cannot be, at its times, or its states are others.
pub(crate) fn elsewhere(other: &Log, looked: &Looked) -> Result<Samples, FitError> {
    let late = looked.log.notes.iter().find_map(|note| match note {
        Note::Delayed { rows, .. } => Some(*rows),
        _ => None,
    });
    let other = late.map_or_else(|| Ok(other.clone()), |rows| delayed(other, rows))?;
    let Log { data, times, .. } = match looked.log.data.intersample() {
        InterSample::Zoh => other,
        InterSample::Foh => linear(&other, false),
    };
    let count = looked.log.spec.observation_dim().saturating_sub(data.observation_dim());
    if count == 0 {
        return Ok(Samples { data, times, derivatives: None });
    }
    let filled = looked.identifier.filled(&looked.found.model, &hidden(&data, times.as_deref(), count))?;
    Ok(Samples { data: Recording::dataset(&filled, &looked.log.spec)?, times, derivatives: None })
}
