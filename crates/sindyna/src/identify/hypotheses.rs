//! What a log may be besides what it says: inputs that act earlier or later, rates that were not measured, steps of a simulator.

use sindyna_core::{FitError, InterSample, Spec};
use sindyna_sindy::{Disturbances, Identified, Identifier};

use super::as_read::{as_read, is_disturbed, is_settled, is_spoilt};
use super::asked::{Asked, Delay, Lag};
use super::between::between;
use super::changed::changed;
use super::delay::delayed;
use super::derivatives::{of_derivatives, predicts_better_if_linear};
use super::differences::{besides, not_measured};
use super::lag::{SETTLED, lagged};
use super::lateness::{unconfirmed, with_lateness};
use super::looked::Looked;
use super::named::with_angles_by_name;
use super::reading::Reading;
use super::readings::{Chosen, told_apart};
use super::turning::with_turning;
use super::unmeasured::{Choice, Rates, Unmeasured, is_better, lone, with_rates};
use crate::logs::{Log, Note, Samples};

/// Equations of the system of `log`: as it was read, and where these leave what no term explains as it may be read too.
///
/// # Errors
/// [`FitError`] if no equations are found in the log as it was read, or as was asked.
pub(crate) fn looked<E: From<FitError>>(log: Log, asked: &Asked<'_, E>) -> Result<Looked, E> {
    let log = match asked.intersample {
        None | Some(InterSample::Zoh) => log,
        Some(intersample) => between(&log, intersample, true)?,
    };
    let log = match asked.delay {
        Delay::Rows(rows) if rows != 0.0 => delayed(&log, rows)?,
        _ => log,
    };
    let log = match asked.lag {
        Lag::Seconds(tau) if tau > 0.0 => lagged(&log, (tau, SETTLED))?,
        _ => log,
    };
    let quotients = not_measured(&log, asked)?;
    if quotients.is_empty() {
        return Ok(unconfirmed(with_turning(as_measured(log, asked)?, asked)?, asked));
    }
    let unmeasured = besides(&quotients, asked.unmeasured);
    let asked = Asked { unmeasured: &unmeasured, ..*asked };
    let looked = as_measured(log.without_measurements(quotients), &asked)?;
    Ok(unconfirmed(with_turning(looked, &asked)?, &asked))
}

/// The same of a `log` whose states were measured, but for those that were `asked` for.
fn as_measured<E: From<FitError>>(log: Log, asked: &Asked<'_, E>) -> Result<Looked, E> {
    let mut log = with_angles_by_name(log, asked)?;
    let kept = (asked.kept)(&log)?;
    let identifier = (asked.identifier)(&log.spec)?;
    if kept.derivatives.is_some() {
        if let Some(found) = of_derivatives(&identifier, &kept, asked.watch)? {
            let is_linear = asked.intersample.is_none() && predicts_better_if_linear(&found.model, &identifier, &kept);
            let log = if is_linear { between(&log, InterSample::Foh, false)? } else { log };
            return Ok(Looked { found, identifier, log });
        }
        log.notes.push(Note::DerivativesUnexplained);
    }
    let is_given = matches!(asked.unmeasured, Unmeasured::Given(_));
    // Steps of a simulator look like inputs that act earlier or later: those are told apart, where they are tried.
    let as_given = if is_given {
        let of = |spec: &Spec| Ok::<_, E>((asked.identifier)(spec)?.with_simulators(!acts(&kept, &log)));
        let choice = Choice { first: None, asked: asked.unmeasured, seen: &[] };
        match with_rates(&log, &kept, choice, of, (asked.watch, asked.say)) {
            Err(interrupted) if !asked.watch.go_on() => return Err(interrupted),
            // Nothing is found of some logs until they are read otherwise.
            found => found.ok().flatten(),
        }
    } else {
        None
    };
    if let Some(rates) = as_given.as_ref().filter(|rates| is_settled(&rates.found, &log)) {
        return Ok(rates.clone().into());
    }
    // Nothing is found of some logs until they are read otherwise.
    let (first, nothing) = match first_look(&identifier, &kept, asked) {
        Err(nothing @ FitError::Regression { .. }) => (None, Some(nothing)),
        first => (first?, None),
    };
    if let Some(found) = first.as_ref().filter(|first| is_settled(first, &log)) {
        return Ok(Looked { found: found.clone(), identifier, log });
    }
    let before = match &first {
        Some(found) => Some(Looked { found: found.clone(), identifier: identifier.clone(), log: log.clone() }),
        None => as_given.clone().map(Looked::from),
    };
    match (before, read_otherwise((log, kept, identifier), (first, nothing), as_given, asked)) {
        // What was found before is not lost.
        (Some(before), Err(_)) if !asked.watch.go_on() => Ok(before.interrupted()),
        (_, looked) => looked,
    }
}

