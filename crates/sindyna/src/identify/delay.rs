//! Inputs that act earlier or later than over the step after their row.

use sindyna_core::{Dataset, FitError, Spec};
use sindyna_sindy::Identified;

use super::as_read::{as_read, is_spoilt};
use super::asked::Asked;
use super::unmeasured::{Order, Unmeasured, lone, with_rates_of};
use crate::logs::{Log, Note, Samples};

/// What is tried: delays, and whether the samples are those of a simulator.
const TRIED: [(f64, bool); 6] = [(0.0, false), (-1.0, false), (-0.5, false), (1.0, false), (2.0, false), (0.0, true)];

/// Steps at either end that no delay of these needs.
const MARGINS: (usize, usize) = (2, 1);

/// Steps by which they are told apart, at most, and the part of the usual effort for each.
const STEPS: usize = 300;
const EFFORT: f64 = 0.1;

/// Difference of scores by which one of them is believed: odds of twenty to one, and one of six.
const TOLD_APART: f64 = 6.0 + 2.0 * 1.791_759;

/// Whether a delay of the inputs of `log` can be told from the samples `kept` of it: there are inputs, and samples at even times.
pub(super) fn fits(log: &Log, kept: &Samples) -> bool {
    kept.times.is_none() && log.spec.control_dim() > 0
}

/// `log` with inputs that act `rows` rows later than over the step after theirs, and a note of it. Between rows inputs are straight lines.
///
/// # Errors
/// [`FitError::Regression`] if samples are not even, or no trajectory is longer than the delay.
pub(super) fn delayed(log: &Log, rows: f64) -> Result<Log, FitError> {
    let failed = |reason: &str| Err(FitError::Regression { reason: reason.into() });
    if log.times.is_some() {
        return failed(
            "a delay of the inputs is a number of rows, which must be evenly spaced: resample the log first",
        );
    }
    let margins = (rows.ceil().max(0.0) as usize, (-rows).ceil().max(0.0) as usize);
    let data = shifted(&log.data, rows, margins, usize::MAX)?;
    if data.n_steps() == 0 {
        return failed("no trajectory is longer than the delay of the inputs");
    }
    let mut notes = log.notes.clone();
    notes.push(Note::Delayed { rows, seconds: rows * log.spec.dt });
    Ok(Log { data, notes, ..log.clone() })
}

/// The delay of the inputs of `log`, and whether its samples are those of a simulator, for which the samples `kept` of it speak: the best of what is tried on a part of
/// them, with rates that were not measured as was asked, or as `first`, found in all of them, leaves open. `None` where a part tells nothing.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn told_apart<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    first: Option<&Identified>,
    asked: &Asked<'_, E>,
) -> Result<Option<(f64, bool)>, E> {
    (asked.say)("no term explains the residuals: trying other delays of the inputs, and steps of a simulator");
    let rates = match first {
        Some(first) => lone(first, &log.spec, asked.unmeasured),
        None => asked.unmeasured.clone(),
    };
    let mut scores: Vec<(f64, (f64, bool))> = Vec::new();
    let mut left_out = usize::MAX;
    for (rows, simulated) in TRIED {
        if simulated && !matches!(rates, Unmeasured::Given(_)) {
            continue;
        }
        let samples = Samples { data: shifted(&kept.data, rows, MARGINS, STEPS)?, times: None };
        let of = |spec: &Spec| Ok::<_, E>((asked.identifier)(spec)?.with_effort(EFFORT).with_simulators(simulated));
        // Of a state whose rate was not measured nothing is found without it.
        let first = match &rates {
            Unmeasured::Given(_) => None,
            _ => as_read(&of(&log.spec)?, &samples, asked.watch).ok(),
        };
        let choice = (first.as_ref(), &rates);
        let with = with_rates_of(log, &samples, choice, of, (asked.watch, &|_| {}), Order::Second);
        if !asked.watch.go_on() {
            return Err(FitError::Interrupted.into());
        }
        let found = with.ok().flatten().map(|(found, ..)| found).or(first);
        let score = found.as_ref().and_then(|found| found.report.score);
        // As it was read it is what others are compared with; of these one that leaves as much tells nothing, and one that leaves out more steps is contradicted by them: where an
        // input changes, and nowhere else, its delay shows.
        let counts =
            |found: &Identified| scores.is_empty() || !is_spoilt(found) && found.report.rows_astray <= left_out;
        if let Some(found) = found.as_ref().filter(|found| counts(found))
            && let Some(score) = score
        {
            left_out = left_out.min(found.report.rows_astray);
            scores.push((score, (rows, simulated)));
        }
        if scores.len() == 1 && found.is_some_and(|found| !is_spoilt(&found)) {
            break;
        }
    }
    // Those tried first are the likelier ones before there are data.
    let mut best = scores.first().copied();
    for tried in scores {
        best = best.map(|best| if tried.0 + TOLD_APART < best.0 { tried } else { best });
    }
    Ok(best.map(|(_, chosen)| chosen))
}

/// `data` whose inputs are those of `rows` rows before, without the `first` steps and the `last` ones of each trajectory; at most `most` steps.
fn shifted(data: &Dataset, rows: f64, (first, last): (usize, usize), most: usize) -> Result<Dataset, FitError> {
    let failed = |e: sindyna_core::DatasetError| FitError::Regression { reason: e.to_string() };
    let (m, k) = (data.observation_dim(), data.control_dim());
    let mut all = Dataset::new(m, k, k, data.dt());
    for rollout in data.rollouts() {
        let steps = first..rollout.controls.nrows().saturating_sub(last);
        if steps.is_empty() || all.n_steps() >= most {
            continue;
        }
        all.begin(&rollout.observations.row(first).to_vec()).map_err(failed)?;
        for t in steps.take(most - all.n_steps()) {
            let at = t as f64 - rows;
            let (before, share) = (at.floor(), at - at.floor());
            let after = if share > 0.0 { before + 1.0 } else { before };
            let (one, other) = (rollout.controls.row(before as usize), rollout.controls.row(after as usize));
            let input: Vec<f64> = one.iter().zip(other).map(|(one, other)| one + share * (other - one)).collect();
            all.push(&input, &input, 0.0, &rollout.observations.row(t + 1).to_vec()).map_err(failed)?;
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_moved_by_rows_and_parts_of_rows() {
        let mut data = Dataset::new(1, 1, 1, 0.1);
        data.begin(&[0.0]).expect("begun");
        for t in 0..6 {
            data.push(&[f64::from(t * t)], &[f64::from(t * t)], 0.0, &[f64::from(t + 1)]).expect("pushed");
        }
        let of = |rows: f64, margins: (usize, usize)| {
            let moved = shifted(&data, rows, margins, usize::MAX).expect("moved");
            let rollout = moved.rollouts().next().expect("one rollout");
            (rollout.observations.column(0).to_vec(), rollout.controls.column(0).to_vec())
        };
        assert_eq!(of(1.0, (1, 0)), (vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], vec![0.0, 1.0, 4.0, 9.0, 16.0]));
        assert_eq!(of(-1.0, (0, 1)), (vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], vec![1.0, 4.0, 9.0, 16.0, 25.0]));
        assert_eq!(of(-0.5, (0, 1)).1, [0.5, 2.5, 6.5, 12.5, 20.5]);
        assert_eq!(of(1.5, (2, 0)).1, [0.5, 2.5, 6.5, 12.5]);
    }
}
