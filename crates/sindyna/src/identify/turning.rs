//! States that are angles although neither names nor units say so.

use sindyna_core::{FitError, Kind, Spec};
use sindyna_sindy::{Expr, Identified, Model};

use super::as_read::{as_read, is_spoilt};
use super::asked::Asked;
use super::looked::Looked;
use super::trial::TOLD_APART;
use super::unmeasured::{Choice, Unmeasured, with_rates};
use crate::logs::{Log, Note};

/// What was `looked` up, or the same with states as angles of which equations have other terms than linear ones, where these leave noise alone and explain the data better by `TOLD_APART`: a state without a unit that has a rate, measured or not, may turn.
/// Products with its cosine are candidates of angles alone.
///
/// # Errors
/// [`FitError::Interrupted`] does not lose what was found.
pub(super) fn with_turning<E: From<FitError>>(looked: Looked, asked: &Asked<'_, E>) -> Result<Looked, E> {
    let names = turning(&looked.log, looked.identifier.spec(), &looked.found);
    if names.is_empty() || looked.log.derivatives.is_some() {
        return Ok(looked);
    }
    (asked.say)(&told(&names));
    match as_angles(&looked, &names, asked) {
        Err(_) if !asked.watch.go_on() => Ok(looked.interrupted()),
        Ok(Some(turned)) if is_better(&turned, &looked) => Ok(turned),
        Ok(_) | Err(_) => Ok(looked),
    }
}

/// The states of `log` that could be angles, whose rates are states of the system `spec`, and of which some equation `found` of it has a term that is not linear in them; those that are called as angles also where equations
/// leave what no term explains.
pub(super) fn turning(log: &Log, spec: &Spec, found: &Identified) -> Vec<String> {
    let spoilt = is_spoilt(found);
    let open = |i: &usize| {
        let state = &spec.state[*i];
        let could = log.could_turn.iter().find(|(name, _)| *name == state.name);
        let has_rate = spec.state.iter().any(|s| s.kind == Kind::RateOf(*i));
        let speaks = |named: bool| is_bent(&found.model, *i) || (named && spoilt);
        state.kind == Kind::Plain && has_rate && could.is_some_and(|(_, named)| speaks(*named))
    };
    (0..spec.state_dim()).filter(open).map(|i| spec.state[i].name.clone()).collect()
}

/// What is tried, as it is told.
pub(super) fn told(names: &[String]) -> String {
    format!("trying {} as {}", names.join(" and "), if names.len() > 1 { "angles" } else { "an angle" })
}

/// Whether a term of `model` has the state `i` and is not that alone.
fn is_bent(model: &Model, i: usize) -> bool {
    let terms = model.terms();
    let used = (0..model.states().len()).flat_map(|equation| model.coefficients(equation));
    used.map(|entry| &terms[entry.term]).any(|term| term.has(i) && *term != Expr::Variable(i))
}

/// What is found in the log of `looked` with the states `names` as angles, and with the rates that were not measured in it.
fn as_angles<E: From<FitError>>(looked: &Looked, names: &[String], asked: &Asked<'_, E>) -> Result<Option<Looked>, E> {
    let mut log = looked.log.with_angles(names, false);
    let mut rates = Vec::new();
    log.notes.retain(|note| match note {
        Note::Unmeasured { rate, of, .. } => {
            rates.push((rate.clone(), of.clone()));
            false
        }
        _ => true,
    });
    let kept = (asked.kept)(&log)?;
    if rates.is_empty() {
        let identifier = (asked.identifier)(&log.spec)?;
        let found = as_read(&identifier, &kept, asked.watch)?;
        return Ok(Some(Looked { found, identifier, log }));
    }
    let choice = match asked.unmeasured {
        Unmeasured::Given(_) => Choice { first: None, asked: asked.unmeasured, seen: &[] },
        _ => Choice { first: None, asked: &Unmeasured::Auto, seen: &rates },
    };
    let found = with_rates(&log, &kept, choice, |spec| (asked.identifier)(spec), (asked.watch, &|_| {}))?;
    Ok(found.map(Looked::from))
}

/// Whether equations with angles leave noise alone, and have a better score.
fn is_better(turned: &Looked, given: &Looked) -> bool {
    let scores = turned.found.report.score.zip(given.found.report.score);
    let is_told = scores.is_some_and(|(turned, given)| turned + TOLD_APART < given);
    is_told && !is_spoilt(&turned.found)
}
