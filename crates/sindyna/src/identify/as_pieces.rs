//! Readings of the log of a disturbed system told apart by what its equations miss of pieces.

use sindyna_core::FitError;
use sindyna_sindy::Identified;

use super::ahead::{clearly_least, median};
use super::as_read::recordings_of;
use super::asked::Asked;
use super::likeliest::{ROUGHLY, likeliest, near};
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

/// The reading near `from`, whose inputs act between rows, of which equations like those `found` miss least, if they clearly miss less of it; `from` if there is none.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn between_rows<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    found: &Identified,
    (from, margins): (Reading, (usize, usize)),
    asked: &Asked<'_, E>,
) -> Result<Reading, E> {
    let beside = |reading: Reading| misfits(log, kept, found, (&[from, reading], margins), asked);
    let Some(pieces) = beside(from)?.map(|misfits| misfits[0].len()) else { return Ok(from) };
    let at = |rows: f64| Reading { rows, ..from };
    let score = |rows: f64| {
        let logarithms = |misfits: Vec<Vec<f64>>| misfits[1].iter().map(|misfit| misfit.ln()).sum::<f64>();
        Ok::<_, E>(beside(at(rows))?.map_or(f64::INFINITY, logarithms))
    };
    let (rows, _) = likeliest((from.rows, ROUGHLY), near(from.rows), pieces as f64, score)?;
    let reading = at(rows);
    let is_clear = |misfits: Vec<Vec<f64>>| clearly_least(&[&misfits[0], &misfits[1]]) == Some(1);
    Ok(if beside(reading)?.is_some_and(is_clear) { reading } else { from })
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
