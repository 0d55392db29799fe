//! Delays in parts of rows, and lags, of inputs: fitted with the equations, as they change these gradually.

use sindyna_core::FitError;

use super::lag::forgotten;
use super::likeliest::{FINELY, ROUGHLY, likeliest, near};
use super::reading::Reading;
use super::readings::TOLD_APART;
use super::trial::{Trial, Tried};

/// Times as many steps tell a delay or a lag, and searches with one, at most.
const MORE: usize = 5;
const ROUNDS: usize = 5;

/// Lag that is tried first where inputs do not seem late, as part of a row, and by which part of it lags are changed at first.
const SHORTEST: f64 = 0.5;
const BY: f64 = 0.5;

/// Part of the first inputs by which what had been delivered before is changed at first.
const BEFORE: f64 = 4.0;

/// Times the first lag, at most.
const LONGEST: f64 = 4.0;

/// What is found with inputs that act between rows, near the delay of what was `tried`; `None` if no such delay is clearly better.
pub(super) fn between_rows<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    tried: &Tried,
) -> Result<Option<Tried>, E> {
    let reading = delayed_as(trial, steps, tried, ROUGHLY)?;
    if reading == tried.reading { Ok(None) } else { settled(trial, steps, reading) }
}

/// What is found near the delay of `from`: the likeliest delay with the equations that are found there, and what is found with that, until the delay stays.
pub(super) fn settled<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    from: Reading,
) -> Result<Option<Tried>, E> {
    let mut by = FINELY;
    until_settled(trial, steps, from, |best| {
        let finer = delayed_as(trial, MORE * steps, best, by)?;
        by = (finer.rows - best.reading.rows).abs();
        Ok(finer)
    })
}

/// What is found with inputs that act through a lag, where those of what was `tried` may be late because of one; `None` unless that explains all.
pub(super) fn lagged<E: From<FitError>>(trial: &Trial<'_, E>, steps: usize, tried: &Tried) -> Result<Option<Tried>, E> {
    let late = tried.reading.rows.max(1.0) * trial.log.spec.dt;
    let (first, last) = trial.margins;
    let from_the_start = trial;
    let trial = Trial { margins: (first + forgotten(&trial.kept.data, late), last), ..*trial };
    let reading = lagged_as(&trial, steps, tried)?;
    if reading == tried.reading {
        return Ok(None);
    }
    let refined = |from: Reading| {
        until_settled(&trial, steps, from, |best| {
            let reading = lagged_as(&trial, MORE * steps, best)?;
            started_as(from_the_start, steps, best, reading)
        })
    };
    let Some(found) = refined(reading)? else { return Ok(None) };
    if found.explained {
        return Ok(Some(found));
    }
    // Wrong terms make up for a wrong lag, and keep it: others are searched with terms of their own.
    let Reading { lag, .. } = found.reading;
    let mut explained: Option<Tried> = None;
    let score = |lag: f64| {
        if explained.is_none() {
            let other = trial.first(Reading { lag, ..found.reading }, steps)?;
            let score = other.as_ref().map_or(f64::INFINITY, |other| other.score);
            explained = other.filter(|other| other.explained);
            return Ok(score);
        }
        // What explains all ends the search.
        Ok::<_, E>(f64::INFINITY)
    };
    likeliest((lag, FINELY * lag), (0.0, LONGEST * lag), values(&trial, steps), score)?;
    explained.map(|found| refined(found.reading)).transpose().map(Option::flatten)
}

/// What is found with `from`, and with what `next` makes of it, until it stays.
fn until_settled<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    from: Reading,
    mut next: impl FnMut(&Tried) -> Result<Reading, E>,
) -> Result<Option<Tried>, E> {
    let Some(mut best) = trial.first(from, steps)? else { return Ok(None) };
    for _ in 0..ROUNDS {
        let finer = next(&best)?;
        if finer == best.reading {
            break;
        }
        // Terms may make up for what is left to explain of a parameter that is nearly right.
        match trial.first(finer, steps)? {
            Some(found) if found.explained || !best.explained => best = found,
            _ => break,
        }
    }
    Ok(Some(best))
}

/// How inputs act with equations as those that were `tried`, near the delay of these, which is changed by this part of a row at first; as there where no delay is clearly better.
fn delayed_as<E: From<FitError>>(trial: &Trial<'_, E>, steps: usize, tried: &Tried, by: f64) -> Result<Reading, E> {
    let from = tried.reading;
    let at = |rows: f64| Reading { rows, ..from };
    let misfit = |rows: f64| trial.misfit(tried, at(rows), steps);
    let (rows, best) = likeliest((from.rows, by), near(from.rows), values(trial, steps), misfit)?;
    Ok(if best + TOLD_APART < misfit(from.rows)? { at(rows) } else { from })
}

/// How inputs act with equations as those that were `tried`, through a lag with which they are about as late, after delays of whole rows; as there where no lag is clearly better.
fn lagged_as<E: From<FitError>>(trial: &Trial<'_, E>, steps: usize, tried: &Tried) -> Result<Reading, E> {
    let dt = trial.log.spec.dt;
    let Reading { rows: delay, lag, .. } = tried.reading;
    let late = delay + lag / dt;
    let given = trial.misfit(tried, tried.reading, steps)?;
    let (mut best, mut least) = (tried.reading, f64::INFINITY);
    for rows in (0..=late as usize).map(|rows| rows as f64) {
        let at = |lag: f64| Reading { rows, lag: lag * dt, ..tried.reading };
        let from = (late - rows).max(SHORTEST);
        let misfit = |lag: f64| trial.misfit(tried, at(lag), steps);
        let (lag, now) = likeliest((from, BY * from), (0.0, LONGEST * from), values(trial, steps), misfit)?;
        if now >= least {
            break;
        }
        (best, least) = (at(lag), now);
    }
    Ok(if least + TOLD_APART < given { best } else { tried.reading })
}

/// What `reading` is with inputs that had been delivered to some part where the trajectories begin, with equations as those that were `tried`.
fn started_as<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    tried: &Tried,
    reading: Reading,
) -> Result<Reading, E> {
    let at = |settled: f64| Reading { settled, ..reading };
    let misfit = |settled: f64| trial.misfit(tried, at(settled), steps);
    let (settled, best) =
        likeliest((reading.settled, BEFORE), (f64::NEG_INFINITY, f64::INFINITY), values(trial, steps), misfit)?;
    Ok(if best + TOLD_APART < misfit(reading.settled)? { at(settled) } else { reading })
}

/// How many values so many steps measure.
fn values<E>(trial: &Trial<'_, E>, steps: usize) -> f64 {
    (trial.log.spec.state_dim() * steps.min(trial.kept.data.n_steps())) as f64
}
