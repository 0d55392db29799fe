//! Rates of other states, but for a sensor that is late.

use ndarray::{Array2, s};

use crate::Note;
use crate::rates::{CLOSE, Seen, off_by, unrelated};
use crate::recording::Recording;

/// Rows by which one of two sensors may be later than the other, at most.
const MOST: usize = 10;

/// Rows of each recording that are compared, at most.
const ROWS: usize = 2000;

/// Notes of states that no other one was `seen` to be the rate of, and that one follows some rows later or earlier.
pub(crate) fn late(recordings: &[Recording], names: &[String], seen: &[Seen]) -> Vec<Note> {
    let note = |(rate, of): (usize, usize)| {
        let moved = |late: bool, rows: usize| -> Vec<Recording> {
            let (rate, of) = if late { ((rate, rows), (of, 0)) } else { ((rate, 0), (of, rows)) };
            recordings.iter().map(|recording| beside(recording, rate, of)).collect()
        };
        let tried = (1..=MOST).flat_map(|rows| [(true, rows), (false, rows)]);
        let follows = |(late, rows): (bool, usize)| Some((off_by(&moved(late, rows), 0, 1)?, late, rows));
        let (off_by, late, rows) = tried.filter_map(follows).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let by = rows as f64 * interval(recordings)?;
        let (rate, of) = (names[rate].clone(), names[of].clone());
        (off_by <= CLOSE).then_some(Note::RateLate { rate, of, by: if late { by } else { -by } })
    };
    unrelated(names.len(), seen).filter_map(note).collect()
}

/// The mean sampling interval of the first recording.
fn interval(recordings: &[Recording]) -> Option<f64> {
    let times = &recordings.first()?.times;
    Some((times.last()? - times.first()?) / times.len().saturating_sub(1).max(1) as f64)
}

/// The first rows of two states of `recording`, each so many rows earlier.
fn beside(recording: &Recording, rate: (usize, usize), of: (usize, usize)) -> Recording {
    let most = rate.1.max(of.1);
    let length = recording.states.nrows().saturating_sub(most).min(ROWS);
    let mut states = Array2::zeros((length, 2));
    for (mut column, (i, rows)) in states.columns_mut().into_iter().zip([rate, of]) {
        let first = if length == 0 { 0 } else { rows };
        column.assign(&recording.states.slice(s![first..first + length, i]));
    }
    let times = recording.times.iter().take(length).copied().collect();
    Recording { times, states, ..Recording::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rates::recognised;

    #[test]
    fn a_sensor_that_is_late_is_told_from_a_rate_and_from_something_else() {
        let names = ["yaw".to_owned(), "r".to_owned()];
        let noted = |r: fn(f64) -> f64| {
            let states = Array2::from_shape_fn((400, 2), |(i, j)| {
                let t = 0.1 * i as f64;
                [t.sin() + 0.4 * (2.3 * t).cos(), r(t)][j]
            });
            let times = (0..400).map(|i| 0.1 * f64::from(i)).collect();
            let log = [Recording { times, states, inputs: Array2::zeros((400, 0)), ..Recording::default() }];
            late(&log, &names, &recognised(&log)).iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
        };
        let rate = |t: f64| t.cos() - 0.92 * (2.3 * t).sin();
        assert!(noted(|t| (t - 0.3).cos() - 0.92 * (2.3 * (t - 0.3)).sin()).contains("if r were 0.3 s earlier"));
        assert!(noted(|t| (t + 0.2).cos() - 0.92 * (2.3 * (t + 0.2)).sin()).contains("if yaw were 0.2 s earlier"));
        assert!(noted(rate).is_empty());
        // A lag is no delay, and what oscillates otherwise is no rate.
        assert!(noted(|t| t.cos() / 2.0 - 0.92 * (2.3 * t).sin() / 3.0).is_empty());
        assert!(noted(|t| (1.1 * t).cos()).is_empty());
    }
}
