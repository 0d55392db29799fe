//! Inputs that act earlier or later than over the step after their row.

use sindyna_core::{Dataset, FitError};

use crate::logs::{Log, Note};

/// `log` with inputs that act `rows` rows later than over the step after theirs, and a note of it. A part of a row is interpolated linearly.
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

/// `data` whose inputs are those of `rows` rows before, without the `first` steps and the `last` ones of each trajectory; at most `most` steps.
pub(super) fn shifted(
    data: &Dataset,
    rows: f64,
    (first, last): (usize, usize),
    most: usize,
) -> Result<Dataset, FitError> {
    let failed = |e: sindyna_core::DatasetError| FitError::Regression { reason: e.to_string() };
    let (m, k) = (data.observation_dim(), data.control_dim());
    let mut all = Dataset::new(m, k, k, data.dt()).with_intersample(data.intersample());
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