/// The same where `first`, or with rates that were asked for `as_given`, was found in the log as it stands, or `nothing` but that error, and leaves what another reading may explain.
fn read_otherwise<E: From<FitError>>(
    (log, kept, identifier): (Log, Samples, Identifier),
    (first, nothing): (Option<Identified>, Option<FitError>),
    as_given: Option<Rates>,
    asked: &Asked<'_, E>,
) -> Result<Looked, E> {
    let is_spoilt_or_none = first.as_ref().is_none_or(is_spoilt);
    let turned = if is_spoilt_or_none { with_angles(&log, first.as_ref(), asked)? } else { None };
    let (log, kept, identifier, first) = match turned {
        Some((turned, _, identifier, found)) if is_settled(&found, &turned) => {
            return Ok(Looked { found, identifier, log: turned });
        }
        Some((turned, kept, identifier, found)) => (turned, kept, identifier, Some(found)),
        None => (log, kept, identifier, first),
    };
    // Of a system that changed no reading leaves noise alone.
    if let Some(found) = first.as_ref().filter(|first| is_spoilt(first))
        && let Some(warning) = changed(&log, &kept, found, asked)?
    {
        let mut found = found.clone();
        found.report.warnings.push(warning);
        return Ok(Looked { found, identifier, log });
    }
    // Steps of a simulator look like inputs that act earlier or later: they are told apart together.
    let given = as_given.as_ref().map(|rates| &rates.found).filter(|found| !is_spoilt(found));
    let chosen = told_apart(&log, &kept, (first.as_ref(), given), asked)?;
    let is_other = chosen.as_ref().is_some_and(|chosen| chosen.reading != Reading::GIVEN);
    let is_as_given = !is_other && (chosen.is_some() || given.is_some() || !acts(&kept, &log));
    if let Some(rates) = as_given.clone().filter(|_| is_as_given) {
        return Ok(rates.into());
    }
    let explained = match &first {
        _ if given.is_some() => as_given.map(Looked::from),
        Some(first) if !is_spoilt(first) => {
            Some(Looked { found: first.clone(), identifier: identifier.clone(), log: log.clone() })
        }
        _ => None,
    };
    let other = as_chosen((log, kept, identifier), (first, nothing), chosen, asked);
    let Some(explained) = explained else { return other };
    if !asked.watch.go_on() {
        return other;
    }
    let left_out = |looked: &Looked| looked.found.report.rows_astray;
    let explains_more = |other: &Looked| !is_spoilt(&other.found) && left_out(other) < left_out(&explained);
    Ok(other.ok().filter(explains_more).unwrap_or(explained))
}

/// Equations of a log in the reading that was `chosen`, or as it stands, where `first` was found in it so, or `nothing` but that error; with rates that were not measured where this leaves a doubt, and what is not known of a
/// delay or a lag.
fn as_chosen<E: From<FitError>>(
    (log, kept, identifier): (Log, Samples, Identifier),
    found: (Option<Identified>, Option<FitError>),
    chosen: Option<Chosen>,
    asked: &Asked<'_, E>,
) -> Result<Looked, E> {
    let Some(reading) = chosen.as_ref().map(|chosen| chosen.reading).filter(|reading| reading.is_gradual()) else {
        return as_read_so((log, kept, identifier), found, chosen, asked);
    };
    let looked = as_read_so((log.clone(), kept.clone(), identifier), found, chosen, asked)?;
    with_lateness(looked, (&log, &kept), reading, asked)
}

