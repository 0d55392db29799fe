//! What is not known of a delay in parts of rows, or of a lag, and of coefficients because of that.

use sindyna_core::FitError;
use sindyna_core::number::significant;
use sindyna_sindy::{Disturbances, Doubt, Expr, Identified, Model, Refitted};

use super::as_read::is_spoilt;
use super::asked::{Asked, Delay, Lag};
use super::lag::forgotten;
use super::likeliest::{FINELY, likeliest};
use super::looked::Looked;
use super::reading::Reading;
use super::trial::{Structure, TOLD_APART, Trial};
use super::unmeasured::Unmeasured;
use crate::logs::{Log, Note, Samples};

/// Times the time constant of the system, at most, that a lag which takes its place may have, and times this one after which what was before it is forgotten.
const FARTHEST: f64 = 2.0;

/// Times the step by which slopes are told, within which two lags are the same.
const SAME: f64 = 2.0;

/// What was `looked` for and found in `log`, of which `kept` is used, as it is read with `reading`: with the standard error of a delay of a part of a row, or of a lag, in
/// those of coefficients, which are β(τ̂) + dβ/dτ (τ − τ̂). Where another lag explains the data as well the equations are ambiguous.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn with_lateness<E: From<FitError>>(
    looked: Looked,
    (log, kept): (&Log, &Samples),
    reading: Reading,
    asked: &Asked<'_, E>,
) -> Result<Looked, E> {
    let is_lag = reading.lag > 0.0;
    let is_late = |note: &Note| matches!(note, Note::Lagged { .. } | Note::Delayed { .. });
    if !looked.log.notes.iter().any(is_late) {
        return Ok(looked);
    }
    let unmeasured = |note: &Note| match note {
        Note::Unmeasured { rate, of, .. } => Some((rate.clone(), of.clone())),
        _ => None,
    };
    let rates: Vec<(String, String)> = looked.log.notes.iter().filter_map(unmeasured).collect();
    let before = reading.rows.max(0.0).ceil() as usize + 1;
    let margins = (before + if is_lag { forgotten(&kept.data, FARTHEST * reading.lag) } else { 0 }, 1);
    let open = Unmeasured::None;
    let trial = Trial { log, kept, rates: &open, asked, margins, disturbances: Disturbances::Possible };
    let model = looked.found.model.clone();
    let structure = Structure { model: &model, rates: &rates };
    let at = |value: f64| if is_lag { Reading { lag: value, ..reading } } else { Reading { rows: value, ..reading } };
    let again = |value: f64| trial.refitted(structure, at(value), usize::MAX);
    let (value, by) = if is_lag { (reading.lag, FINELY * reading.lag) } else { (reading.rows, FINELY) };
    let (Some(less), Some(here), Some(more)) = (again(value - by)?, again(value)?, again(value + by)?) else {
        return Ok(looked);
    };
    let values = (log.spec.state_dim() * kept.data.n_steps()) as f64;
    let Some(error) = standard_error((&less, &here, &more), by, values) else { return Ok(looked) };
    let slopes =
        more.coefficients.iter().zip(&less.coefficients).map(|(more, less)| error * (more - less) / (2.0 * by));
    let slopes: Vec<f64> = slopes.collect();
    let Looked { found, identifier, log } = looked;
    let mut found = found.depending(&slopes);
    if is_lag {
        let is_other = |tau: f64| (tau - value).abs() > SAME * by;
        for other in time_constants(&model).into_iter().filter(|tau| is_other(*tau)) {
            let near = (other / FARTHEST, other * FARTHEST);
            let misfit = |tau: f64| Ok::<_, E>(again(tau)?.map_or(f64::INFINITY, |again| again.misfit));
            let (tau, least) = likeliest((other, FINELY * other), near, values, misfit)?;
            if is_other(tau) && least < here.misfit + TOLD_APART {
                found = ambiguous(found, tau);
                break;
            }
        }
    }
    let log = known_to(log, if is_lag { error } else { error * kept.data.dt() });
    Ok(Looked { found, identifier, log })
}

/// What was `looked` for and found, with a note where equations leave more than noise with a delay or a lag that nobody `asked` for.
pub(super) fn unconfirmed<E>(mut looked: Looked, asked: &Asked<'_, E>) -> Looked {
    let is_open = |note: &Note| match note {
        Note::Delayed { .. } => asked.delay == Delay::Auto,
        Note::Lagged { .. } => asked.lag == Lag::Auto,
        _ => false,
    };
    if is_spoilt(&looked.found) && looked.log.notes.iter().any(is_open) {
        looked.log.notes.push(Note::LateUnconfirmed);
    }
    looked
}

/// The standard error of a parameter from what is missed with it and `by` less and more, of so many `values`: of the mean square of what is left, which is a parabola. `None` if that is none.
fn standard_error((less, here, more): (&Refitted, &Refitted, &Refitted), by: f64, values: f64) -> Option<f64> {
    let square = |other: &Refitted| ((other.misfit - here.misfit) / values).exp() - 1.0;
    let bent = 0.5 * (square(less) + square(more)) / by.powi(2);
    Some((values * bent).recip().sqrt()).filter(|error| error.is_finite() && bent > 0.0)
}

/// Time constants of first order in the linear terms of `model` \[s\]: of states that decay by themselves, and of overdamped positions with their rates.
fn time_constants(model: &Model) -> Vec<f64> {
    let linear = |of: usize, state: usize| -> f64 {
        let entries = model.coefficients(of).iter().filter(|entry| entry.rate.is_none());
        entries.filter(|entry| model.terms()[entry.term] == Expr::Variable(state)).map(|entry| entry.coefficient).sum()
    };
    let n = model.states().len();
    let mut found = Vec::new();
    for v in (0..n).filter(|v| !model.kinematic()[*v]) {
        let damping = -linear(v, v);
        let stiffness: f64 = (0..n)
            .filter(|x| model.kinematic()[*x] && (linear(*x, v) - 1.0).abs() < f64::EPSILON)
            .map(|x| -linear(v, x))
            .sum();
        let root = (damping * damping - 4.0 * stiffness).sqrt();
        let rates = if stiffness == 0.0 { vec![damping] } else { vec![0.5 * (damping + root), 0.5 * (damping - root)] };
        found.extend(rates.into_iter().filter(|rate| *rate > 0.0).map(f64::recip));
    }
    found
}

/// `found`, of which the data do not tell whether the lag is `other` \[s\].
fn ambiguous(mut found: Identified, other: f64) -> Identified {
    for (equation, _) in found.report.equations.iter_mut().zip(found.model.kinematic()).filter(|(_, rate)| !**rate) {
        equation.reached_floor = false;
        equation.doubt = equation.doubt.or(Some(Doubt::OtherLag));
    }
    found.report.warnings.push(format!(
        "a lag of the inputs of {} s, with other coefficients, explains the data as well: the time constants of the actuator and the system may be exchanged",
        significant(other, 4)
    ));
    found
}

/// `log` with a note of its delay or lag that is known to `error`.
fn known_to(mut log: Log, error: f64) -> Log {
    let is_lag = log.notes.iter().any(|note| matches!(note, Note::Lagged { .. }));
    for note in &mut log.notes {
        match note {
            Note::Lagged { deviation, .. } => *deviation = Some(error),
            Note::Delayed { deviation, .. } if !is_lag => *deviation = Some(error),
            _ => {}
        }
    }
    log
}
