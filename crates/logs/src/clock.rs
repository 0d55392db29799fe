//! The sampling interval of a log, and samples at another one.

use ndarray::Array2;

use crate::LogError;
use crate::recording::Recording;
use crate::table::Table;

/// Largest distance of a time stamp from an even grid, in sampling intervals; what rounding the stamps explains comes
/// on top.
const JITTER: f64 = 2e-3;

/// The one sampling interval \[s\] behind the time stamps of `recordings`, which were written with `decimals` decimals.
pub(crate) fn interval(table: &Table, recordings: &[Recording], decimals: usize) -> Result<f64, LogError> {
    let rounding = 10_f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX));
    forward(table, recordings)?;
    let several = || recordings.iter().filter(|r| r.times.len() > 1);
    let steps: usize = several().map(|r| r.times.len() - 1).sum();
    let span: f64 = several().map(|r| r.times[r.times.len() - 1] - r.times[0]).sum();
    if steps == 0 {
        return Err(LogError::NoStep);
    }
    let dt = span / steps as f64;
    for recording in several() {
        let times = &recording.times;
        let own = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
        let even = |(i, t): (usize, &f64)| (t - times[0] - i as f64 * own).abs() <= JITTER * dt + rounding;
        let same = (own - dt).abs() <= JITTER * dt + rounding / (times.len() - 1) as f64;
        if !same || !times.iter().enumerate().all(even) {
            return Err(uneven(table, recordings, dt));
        }
    }
    Ok(short(dt, (1e-9 * dt).max(1e-3 * rounding / steps as f64)))
}

/// Refuses time that stands still or runs back.
fn forward(table: &Table, recordings: &[Recording]) -> Result<(), LogError> {
    for recording in recordings {
        if let Some(at) = recording.times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let (before, after) = (recording.times[at], recording.times[at + 1]);
            return Err(LogError::TimeNotIncreasing {
                path: table.path().to_owned(),
                line: recording.lines[at + 1],
                after,
                before,
                line_before: recording.lines[at],
            });
        }
    }
    Ok(())
}

fn uneven(table: &Table, recordings: &[Recording], dt: f64) -> LogError {
    let steps = recordings.iter().flat_map(|r| {
        r.times.windows(2).zip(&r.lines[1..]).map(|(pair, line)| (pair[1] - pair[0], *line)).collect::<Vec<_>>()
    });
    let steps: Vec<(f64, usize)> = steps.collect();
    let by_length = |a: &&(f64, usize), b: &&(f64, usize)| a.0.total_cmp(&b.0);
    let (shortest, longest) = (steps.iter().min_by(by_length), steps.iter().max_by(by_length));
    let (Some(&(shortest, line_shortest)), Some(&(longest, line))) = (shortest, longest) else {
        return LogError::NoStep;
    };
    LogError::Uneven {
        path: table.path().to_owned(),
        line,
        shortest,
        line_shortest,
        longest,
        mean: dt,
        suggested: short(dt, 0.01 * dt),
        forgiven_percent: 100.0 * JITTER,
    }
}

/// The number with the fewest digits within `slack` of `value`.
fn short(value: f64, slack: f64) -> f64 {
    let rounded = (0..16).filter_map(|digits| format!("{value:.digits$e}").parse::<f64>().ok());
    rounded.into_iter().find(|r| (r - value).abs() <= slack).unwrap_or(value)
}

/// `recording` at steps of `dt` \[s\] from its first row on: states by straight lines between rows, inputs as they were
/// held.
///
/// The recording must have time stamps that run forward.
pub(crate) fn resampled(recording: &Recording, dt: f64) -> Recording {
    let times = &recording.times;
    let span = times.last().map_or(0.0, |last| last - times[0]);
    // A stamp at the very end is the last row, whatever rounding says.
    let rows = (span / dt + 1e-6).floor() as usize + 1;
    let (n, k) = (recording.states.ncols(), recording.inputs.ncols());
    let mut result = Recording {
        label: recording.label.clone(),
        lines: Vec::with_capacity(rows),
        times: Vec::with_capacity(rows),
        states: Array2::zeros((rows, n)),
        inputs: Array2::zeros((rows, k)),
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
        for j in 0..k {
            result.inputs[[i, j]] = recording.inputs[[before, j]];
        }
        result.lines.push(recording.lines[before]);
        result.times.push(t);
    }
    result
}

