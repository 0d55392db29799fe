//! When the samples of a log were taken: one sampling interval, or a time each.

use ndarray::Array2;

use crate::recording::{Recording, Source, place};
use crate::{LogError, Note, Place};

/// Largest distance of a time stamp from an even grid, in sampling intervals; what rounding the stamps explains comes
/// on top.
const JITTER: f64 = 2e-3;

/// A step this many times as long as 95 of 100 is a gap.
const GAP: f64 = 3.0;

/// Takes out rows that are there twice, stamp and values, and refuses time that stands still or runs back otherwise.
pub(crate) fn forward(recordings: &mut [Recording], sources: &[Source<'_>]) -> Result<Option<Note>, LogError> {
    let (mut rows, mut first) = (0, None);
    for recording in &mut *recordings {
        let twice = |i: &usize| {
            *i > 0
                && recording.times[*i].to_bits() == recording.times[i - 1].to_bits()
                && recording.states.row(*i) == recording.states.row(i - 1)
                && recording.inputs.row(*i) == recording.inputs.row(i - 1)
        };
        let (repeated, kept): (Vec<usize>, Vec<usize>) = (0..recording.times.len()).partition(twice);
        if let Some(&at) = repeated.first() {
            first = first.or_else(|| Some(place(sources, recording.table, recording.lines[at])));
            rows += repeated.len();
            *recording = recording.only(&kept);
        }
        if let Some(at) = recording.times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let (line_before, line) = (recording.lines[at], recording.lines[at + 1]);
            let source = &sources[recording.table];
            return Err(LogError::TimeNotIncreasing {
                path: source.path().to_owned(),
                column: source.time_name().to_owned(),
                row: source.table.row(line),
                after: source.stamp(line),
                before: format!("{} ({})", source.stamp(line_before), source.table.row(line_before)),
            });
        }
    }
    Ok(first.map(|row| Note::Repeated { rows, row }))
}

/// A step that is too long to be one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// How long it is.
    pub(crate) step: f64,
    /// When it begins, in the unit of the times.
    pub(crate) at: f64,
    /// The table and the row that it leads to.
    pub(crate) table: usize,
    pub(crate) line: usize,
}

/// Gaps, and the longest step that is none.
#[derive(Debug, Default)]
pub(crate) struct Gaps {
    pub(crate) all: Vec<Gap>,
    pub(crate) over: f64,
}

impl Gaps {
    /// A note on the longest one, which leads to a row at `place`.
    pub(crate) fn note(&self, place: impl Fn(&Gap) -> Place) -> Option<Note> {
        let longest = self.all.iter().max_by(|a, b| a.step.total_cmp(&b.step))?;
        Some(Note::Gaps { gaps: self.all.len(), longest: longest.step, row: place(longest), over: self.over })
    }
}

/// Ends recordings where steps are gaps: longer than `given`, or than [`GAP`] times as long as others are.
pub(crate) fn without_gaps(recordings: &[Recording], given: Option<f64>) -> (Vec<Recording>, Gaps) {
    let steps = sorted_steps(recordings);
    let usual = steps.get(steps.len() * 95 / 100).copied().unwrap_or(f64::INFINITY);
    let longest = given.unwrap_or(GAP * usual);
    let (mut parts, mut gaps) = (Vec::new(), Vec::new());
    for recording in recordings {
        let mut first = 0;
        for (i, step) in recording.steps().enumerate().filter(|(_, step)| *step > longest) {
            parts.push(recording.part(first..i + 1));
            gaps.push(Gap { step, at: recording.times[i], table: recording.table, line: recording.lines[i + 1] });
            first = i + 1;
        }
        parts.push(recording.part(first..recording.lines.len()));
    }
    (parts, Gaps { all: gaps, over: longest })
}

/// Whether the samples of `recordings` are taken every so many seconds, and how many; stamps were rounded to `rounding` \[s\].
pub(crate) fn interval(recordings: &[Recording], rounding: f64) -> Result<Option<f64>, LogError> {
    let several = || recordings.iter().filter(|r| r.times.len() > 1);
    let steps: usize = several().map(|r| r.times.len() - 1).sum();
    let span: f64 = several().map(|r| r.times[r.times.len() - 1] - r.times[0]).sum();
    if steps == 0 {
        return Err(LogError::NoStep);
    }
    let dt = span / steps as f64;
    let is_even = |recording: &Recording| {
        let times = &recording.times;
        let own = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
        let even = |(i, t): (usize, &f64)| (t - times[0] - i as f64 * own).abs() <= JITTER * dt + rounding;
        let same = (own - dt).abs() <= JITTER * dt + rounding / (times.len() - 1) as f64;
        same && times.iter().enumerate().all(even)
    };
    Ok(several().all(is_even).then(|| short(dt, (1e-9 * dt).max(1e-3 * rounding / steps as f64))))
}

