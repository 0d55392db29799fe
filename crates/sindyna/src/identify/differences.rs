//! States that are difference quotients of others: they tell nothing that these do not, and their errors are not independent.

use sindyna_core::{Certainty, FitError, Rollout, Scheme};
use sindyna_sindy::{Form, Identified};

use super::as_read::as_read;
use super::asked::Asked;
use super::trial::{EFFORT, STEPS};
use super::unmeasured::Unmeasured;
use crate::logs::{Difference, Log, Quotient, Samples};

/// The states of `log` that are difference quotients of others, as such that were not measured, besides those that were `asked` for. None if that was asked, or a simulator
/// moves positions by just these rates: equations are adequate for a part of the log so.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn not_measured<E: From<FitError>>(log: &Log, asked: &Asked<'_, E>) -> Result<Vec<Difference>, E> {
    let is_asked = |rate: &str| match asked.unmeasured {
        Unmeasured::Given(pairs) => pairs.iter().any(|(name, _)| name == rate),
        _ => false,
    };
    let is_rate_of_measured = |d: &&Difference| !is_asked(&d.rate);
    let found: Vec<Difference> = log.differences.iter().filter(is_rate_of_measured).cloned().collect();
    // Steps at limits are left out one by one, which the path of a rate that was not measured cannot do without.
    let is_limited = log.spec.state.iter().any(|s| s.prior.bounds.0.is_finite() || s.prior.bounds.1.is_finite());
    if found.is_empty() || *asked.unmeasured == Unmeasured::None || log.derivatives.is_some() || is_limited {
        return Ok(Vec::new());
    }
    let may_step = found.iter().all(|d| d.quotient != Quotient::Central);
    if may_step && is_simulated(log, asked)? { Ok(Vec::new()) } else { Ok(found) }
}

/// Whether equations are adequate for a part of `log` as that of a simulator which moves positions by these rates.
fn is_simulated<E: From<FitError>>(log: &Log, asked: &Asked<'_, E>) -> Result<bool, E> {
    let part = (asked.kept)(log)?.first(STEPS);
    for log in log.turned().iter().chain([log]) {
        let found = as_read(&(asked.identifier)(&log.spec)?.with_effort(EFFORT), &part, asked.watch);
        if !asked.watch.go_on() {
            return Err(FitError::Interrupted.into());
        }
        let is_stepped = |form| matches!(form, Form::SemiImplicit { .. } | Form::Continuous(Scheme::Euler));
        // Quotients of a linear system follow a map as long as its input stays: the steps where that changes are not to be left out.
        let explains = |found: Identified| {
            let astray = found.report.rows_astray;
            let all = astray == 0 || 2 * astray < changes(&part);
            all && found.certainty() >= Certainty::Adequate && is_stepped(found.model.form())
        };
        if found.is_ok_and(explains) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Steps with another input than the one before.
fn changes(samples: &Samples) -> usize {
    let of = |rollout: Rollout<'_>| {
        let rows = rollout.controls.rows();
        rows.into_iter().zip(rollout.controls.rows().into_iter().skip(1)).filter(|(one, next)| one != next).count()
    };
    samples.data.rollouts().map(of).sum()
}

/// These states, besides those that were `asked` for.
pub(super) fn besides(found: &[Difference], asked: &Unmeasured) -> Unmeasured {
    let pairs = found.iter().map(|d| (d.rate.clone(), d.of.clone()));
    match asked {
        Unmeasured::Given(given) => Unmeasured::Given(given.iter().cloned().chain(pairs).collect()),
        _ => Unmeasured::Given(pairs.collect()),
    }
}