/// Refuses time stamps that cannot be resampled.
pub(crate) fn check_resampling(table: &Table, recordings: &[Recording], dt: f64) -> Result<(), LogError> {
    /// Rows a log may become: all of them are held in memory.
    const MOST_ROWS: f64 = 1e7;
    forward(table, recordings)?;
    let rows: f64 = recordings.iter().filter_map(|r| Some(r.times.last()? - r.times.first()?)).sum::<f64>() / dt;
    if rows > MOST_ROWS {
        return Err(LogError::TooManyRows { dt, rows, most: MOST_ROWS });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;
    use std::path::Path;

    fn recording(times: &[f64]) -> Recording {
        let rows = times.len();
        Recording {
            label: String::new(),
            lines: (2..rows + 2).collect(),
            times: times.to_vec(),
            states: Array2::from_shape_fn((rows, 1), |(i, _)| 2.0 * times[i]),
            inputs: Array2::from_shape_fn((rows, 1), |(i, _)| i as f64),
        }
    }

    fn table() -> Table {
        Table::parse(Path::new("log.csv"), "t,x\n0,1\n".to_owned(), b',').unwrap()
    }

    #[test]
    fn even_stamps_give_their_interval_also_where_they_were_rounded() {
        let check = |times: Vec<f64>, decimals, expected: f64| {
            let dt = interval(&table(), &[recording(&times)], decimals).unwrap();
            assert!((dt - expected).abs() <= 1e-4 * expected, "{dt} is not {expected}");
        };
        let even = |n: usize, dt: f64| (0..n).map(|i| 7.0 + i as f64 * dt).collect::<Vec<_>>();
        let rounded = |n, dt: f64, to: f64| even(n, dt).into_iter().map(|t| (t * to).round() / to).collect();
        check(even(101, 0.05), 17, 0.05);
        assert_eq!(interval(&table(), &[recording(&even(101, 0.05))], 17).unwrap(), 0.05);
        check(rounded(301, 1.0 / 30.0, 1e2), 2, 1.0 / 30.0);
        check(even(100, 0.01).into_iter().enumerate().map(|(i, t)| t + 1e-5 * (i % 2) as f64).collect(), 17, 0.01);
        // Two rollouts at one rate, of which one was cut after a row.
        let two = [recording(&even(5, 0.1)), recording(&[3.0]), recording(&even(9, 0.1))];
        assert_eq!(interval(&table(), &two, 17).unwrap(), 0.1);
    }

    #[test]
    fn time_that_jumps_stands_or_runs_back_is_refused_with_its_line() {
        let refuse = |recordings: &[Recording], says: &[&str]| {
            let failure = interval(&table(), recordings, 17).unwrap_err().to_string();
            says.iter().for_each(|s| assert!(failure.contains(s), "{failure}"));
        };
        refuse(&[recording(&[0.0, 0.1, 0.2, 0.4])], &["line 5", "0.100000 s", "0.200000 s", "0.2 %"]);
        refuse(&[recording(&[0.0, 0.1, 0.05])], &["line 4: t = 0.05 s does not come after 0.1 s (line 3)"]);
        refuse(&[recording(&[0.0, 0.1, 0.1])], &["line 4"]);
        refuse(&[recording(&[0.0, 0.1, 0.2]), recording(&[0.0, 0.2, 0.4])], &["not evenly spaced"]);
        refuse(&[recording(&[0.0])], &["two rows"]);
    }

    #[test]
    fn resampling_follows_straight_lines_and_holds_inputs() {
        let result = resampled(&recording(&[1.0, 1.5, 3.0]), 0.5);
        assert_eq!(result.states, array![[2.0], [3.0], [4.0], [5.0], [6.0]]);
        assert_eq!(result.inputs, array![[0.0], [1.0], [1.0], [1.0], [2.0]]);
    }
}