/// The mean of the steps between time stamps that are no gaps, in their unit, 0 without any; and by how much jitter makes it uncertain.
pub(crate) fn mean_step(recordings: &[Recording]) -> (f64, f64) {
    let steps = sorted_steps(recordings);
    let longest = GAP * steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let steps: Vec<f64> = steps.into_iter().filter(|step| *step <= longest).collect();
    let count = steps.len().max(1) as f64;
    // Of a sum of steps only the first and the last stamp are uncertain.
    let spread = steps.last().zip(steps.first()).map_or(0.0, |(longest, shortest)| longest - shortest);
    (steps.iter().sum::<f64>() / count, spread / count)
}

fn sorted_steps(recordings: &[Recording]) -> Vec<f64> {
    let mut steps: Vec<f64> = recordings.iter().flat_map(Recording::steps).collect();
    steps.sort_by(f64::total_cmp);
    steps
}

/// The usual step of samples that are not evenly spaced \[s\], and a note on them.
pub(crate) fn uneven(recordings: &[Recording]) -> (f64, Note) {
    let steps = sorted_steps(recordings);
    let at = |share: f64| steps[((steps.len() - 1) as f64 * share) as usize];
    let dt = short(at(0.5), 0.01 * at(0.5));
    (dt, Note::Uneven { shortest: at(0.0), longest: at(1.0), usual: dt })
}

/// The number with the fewest digits within `slack` of `value`.
fn short(value: f64, slack: f64) -> f64 {
    let rounded = (0..16).filter_map(|digits| format!("{value:.digits$e}").parse::<f64>().ok());
    rounded.into_iter().find(|r| (r - value).abs() <= slack).unwrap_or(value)
}

/// `recording` at steps of `dt` \[s\] from its first row on: states by straight lines between rows, inputs as the mean of what was
/// held from one of these steps to the next.
///
/// The recording must have time stamps that run forward.
pub(crate) fn resampled(recording: &Recording, dt: f64) -> Recording {
    let times = &recording.times;
    let span = times.last().map_or(0.0, |last| last - times[0]);
    // A stamp at the very end is the last row, whatever rounding says.
    let rows = (span / dt + 1e-6).floor() as usize + 1;
    let (n, k) = (recording.states.ncols(), recording.inputs.ncols());
    let mut result = Recording {
        lines: Vec::with_capacity(rows),
        times: Vec::with_capacity(rows),
        states: Array2::zeros((rows, n)),
        inputs: Array2::zeros((rows, k)),
        label: recording.label.clone(),
        table: recording.table,
    };
    let mut before = 0;
    for i in 0..rows {
        let t = times[0] + i as f64 * dt;
        while before + 1 < times.len() && times[before + 1] <= t + 1e-6 * dt {
            before += 1;
        }
        let after = (before + 1).min(times.len() - 1);
        let share = if after > before { ((t - times[before]) / (times[after] - times[before])).max(0.0) } else { 0.0 };
        for j in 0..n {
            let (a, b) = (recording.states[[before, j]], recording.states[[after, j]]);
            result.states[[i, j]] = a + share * (b - a);
        }
        let mut held = result.inputs.row_mut(i);
        // Weights of the rows whose inputs were held in [t, t + dt); all of it by one where that is within it.
        let (mut row, mut from) = (before, t);
        while row + 1 < times.len() && times[row + 1] < t + (1.0 - 1e-6) * dt {
            held.scaled_add((times[row + 1] - from) / dt, &recording.inputs.row(row));
            (row, from) = (row + 1, times[row + 1]);
        }
        let left = if row == before { 1.0 } else { (t + dt - from) / dt };
        held.scaled_add(left, &recording.inputs.row(row));
        result.lines.push(recording.lines[before]);
        result.times.push(t);
    }
    result
}

