//! Delays in parts of rows, and lags, of inputs: fitted with equations, as what these miss changes gradually with them.

use sindyna_core::FitError;

use super::asked::Delay;
use super::likeliest::{FINELY, ROUGHLY, likeliest, near};
use super::reading::Reading;
use super::trial::{Structure, Trial};

/// Lag that is tried first where inputs do not seem late, in rows, and by which part of it lags are changed at first.
const SHORTEST: f64 = 0.5;
const BY: f64 = 0.5;

/// Times the first lag, at most.
const LONGEST: f64 = 4.0;

/// Part of the first inputs by which what had been delivered before is changed at first.
const BEFORE: f64 = 4.0;

/// The reading near `from` whose inputs act between rows of which the equations `of` miss least in so many steps, and that.
pub(super) fn between_rows<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    of: Structure<'_>,
    from: Reading,
) -> Result<(Reading, f64), E> {
    let at = |rows: f64| Reading { rows, ..from };
    let by = if from.rows.fract() == 0.0 { ROUGHLY } else { FINELY };
    let misfit = |rows: f64| trial.misfit(of, at(rows), steps);
    let (rows, least) = likeliest((from.rows, by), near(from.rows), values(trial, steps), misfit)?;
    Ok((at(rows), least))
}

/// The reading whose inputs act through a lag, after a delay of whole rows, together about as late as those of `from`, of which the equations `of` miss least in so many steps, and that.
pub(super) fn lagged<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    of: Structure<'_>,
    from: Reading,
) -> Result<(Reading, f64), E> {
    let dt = trial.log.spec.dt;
    let late = from.rows + from.lag / dt;
    // A delay that was declared is all there is.
    let most = if trial.asked.delay == Delay::Auto { late as usize } else { 0 };
    let (mut best, mut least) = (from, f64::INFINITY);
    for rows in (0..=most).map(|rows| rows as f64) {
        let at = |lag: f64| Reading { rows, lag: lag * dt, ..from };
        let first = (late - rows).max(SHORTEST);
        let misfit = |lag: f64| trial.misfit(of, at(lag), steps);
        let (lag, now) = likeliest((first, BY * first), (0.0, LONGEST * first), values(trial, steps), misfit)?;
        if now >= least {
            break;
        }
        (best, least) = (at(lag), now);
    }
    Ok((best, least))
}

/// The reading near `from` with the delay of a part of a row, or the lag, of which the equations `of`, found with nearly that one, miss least in all steps.
pub(super) fn refined<E: From<FitError>>(trial: &Trial<'_, E>, of: Structure<'_>, from: Reading) -> Result<Reading, E> {
    if from.lag == 0.0 {
        return Ok(between_rows(trial, usize::MAX, of, from)?.0);
    }
    let at = |lag: f64| Reading { lag, ..from };
    let misfit = |lag: f64| trial.misfit(of, at(lag), usize::MAX);
    let near = (from.lag, FINELY * from.lag);
    let (lag, _) = likeliest(near, (0.0, LONGEST * from.lag), values(trial, usize::MAX), misfit)?;
    Ok(at(lag))
}

/// `reading` with inputs that had been delivered to the part where trajectories begin with which the equations `of` miss least.
pub(super) fn started<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    of: Structure<'_>,
    reading: Reading,
) -> Result<Reading, E> {
    let at = |settled: f64| Reading { settled, ..reading };
    let misfit = |settled: f64| trial.misfit(of, at(settled), steps);
    let anything = (f64::NEG_INFINITY, f64::INFINITY);
    let (settled, _) = likeliest((reading.settled, BEFORE), anything, values(trial, steps), misfit)?;
    Ok(at(settled))
}

/// The lag near that of `from` with the least `score` of a search of its own.
pub(super) fn searched<E: From<FitError>>(
    trial: &Trial<'_, E>,
    steps: usize,
    from: Reading,
    score: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(), E> {
    let Reading { lag, .. } = from;
    likeliest((lag, FINELY * lag), (0.0, LONGEST * lag), values(trial, steps), score).map(|_| ())
}

/// How many values so many steps measure.
fn values<E>(trial: &Trial<'_, E>, steps: usize) -> f64 {
    (trial.log.spec.state_dim() * steps.min(trial.kept.data.n_steps())) as f64
}
