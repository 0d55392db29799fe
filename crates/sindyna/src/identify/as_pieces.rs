//! Readings of the log of a disturbed system told apart by what its equations miss of pieces.

use sindyna_core::FitError;
use sindyna_sindy::Identified;

use super::ahead::{clearly_least, median};
use super::as_read::recordings_of;
use super::asked::Asked;
use super::readings::Reading;
use crate::logs::{Log, Samples};

/// The reading among `others` of which equations like those `found` miss least in most pieces, if that is clearly less than of the log as it stands. Steps within the `margins` of each trajectory are not used.
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
    let identifier = (asked.identifier)(&log.spec)?;
    let of = |reading: &Reading| recordings_of(&identifier, &reading.samples(kept, margins, usize::MAX)?);
    let all = std::iter::once(&Reading::GIVEN).chain(others).map(of).collect::<Result<Vec<_>, _>>()?;
    let misfits = identifier.misfits_of_pieces(&found.model, &all, asked.watch)?;
    if !asked.watch.go_on() {
        return Err(FitError::Interrupted.into());
    }
    let Some(misfits) = misfits else { return Ok(None) };
    let best = (1..misfits.len()).min_by(|&a, &b| median(&misfits[a]).total_cmp(&median(&misfits[b])));
    let clear = best.filter(|&best| clearly_least(&[&misfits[0], &misfits[best]]) == Some(1));
    Ok(clear.map(|best| others[best - 1]))
}
