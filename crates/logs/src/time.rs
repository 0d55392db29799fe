//! Which column holds the time, and in which unit.

use std::borrow::Cow;

use crate::column::Column;
use crate::date;
use crate::rates;
use crate::recording::Recording;
use crate::table::Table;
use crate::time_unit::{TimeUnit, UnitBy};

/// The units that are told by powers of a thousand, longest first.
const DECIMAL: [TimeUnit; 4] =
    [TimeUnit::Seconds, TimeUnit::Milliseconds, TimeUnit::Microseconds, TimeUnit::Nanoseconds];

/// The column of `table` that holds the time, by its name or because its first cell is a date; none of those in `taken`.
pub(crate) fn column(table: &Table, taken: &[&str]) -> Option<usize> {
    let columns = table.columns();
    let free = |c: &Column| !taken.contains(&c.name.as_str());
    let plain = columns.iter().position(|c| c.name == crate::TIME && free(c));
    let first = || table.rows().next().map(|(_, cells)| cells).unwrap_or_default();
    let by_name = plain.or_else(|| columns.iter().position(|c| free(c) && is_time(c)));
    by_name.or_else(|| {
        let is_date = |(cell, c): (&Cow<'_, str>, &Column)| free(c) && date::nanoseconds(cell).is_some();
        first().iter().zip(columns).position(is_date)
    })
}

/// The first column of `table` whose numbers increase evenly from the first row to the last, as time stamps do.
pub(crate) fn running(table: &Table) -> Option<usize> {
    (0..table.columns().len()).find(|&i| {
        let values: Option<Vec<f64>> = table.rows().map(|(_, cells)| cells.get(i)?.parse().ok()).collect();
        let Some(values) = values.filter(|values| values.len() > FEWEST) else { return false };
        let mean = (values[values.len() - 1] - values[0]) / (values.len() - 1) as f64;
        mean > 0.0 && values.windows(2).all(|pair| (pair[1] - pair[0] - mean).abs() <= EVEN * mean)
    })
}

/// Rows of a column that may be the time, at least, and part of its mean step by which each may differ.
const FEWEST: usize = 10;
const EVEN: f64 = 0.1;

/// The words of a name, in small letters.
fn words(name: &str) -> impl Iterator<Item = String> {
    let lower = name.to_lowercase();
    let words: Vec<String> = lower.split(|c: char| !c.is_alphanumeric()).map(str::to_owned).collect();
    words.into_iter().filter(|w| !w.is_empty())
}

/// Whether `column` holds time stamps, by its name. A temperature `T`, or what has a unit of something else, does not.
pub(crate) fn is_time(column: &Column) -> bool {
    const TIMES: [&str; 26] = [
        "t",
        "time",
        "times",
        "timestamp",
        "timestamps",
        "stamp",
        "clock",
        "elapsed",
        "seconds",
        "secs",
        "sec",
        "minutes",
        "hours",
        "days",
        "millis",
        "micros",
        "milliseconds",
        "microseconds",
        "date",
        "datetime",
        "zeit",
        "temps",
        "tiempo",
        "tempo",
        "tijd",
        "czas",
    ];
    const BESIDE: [&str; 9] = ["header", "unix", "epoch", "ros", "sim", "wall", "system", "log", "since"];
    let name = column.name.as_str();
    let all: Vec<String> = words(name).collect();
    let is_temperature = name.split(|c: char| !c.is_alphanumeric()).any(|word| word == "T");
    let is_other = all.len() > 1 && !column.unit.is_empty() && TimeUnit::named(&column.unit).is_none();
    if is_temperature || is_other {
        return false;
    }
    all.iter().any(|w| TIMES.contains(&w.as_str()))
        && all
            .iter()
            .all(|w| TIMES.contains(&w.as_str()) || BESIDE.contains(&w.as_str()) || TimeUnit::named(w).is_some())
}

/// The unit that the header of the time `column` tells.
pub(crate) fn unit_in_header(column: &Column) -> Option<TimeUnit> {
    TimeUnit::named(&column.unit).or_else(|| {
        let last = words(&column.name).last()?;
        TimeUnit::named(&last)
    })
}

/// Steps that are whole numbers from 10 to this one, all the same, may be seconds of a slow process or fractions of them of a fast one.
const LONGEST: f64 = 1e5;

/// The unit of the stamps of `recordings`, which count from `origin`, and what tells it; the step itself where nothing does.
pub(crate) fn unit_in_values(recordings: &[Recording], origin: f64) -> Result<(TimeUnit, UnitBy), f64> {
    if let Some(unit) = unit_by_rates(recordings) {
        return Ok((unit, UnitBy::Rates));
    }
    // Seconds since 1970, in 2001 to 2100.
    let ours = 1e9..4.1e9;
    if let Some(unit) = DECIMAL.into_iter().find(|unit| ours.contains(&(origin * unit.seconds()))) {
        return Ok((unit, UnitBy::Epoch));
    }
    let mut steps: Vec<f64> = recordings.iter().flat_map(Recording::steps).collect();
    steps.sort_by(f64::total_cmp);
    let whole = origin.fract() == 0.0 && steps.iter().all(|s| s.fract() == 0.0);
    let Some(&step) = steps.get(steps.len() / 2).filter(|_| whole) else {
        return Ok((TimeUnit::Seconds, UnitBy::Default));
    };
    let even = steps[steps.len() - 1] - steps[0] < 0.5;
    let jitters = steps.iter().any(|s| (s - step).abs() as i64 == 1);
    // Counters of the next smaller unit: a step of a second or more is one of the unit after that.
    match step {
        s if s < 10.0 && !jitters => Ok((TimeUnit::Seconds, UnitBy::Default)),
        s if even && s < LONGEST => Err(s),
        s if s < 1e3 => Ok((TimeUnit::Milliseconds, UnitBy::Counter)),
        s if s < 1e6 => Ok((TimeUnit::Microseconds, UnitBy::Counter)),
        _ => Ok((TimeUnit::Nanoseconds, UnitBy::Counter)),
    }
}

/// The one decimal unit in which a state is the rate of another.
fn unit_by_rates(recordings: &[Recording]) -> Option<TimeUnit> {
    let shows = |unit: &&TimeUnit| {
        let scaled: Vec<Recording> = recordings.iter().map(|r| r.with_times_scaled(unit.seconds())).collect();
        !rates::recognised(&scaled).is_empty()
    };
    let found: Vec<&TimeUnit> = DECIMAL.iter().filter(shows).collect();
    if let [only] = found[..] { Some(*only) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn names_of_times_are_known_and_others_are_not() {
        let named = |name: &str| Column { name: name.into(), unit: String::new() };
        for name in [
            "t",
            "time",
            "Time",
            "timestamp",
            "time_ms",
            "%time",
            "elapsed time",
            "seconds",
            "t_s",
            "stamp.sec",
            "unix_time",
            "hours",
        ] {
            assert!(is_time(&named(name)), "{name}");
        }
        for name in ["th", "torque", "s", "ms", "timer_state", "x", "time_to_go", "", "min", "T", "T_wall"] {
            assert!(!is_time(&named(name)), "{name}");
        }
        let column = |name: &str, unit: &str| Column { name: name.into(), unit: unit.into() };
        assert!(!is_time(&column("t_wall", "\u{b0}C")) && is_time(&column("wall time", "ms")));
        let unit = |name: &str, unit: &str| unit_in_header(&Column { name: name.into(), unit: unit.into() });
        assert_eq!(unit("time_ms", ""), Some(TimeUnit::Milliseconds));
        assert_eq!(unit("t", "\u{b5}s"), Some(TimeUnit::Microseconds));
        assert_eq!((unit("day", ""), unit("hours", "")), (Some(TimeUnit::Days), Some(TimeUnit::Hours)));
        assert_eq!(unit("timestamp", ""), None);
        assert_eq!(unit("seconds", ""), Some(TimeUnit::Seconds));
    }

    /// Stamps of 60 samples, and columns of them.
    fn recording(n: usize, stamp: impl Fn(usize) -> f64, x: impl Fn(usize, usize) -> f64) -> Recording {
        Recording {
            lines: (2..62).collect(),
            times: (0..60).map(stamp).collect(),
            states: Array2::from_shape_fn((60, n), |(i, j)| x(i, j)),
            inputs: Array2::zeros((60, 0)),
            ..Recording::default()
        }
    }

    #[test]
    fn units_are_told_by_rates_epochs_and_counters() {
        let check = |origin: f64, stamp: fn(usize) -> f64, expected| {
            assert_eq!(unit_in_values(&[recording(1, stamp, |i, _| (i as f64).sin())], origin), Ok(expected));
        };
        check(0.0, |i| 0.05 * i as f64, (TimeUnit::Seconds, UnitBy::Default));
        check(0.0, |i| 4.0 * i as f64, (TimeUnit::Seconds, UnitBy::Default));
        check(17.0, |i| (3.34 * i as f64).floor(), (TimeUnit::Milliseconds, UnitBy::Counter));
        check(5.0, |i| 5000.0 * i as f64 + f64::from(i % 3 == 0), (TimeUnit::Microseconds, UnitBy::Counter));
        check(5.0, |i| 5e6 * i as f64, (TimeUnit::Nanoseconds, UnitBy::Counter));
        check(1.76e9, |i| 0.01 * i as f64, (TimeUnit::Seconds, UnitBy::Epoch));
        check(1.76e18, |i| 1e7 * i as f64, (TimeUnit::Nanoseconds, UnitBy::Epoch));
        // An oscillation of 4 rad/s sampled every 5 ms, with its rate: 5 is no step in seconds.
        let x = |i: usize, j: usize| [(0.02 * i as f64).sin(), 4.0 * (0.02 * i as f64).cos()][j];
        assert_eq!(
            unit_in_values(&[recording(2, |i| 5.0 * i as f64, x)], 0.0),
            Ok((TimeUnit::Milliseconds, UnitBy::Rates))
        );
    }

    #[test]
    fn even_steps_of_ten_may_be_seconds_or_milliseconds() {
        for step in [10.0, 60.0, 5000.0] {
            let slow = recording(1, |i| step * i as f64, |i, _| (0.1 * i as f64).sin());
            assert_eq!(unit_in_values(&[slow], 0.0), Err(step));
        }
    }
}