/// Refuses to make more rows than are held in memory.
pub(crate) fn check_resampling(recordings: &[Recording], dt: f64) -> Result<(), LogError> {
    /// Rows a log may become: all of them are held in memory.
    const MOST_ROWS: f64 = 1e7;
    let rows: f64 = recordings.iter().filter_map(|r| Some(r.times.last()? - r.times.first()?)).sum::<f64>() / dt;
    if rows > MOST_ROWS {
        return Err(LogError::TooManyRows { dt, rows, most: MOST_ROWS });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Row;
    use ndarray::array;

    fn recording(times: &[f64]) -> Recording {
        let rows = times.len();
        Recording {
            lines: (2..rows + 2).collect(),
            times: times.to_vec(),
            states: Array2::from_shape_fn((rows, 1), |(i, _)| 2.0 * times[i]),
            inputs: Array2::from_shape_fn((rows, 1), |(i, _)| i as f64),
            ..Recording::default()
        }
    }

    #[test]
    fn even_stamps_give_their_interval_also_where_they_were_rounded() {
        let check = |times: Vec<f64>, decimals: i32, expected: f64| {
            let dt = interval(&[recording(&times)], 10_f64.powi(-decimals)).unwrap().unwrap();
            assert!((dt - expected).abs() <= 1e-4 * expected, "{dt} is not {expected}");
        };
        let even = |n: usize, dt: f64| (0..n).map(|i| 7.0 + i as f64 * dt).collect::<Vec<_>>();
        let rounded = |n, dt: f64, to: f64| even(n, dt).into_iter().map(|t| (t * to).round() / to).collect();
        check(even(101, 0.05), 17, 0.05);
        assert_eq!(interval(&[recording(&even(101, 0.05))], 1e-17).unwrap(), Some(0.05));
        check(rounded(301, 1.0 / 30.0, 1e2), 2, 1.0 / 30.0);
        check(even(100, 0.01).into_iter().enumerate().map(|(i, t)| t + 1e-5 * (i % 2) as f64).collect(), 17, 0.01);
        // Two rollouts at one rate, of which one was cut after a row.
        let two = [recording(&even(5, 0.1)), recording(&[3.0]), recording(&even(9, 0.1))];
        assert_eq!(interval(&two, 1e-17).unwrap(), Some(0.1));
        assert!(interval(&[recording(&[0.0])], 0.0).unwrap_err().to_string().contains("two rows"));
    }

    #[test]
    fn other_stamps_are_uneven() {
        let jittering = [recording(&[0.0, 0.1, 0.19, 0.3, 0.41])];
        assert_eq!(interval(&jittering, 0.0).unwrap(), None);
        let (dt, note) = uneven(&jittering);
        assert!((dt - 0.1).abs() < 2e-3, "{dt}");
        let told = note.to_string();
        assert!(["0.09 to 0.11 s", "own time"].iter().all(|s| told.contains(s)), "{told}");
        let two = [recording(&[0.0, 0.1, 0.2]), recording(&[0.0, 0.2, 0.4])];
        assert_eq!(interval(&two, 0.0).unwrap(), None, "at two rates");
    }

    #[test]
    fn gaps_are_borders_and_jitter_is_none() {
        let mut times: Vec<f64> = (0..40).map(|i| 0.01 * f64::from(i)).collect();
        times[20..].iter_mut().for_each(|t| *t += 0.03);
        let (parts, gaps) = without_gaps(&[recording(&times)], None);
        assert_eq!(parts.iter().map(|p| (p.lines[0], p.times.len())).collect::<Vec<_>>(), [(2, 20), (22, 20)]);
        let place = |gap: &Gap| Place { file: None, row: Row { number: gap.line, is_line: true } };
        assert!(gaps.note(place).unwrap().to_string().contains("0.04 s before line 22"));
        let (whole, none) = without_gaps(&[recording(&times)], Some(1.0));
        assert!(whole == [recording(&times)] && none.all.is_empty());
        let dropped: Vec<f64> = (0..40).filter(|i| *i != 20).map(|i| 0.01 * f64::from(i)).collect();
        assert!(without_gaps(&[recording(&dropped)], None).1.all.is_empty());
    }

    #[test]
    fn resampling_follows_straight_lines_and_takes_the_mean_of_inputs() {
        let result = resampled(&recording(&[1.0, 1.5, 3.0]), 0.5);
        assert_eq!(result.states, array![[2.0], [3.0], [4.0], [5.0], [6.0]]);
        assert_eq!(result.inputs, array![[0.0], [1.0], [1.0], [1.0], [2.0]]);
        let coarse = resampled(&recording(&[0.0, 0.25, 0.5, 1.0, 1.5, 2.0]), 1.0);
        assert_eq!(coarse.states, array![[0.0], [2.0], [4.0]]);
        assert_eq!(coarse.inputs, array![[0.25 + 1.0], [3.5], [5.0]]);
    }
}
