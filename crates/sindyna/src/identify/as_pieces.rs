//! Readings of the log of a disturbed system told apart by what its equations miss of pieces.

use sindyna_core::FitError;
use sindyna_sindy::Identified;

use super::ahead::{clearly_least, median};
use super::as_read::recordings_of;
use super::asked::Asked;
use super::reading::Reading;
use crate::logs::{Log, Samples};

/// The reading among `others` that changes least of the log as it stands, of those of which equations like those `found` miss about as little of most pieces as of any; `None` if they miss no more of the log as it stands. Steps within the `margins` of each trajectory are not used.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn least_missed<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    found: &Identified,
    (others, margins): (&[Reading], (usize, usize)),
    asked: &Asked<'_, E>,
) -> Result<Option<Reading>, E> {
    let all: Vec<Reading> = std::iter::once(Reading::GIVEN).chain(others.iter().copied()).collect();
    let Some(misfits) = misfits(log, kept, found, (&all, margins), asked)? else { return Ok(None) };
    // Of readings that the best one is not clearly better than, that which is least of a change.
    let best = (0..all.len()).min_by(|&a, &b| median(&misfits[a]).total_cmp(&median(&misfits[b])));
    let as_good = |&i: &usize| best.is_some_and(|best| clearly_least(&[&misfits[i], &misfits[best]]) != Some(1));
    let least = (0..all.len()).filter(as_good).min_by(|&a, &b| all[a].shift().total_cmp(&all[b].shift()));
    Ok(least.map(|least| all[least]).filter(|reading| *reading != Reading::GIVEN))
}

/// What equations like those `found` miss of pieces of `log`, for each reading; `None` if they follow none.
fn misfits<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    found: &Identified,
    (readings, margins): (&[Reading], (usize, usize)),
    asked: &Asked<'_, E>,
) -> Result<Option<Vec<Vec<f64>>>, E> {
    let identifier = (asked.identifier)(&log.spec)?;
    let of = |reading: &Reading| Ok(recordings_of(&reading.samples(kept, margins, usize::MAX)?));
    let all = readings.iter().map(of).collect::<Result<Vec<_>, FitError>>()?;
    let misfits = identifier.misfits_of_pieces(&found.model, &all, asked.watch)?;
    if asked.watch.go_on() { Ok(misfits) } else { Err(FitError::Interrupted.into()) }
}
