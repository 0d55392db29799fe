//! Inputs that act earlier or later than over the step after their row.

use sindyna_core::{Dataset, FitError, InterSample};

use crate::logs::{Log, Note, Samples};

/// `log` with inputs that act `rows` rows later than over the step after theirs, and a note of it. With a part of a row they change within steps, or are interpolated where they are linear between samples.
///
/// # Errors
/// [`FitError::Regression`] for a part of a row where samples are not even, or if no trajectory is longer than the delay.
pub(super) fn delayed(log: &Log, rows: f64) -> Result<Log, FitError> {
    let failed = |reason: &str| Err(FitError::Regression { reason: reason.into() });
    if log.times.is_some() && rows.fract() != 0.0 {
        return failed("a delay of a part of a row requires evenly spaced samples: resample the log first");
    }
    let margins = (rows.ceil().max(0.0) as usize, (-rows).ceil().max(0.0) as usize);
    let Samples { data, times, .. } = shifted(&log.data, log.times.as_deref(), rows, margins, usize::MAX)?;
    if data.n_steps() == 0 {
        return failed("no trajectory is longer than the delay of the inputs");
    }
    let mut notes = log.notes.clone();
    notes.push(Note::Delayed { rows, seconds: rows * log.spec.dt, deviation: None });
    Ok(Log { data, times, derivatives: None, notes, ..log.clone() })
}

/// `data`, sampled at `times`, whose inputs act `rows` rows later, without the `first` steps and the `last` ones of each trajectory; at most `most` steps.
pub(super) fn shifted(
    data: &Dataset,
    times: Option<&[Vec<f64>]>,
    rows: f64,
    (first, last): (usize, usize),
    most: usize,
) -> Result<Samples, FitError> {
    let failed = |e: sindyna_core::DatasetError| FitError::Regression { reason: e.to_string() };
    let (m, k) = (data.observation_dim(), data.control_dim());
    let part = rows - rows.floor();
    // Held inputs change where the part of a row is over, from those of a whole row more before.
    let late = part > 0.0 && data.intersample().is_held();
    let (rows, intersample) = if late { (rows.ceil(), InterSample::Late(part)) } else { (rows, data.intersample()) };
    let mut all = Dataset::new(m, k, k, data.dt()).with_intersample(intersample);
    let mut moments = Vec::new();
    for (number, rollout) in data.rollouts().enumerate() {
        let end = rollout.controls.nrows().saturating_sub(last).min(first.saturating_add(most - all.n_steps()));
        if end <= first {
            continue;
        }
        all.begin(&rollout.observations.row(first).to_vec()).map_err(failed)?;
        for t in first..end {
            let at = t as f64 - rows;
            let (before, share) = (at.floor(), at - at.floor());
            let after = if share > 0.0 { before + 1.0 } else { before };
            let (one, other) = (rollout.controls.row(before as usize), rollout.controls.row(after as usize));
            let input: Vec<f64> = one.iter().zip(other).map(|(one, other)| one + share * (other - one)).collect();
            all.push(&input, &input, 0.0, &rollout.observations.row(t + 1).to_vec()).map_err(failed)?;
        }
        if let Some(times) = times.and_then(|all| all.get(number)) {
            moments.push(times[first..=end].iter().map(|t| t - times[first]).collect());
        }
    }
    Ok(Samples { data: all, times: times.map(|_| moments), derivatives: None })
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
        let of = |rows: f64, margins: (usize, usize), intersample: InterSample| {
            let data = data.clone().with_intersample(intersample);
            let times = vec![(0..7).map(|t| f64::from(t * t)).collect()];
            let moved = shifted(&data, Some(&times), rows, margins, usize::MAX).expect("moved");
            let first = margins.0 as f64;
            assert_eq!(moved.times.expect("times")[0][1], (first + 1.0).powi(2) - first.powi(2));
            let rollout = moved.data.rollouts().next().expect("one rollout");
            (rollout.observations.column(0).to_vec(), rollout.controls.column(0).to_vec())
        };
        assert_eq!(
            of(1.0, (1, 0), InterSample::Zoh),
            (vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], vec![0.0, 1.0, 4.0, 9.0, 16.0])
        );
        assert_eq!(
            of(-1.0, (0, 1), InterSample::Zoh),
            (vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], vec![1.0, 4.0, 9.0, 16.0, 25.0])
        );
        assert_eq!(of(-0.5, (0, 1), InterSample::Foh).1, [0.5, 2.5, 6.5, 12.5, 20.5]);
        assert_eq!(of(1.5, (2, 0), InterSample::Foh).1, [0.5, 2.5, 6.5, 12.5]);
        assert_eq!(of(-0.5, (0, 1), InterSample::Zoh), of(0.0, (0, 1), InterSample::Zoh), "before it changes");
        assert_eq!(of(1.5, (2, 0), InterSample::Zoh), of(2.0, (2, 0), InterSample::Zoh), "before it changes");
        let moved = shifted(&data, None, 1.25, (2, 0), usize::MAX).expect("moved");
        assert_eq!(moved.data.intersample(), InterSample::Late(0.25));
    }
}
