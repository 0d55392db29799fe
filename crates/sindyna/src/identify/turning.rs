//! States that are angles although neither names nor units say so.

use sindyna_core::{FitError, Spec};

use super::as_read::{as_read, is_spoilt};
use super::asked::Asked;
use super::looked::Looked;
use super::trial::{EFFORT, TOLD_APART};
use super::turnable::{angles_of, could_turn, told, turning};
use super::unmeasured::{Choice, Unmeasured, with_rates};
use crate::logs::Note;

/// What was `looked` up, or the same with states as angles of which equations have other terms than linear ones, where these leave noise alone and explain the data better by `TOLD_APART`: a state without a unit may turn that has a rate, measured or not, or whose rate does not depend on it.
/// Products with its cosine are candidates of angles alone.
///
/// # Errors
/// [`FitError::Interrupted`] does not lose what was found.
pub(super) fn with_turning<E: From<FitError>>(looked: Looked, asked: &Asked<'_, E>) -> Result<Looked, E> {
    if looked.log.derivatives.is_some() {
        return Ok(looked);
    }
    let (spec, found) = (looked.identifier.spec(), &looked.found);
    let choices = turning(&looked.log, spec, found);
    let all: Vec<String> = could_turn(&looked.log, spec, &found.model).map(|i| spec.state[i].name.clone()).collect();
    // Of a mechanism one coordinate may turn with another one, of which no equation has terms.
    let is_more = is_spoilt(found) && choices.last().is_some_and(|last| *last != all);
    for names in choices.into_iter().chain(is_more.then_some(all)) {
        (asked.say)(&told(&names));
        match as_angles(&looked, &names, asked) {
            Err(_) if !asked.watch.go_on() => return Ok(looked.interrupted()),
            Ok(Some(found)) if is_better(&found, &looked) => {
                let angles = angles_of(names.clone(), found.identifier.spec(), &found.found.model);
                let fewer =
                    if angles.len() < names.len() { as_angles(&looked, &angles, asked).ok().flatten() } else { None };
                return Ok(fewer.filter(|fewer| is_better(fewer, &looked)).unwrap_or(found));
            }
            Ok(_) | Err(_) => {}
        }
    }
    Ok(looked)
}

/// What is found in the log of `looked` with the states `names` as angles, and with the rates that were not measured in it.
fn as_angles<E: From<FitError>>(looked: &Looked, names: &[String], asked: &Asked<'_, E>) -> Result<Option<Looked>, E> {
    // What is explained without angles is searched for a clearer account alone.
    let effort = if is_spoilt(&looked.found) { 1.0 } else { EFFORT };
    let identifier = |spec: &Spec| Ok::<_, E>((asked.identifier)(spec)?.with_less_effort(effort));
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
        let identifier = identifier(&log.spec)?;
        let found = as_read(&identifier, &kept, asked.watch)?;
        return Ok(Some(Looked { found, identifier, log }));
    }
    let choice = match asked.unmeasured {
        Unmeasured::Given(_) => Choice { first: None, asked: asked.unmeasured, seen: &[] },
        _ => Choice { first: None, asked: &Unmeasured::Auto, seen: &rates },
    };
    let found = with_rates(&log, &kept, choice, identifier, (asked.watch, &|_| {}))?;
    Ok(found.map(Looked::from))
}

/// Whether equations with angles leave noise alone, and those without do not or have a worse score.
fn is_better(turned: &Looked, given: &Looked) -> bool {
    let scores = turned.found.report.score.zip(given.found.report.score);
    let is_told = scores.is_some_and(|(turned, given)| turned + TOLD_APART < given);
    !is_spoilt(&turned.found) && (is_told || is_spoilt(&given.found))
}
