//! Other logs of the system, in which no equation was looked for.

use sindyna_core::{FitError, InterSample};
use sindyna_sindy::Recording;

use super::between::between;
use super::delay::delayed;
use super::lag::{SETTLED, lagged};
use super::looked::Looked;
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
    let lag = looked.log.notes.iter().find_map(|note| match note {
        Note::Lagged { seconds, .. } => Some(*seconds),
        _ => None,
    });
    let mut other = match looked.log.data.intersample() {
        intersample @ (InterSample::Foh | InterSample::Bl) => between(other, intersample, false)?,
        _ => other.clone(),
    };
    if let Some(tau) = lag {
        other = lagged(&other, (tau, SETTLED))?;
    }
    let Log { spec, data, times, .. } = late.map_or_else(|| Ok(other.clone()), |rows| delayed(&other, rows))?;
    let rates: Vec<(String, usize)> = looked.log.notes.iter().filter_map(|note| rate_of(note, &looked.log)).collect();
    if rates.is_empty() {
        return Ok(Samples { data, times, derivatives: None });
    }
    let filled = looked.identifier.filled(&looked.found.model, &hidden(&data, times.as_deref(), &spec, &rates))?;
    Ok(Samples { data: Recording::dataset(&filled, &looked.log.spec)?, times, derivatives: None })
}

/// The rate of which `note` says that it was not measured, and the number of the state in `log` whose rate it is.
fn rate_of(note: &Note, log: &Log) -> Option<(String, usize)> {
    match note {
        Note::Unmeasured { rate, of, .. } => {
            Some((rate.clone(), log.spec.state.iter().position(|state| state.name == *of)?))
        }
        _ => None,
    }
}