/// The same without that.
fn as_read_so<E: From<FitError>>(
    (log, kept, identifier): (Log, Samples, Identifier),
    (first, nothing): (Option<Identified>, Option<FitError>),
    chosen: Option<Chosen>,
    asked: &Asked<'_, E>,
) -> Result<Looked, E> {
    let otherwise = match chosen.as_ref().map(|chosen| chosen.reading.of(&log)).transpose()?.flatten() {
        Some(log) => {
            let kept = (asked.kept)(&log)?;
            let is_known = chosen.as_ref().is_some_and(|chosen| chosen.disturbed);
            let disturbances = if is_known { Disturbances::Known } else { Disturbances::Possible };
            let identifier = (asked.identifier)(&log.spec)?.with_disturbances(disturbances);
            match first_look(&identifier, &kept, asked) {
                Ok(first) => Some((log, kept, identifier, first)),
                Err(FitError::Interrupted) => return Err(FitError::Interrupted.into()),
                // What was found in a part is none in all.
                Err(_) => None,
            }
        }
        None => None,
    };
    if let Some(nothing) = nothing.filter(|_| otherwise.is_none()) {
        return Err(nothing.into());
    }
    let (mut log, kept, mut identifier, mut first) = otherwise.unwrap_or((log, kept, identifier, first));
    // Disturbances, and a search that was not finished, say nothing of rates that were not measured, unless only positions were, or a part of the log speaks for them.
    let seen = chosen.as_ref().map_or(&[][..], |chosen| &chosen.rates);
    if let Some(chosen) = chosen.as_ref().filter(|chosen| !chosen.angles.is_empty()) {
        let turned = log.with_angles(&chosen.angles, false);
        let own = (asked.identifier)(&turned.spec)?;
        match if seen.is_empty() { first_look(&own, &kept, asked) } else { Ok(first.clone()) } {
            Ok(found) => (log, identifier, first) = (turned, own, found),
            Err(FitError::Interrupted) => return Err(FitError::Interrupted.into()),
            // What was found in a part is none in all.
            Err(_) => {}
        }
    }
    let tells = |first: &Identified| {
        let has_lone = matches!(lone(first, &log.spec, asked.unmeasured), Unmeasured::Given(_));
        let is_finished = first.report.search_complete && !is_disturbed(first);
        is_spoilt(first) && (is_finished || has_lone || !seen.is_empty())
    };
    if let Some(found) = first.as_ref().filter(|first| !tells(first)) {
        return Ok(Looked { found: found.clone(), identifier, log });
    }
    let simulated = chosen.as_ref().filter(|_| acts(&kept, &log)).is_none_or(|chosen| chosen.reading.simulated);
    let of = |spec: &Spec| Ok::<_, E>((asked.identifier)(spec)?.with_simulators(simulated));
    let choice = Choice { first: first.as_ref(), asked: asked.unmeasured, seen };
    let rates = with_rates(&log, &kept, choice, of, (asked.watch, asked.say))?;
    match (rates, first) {
        (Some(rates), _) => Ok(rates.into()),
        (None, Some(found)) => Ok(Looked { found, identifier, log }),
        (None, None) => Err(FitError::Regression { reason: "no rate was named".into() }.into()),
    }
}

/// Whether inputs of `log` may act earlier or later.
fn acts(kept: &Samples, log: &Log) -> bool {
    kept.times.is_none() && log.spec.control_dim() > 0
}

/// A log with angles, what is kept of it, its identifier, and what was found.
type Turned = (Log, Samples, Identifier, Identified);

/// What is found in `log` with the states that may be angles as angles, if it is better than `first`, found without: what a part of the log explained without angles all of
/// it may not.
fn with_angles<E: From<FitError>>(
    log: &Log,
    first: Option<&Identified>,
    asked: &Asked<'_, E>,
) -> Result<Option<Turned>, E> {
    let Some(turned) = log.turned() else { return Ok(None) };
    let (kept, identifier) = ((asked.kept)(&turned)?, (asked.identifier)(&turned.spec)?);
    match first_look(&identifier, &kept, asked) {
        Err(FitError::Interrupted) => Err(FitError::Interrupted.into()),
        Ok(Some(found)) if first.is_none_or(|first| is_better(&found, first)) => {
            Ok(Some((turned, kept, identifier, found)))
        }
        _ => Ok(None),
    }
}

/// Equations found without states that were not measured; `None` where such were given.
fn first_look<E>(
    identifier: &Identifier,
    kept: &Samples,
    asked: &Asked<'_, E>,
) -> Result<Option<Identified>, FitError> {
    match asked.unmeasured {
        Unmeasured::Given(_) => Ok(None),
        _ => as_read(identifier, kept, asked.watch).map(Some),
    }
}
