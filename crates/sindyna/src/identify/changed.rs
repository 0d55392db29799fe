//! Systems that change during a log.

use sindyna_core::FitError;
use sindyna_sindy::{Disturbances, EquationReport, Identified, Model};

use super::as_read::{as_read, is_disturbed, is_spoilt, recordings_of};
use super::asked::Asked;
use crate::logs::{Log, Samples};

/// Part of the steps at the beginning and at the end of a log that are looked at alone, and how many they are at least and at most.
const PART: f64 = 0.3;
const FEWEST: usize = 100;
const MOST: usize = 600;

/// Part of the usual effort for each of them.
const EFFORT: f64 = 0.25;

/// Standard errors by which a coefficient differs.
const APART: f64 = 6.0;

/// The same of standard errors that tell how pieces disagree, of a coefficient that may differ: its change is a part of that.
const DISAGREEING: f64 = 2.0;

/// A warning with the equations at the beginning and at the end of `log`, where `found` holds for most of it, if both have the same terms and leave noise alone there, and a coefficient differs: no equations
/// hold for all of it.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn changed<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    found: &Identified,
    asked: &Asked<'_, E>,
) -> Result<Option<String>, E> {
    let all = kept.data.n_steps();
    let split = |at: usize| kept.split(at).map_err(|e| FitError::Regression { reason: e.to_string() });
    if is_disturbed(found) {
        // Friction and disturbances leave more than noise of any part.
        let (part, identifier) = ((PART * all as f64) as usize, (asked.identifier)(&log.spec)?);
        let of = |samples: &Samples| identifier.fitted_to_pieces(&found.model, recordings_of(samples), asked.watch);
        let (first, last) = (of(&split(part)?.0)?, of(&split(all - part)?.1)?);
        if !first.zip(last).is_some_and(|(first, last)| moved(found, &first, &last)) {
            return Ok(None);
        }
    }
    let steps = ((PART * all as f64) as usize).min(MOST);
    if steps < FEWEST {
        return Ok(None);
    }
    let identifier = (asked.identifier)(&log.spec)?.with_effort(EFFORT).with_disturbances(Disturbances::None);
    let of = |samples: &Samples| -> Result<Option<Identified>, E> {
        match as_read(&identifier, samples, asked.watch) {
            Err(FitError::Interrupted) => Err(FitError::Interrupted.into()),
            found => Ok(found.ok().filter(|found| !is_spoilt(found))),
        }
    };
    let end = split(all - steps)?.1;
    let Some(first) = of(&kept.first(steps))? else { return Ok(None) };
    let Some(last) = of(&end)? else { return Ok(None) };
    Ok(differ(&first, &last).then(|| {
        format!(
            "the first {steps} steps follow {}; the last {steps} follow {}: the system changed, or a term is missing; identify the parts \
             separately",
            of_motion(&first).join(", "),
            of_motion(&last).join(", ")
        )
    }))
}

/// Whether a coefficient of the equations `found`, fitted to [`PART`] of the samples at either end, differs between these.
fn moved(found: &Identified, first: &Model, last: &Model) -> bool {
    let of = |(i, equation): (usize, &EquationReport)| {
        let pairs = first.coefficients(i).iter().zip(last.coefficients(i));
        let mut apart = pairs.zip(&equation.standard_errors);
        apart.any(|((a, b), error)| (a.coefficient - b.coefficient).abs() > DISAGREEING * error * (2.0 / PART).sqrt())
    };
    found.report.equations.iter().enumerate().any(of)
}

/// Whether the equations have the same terms, but not the same coefficients.
fn differ(one: &Identified, other: &Identified) -> bool {
    let pairs = || one.report.equations.iter().zip(&other.report.equations);
    let terms = |found: &Identified, equation: &EquationReport| -> Vec<String> {
        equation.support.iter().map(|j| found.report.features[*j].clone()).collect()
    };
    let apart = |one: &EquationReport, other: &EquationReport| {
        let errors = one.standard_errors.iter().zip(&other.standard_errors);
        let each = one.coefficients.iter().zip(&other.coefficients).zip(errors);
        each.into_iter().any(|((a, b), (e, f))| (a - b).abs() > APART * e.hypot(*f))
    };
    pairs().all(|(a, b)| terms(one, a) == terms(other, b)) && pairs().any(|(a, b)| apart(a, b))
}

/// The equations that are fitted.
fn of_motion(found: &Identified) -> Vec<String> {
    let fitted = found.report.equations.iter().map(|equation| !equation.standard_errors.is_empty());
    found
        .model
        .equations()
        .into_iter()
        .zip(fitted)
        .filter_map(|(equation, fitted)| fitted.then_some(equation))
        .collect()
}
