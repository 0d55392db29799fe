//! Rollouts in a table: which rows belong together, what was measured, what was done.

use std::ops::Range;
use std::path::Path;

use ndarray::{Array2, Axis};

use crate::missing_code::Codes;
use crate::rounding::{Resolution, Written};
use crate::table::Table;
use crate::{LogError, Place, date};

/// Consecutive rows of one trajectory.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Recording {
    /// Which table it is of.
    pub(crate) table: usize,
    /// What the column `trajectory` says.
    pub(crate) label: String,
    /// Number of each row's line in the file (T).
    pub(crate) lines: Vec<usize>,
    /// Times of the rows (T); empty where there are none. Since the first row of all, as stamped, until their unit is known; then in seconds.
    pub(crate) times: Vec<f64>,
    /// States (T, n).
    pub(crate) states: Array2<f64>,
    /// Inputs (T, k), each held until the next row; those of the last row are of no use and may be missing (0 then).
    pub(crate) inputs: Array2<f64>,
}

/// What the text of the numbers tells about where they came from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Digits {
    /// Most decimals of a time stamp.
    pub(crate) time_decimals: usize,
    /// Whether time stamps are dates, read as nanoseconds since 1970; decimals are then those of their seconds.
    pub(crate) dates: bool,
    /// The first time stamp.
    pub(crate) origin: f64,
    /// Whether every state is a float32, as far as the text tells.
    pub(crate) float32: bool,
    /// Per state, and then per input: how its numbers were written.
    pub(crate) written: Vec<Written>,
    /// Rows without a value, and the first of them.
    pub(crate) missing: Option<(usize, Cell)>,
}

/// Numbers of the columns to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Selected {
    pub(crate) states: Vec<usize>,
    pub(crate) inputs: Vec<usize>,
    pub(crate) time: Option<usize>,
    pub(crate) trajectory: Option<usize>,
}

/// A table, and which of its columns are what.
#[derive(Debug)]
pub(crate) struct Source<'a> {
    pub(crate) table: &'a Table,
    pub(crate) columns: Selected,
}

impl Source<'_> {
    pub(crate) fn path(&self) -> &Path {
        self.table.path()
    }

    /// What the column of the time is called.
    pub(crate) fn time_name(&self) -> &str {
        self.columns.time.map_or(crate::TIME, |column| &self.table.columns()[column].name)
    }

    /// The time stamp in `line`, as it is written.
    pub(crate) fn stamp(&self, line: usize) -> String {
        let row = self.table.rows().find(|(number, _)| *number == line);
        row.zip(self.columns.time).map_or_else(String::new, |((_, cells), column)| cells[column].to_string())
    }
}

impl Recording {
    /// Time from each row to the next (T − 1).
    pub(crate) fn steps(&self) -> impl Iterator<Item = f64> {
        self.times.windows(2).map(|pair| pair[1] - pair[0])
    }

    /// The rows number `range`.
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        self.only(&range.collect::<Vec<_>>())
    }

    /// The rows number `kept`.
    pub(crate) fn only(&self, kept: &[usize]) -> Self {
        Self {
            table: self.table,
            label: self.label.clone(),
            lines: kept.iter().map(|i| self.lines[*i]).collect(),
            times: kept.iter().filter_map(|i| self.times.get(*i).copied()).collect(),
            states: self.states.select(Axis(0), kept),
            inputs: self.inputs.select(Axis(0), kept),
        }
    }

    /// The same with times that many times as long.
    pub(crate) fn with_times_scaled(&self, seconds: f64) -> Self {
        Self { times: self.times.iter().map(|t| t * seconds).collect(), ..self.clone() }
    }

    /// The same with a row every `dt` \[s\].
    pub(crate) fn with_step(self, dt: f64) -> Self {
        Self { times: (0..self.lines.len()).map(|i| i as f64 * dt).collect(), ..self }
    }
}

/// Where a value is missing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Cell {
    pub(crate) row: Place,
    pub(crate) column: String,
}

/// Where row number `number` of the source number `table` is.
pub(crate) fn place(sources: &[Source<'_>], table: usize, number: usize) -> Place {
    let source = &sources[table];
    let file = (sources.len() > 1).then(|| source.path().to_owned());
    Place { file, row: source.table.row(number) }
}

/// Numbers that stand for missing values in `sources`, or those that are `given`.
pub(crate) fn codes(sources: &[Source<'_>], given: Option<&[f64]>) -> Codes {
    let (Some(first), None) = (sources.first(), given) else { return Codes::given(given.unwrap_or_default()) };
    let of_column = |column: &dyn Fn(&Selected) -> usize| {
        let values = sources.iter().flat_map(|source| {
            let column = column(&source.columns);
            source.table.rows().filter_map(move |(_, cells)| cells.get(column)?.parse::<f64>().ok())
        });
        values.filter(|v| v.is_finite()).collect::<Vec<f64>>()
    };
    let states = (0..first.columns.states.len()).map(|i| of_column(&|columns| columns.states[i]));
    Codes::shown(states, (0..first.columns.inputs.len()).map(|i| of_column(&|columns| columns.inputs[i])))
}

/// The rollouts of `sources`, in order. A row without the value of a state is left out, and ends the rollout; so does one without that
/// of an input, which is its last row.
///
/// `codes` are numbers that stand for missing values.
pub(crate) fn recordings(sources: &[Source<'_>], codes: &Codes) -> Result<(Vec<Recording>, Digits), LogError> {
    let n_columns = sources.first().map_or(0, |s| s.columns.states.len() + s.columns.inputs.len());
    let mut seen = Seen { resolutions: vec![Resolution::default(); n_columns], ..Seen::default() };
    let mut all = Vec::new();
    for (number, source) in sources.iter().enumerate() {
        all.extend(of_source(number, source, (&mut seen, codes), &|row| place(sources, number, row))?);
    }
    let written = seen.resolutions.iter().map(Resolution::written).collect();
    let digits = Digits {
        time_decimals: seen.time_decimals,
        dates: seen.dates,
        origin: seen.origin.unwrap_or(0.0),
        float32: seen.float32.holds(),
        written,
        missing: seen.missing,
    };
    // A log of nothing but missing values is told by the first of them.
    match seen.failure {
        Some(failure) if all.iter().all(|r| r.lines.len() < 2) => Err(failure),
        _ => Ok((all, digits)),
    }
}

/// What was seen of the numbers so far.
#[derive(Default)]
struct Seen {
    float32: Float32,
    resolutions: Vec<Resolution>,
    time_decimals: usize,
    dates: bool,
    origin: Option<f64>,
    missing: Option<(usize, Cell)>,
    failure: Option<LogError>,
}

impl Seen {
    /// Counts a row in which a value is missing, as `failure` says of all but codes.
    fn misses(&mut self, row: Place, column: &str, failure: Option<LogError>) {
        let (rows, _) = self.missing.get_or_insert_with(|| (0, Cell { row, column: column.to_owned() }));
        *rows += 1;
        self.failure = self.failure.take().or(failure);
    }
}

/// Whether `cell` is how programs write that there is no value.
pub(crate) fn is_missing(cell: &str) -> bool {
    ["", "nan", "-nan", "na", "n/a", "null", "none"].contains(&cell.to_lowercase().as_str())
}

/// The rollouts of one table.
fn of_source(
    number: usize,
    source: &Source<'_>,
    (seen, codes): (&mut Seen, &Codes),
    place: &dyn Fn(usize) -> Place,
) -> Result<Vec<Recording>, LogError> {
    let Source { table, columns } = source;
    let mut rollouts: Vec<Rollout> = Vec::new();
    let mut origin: Option<Stamp> = None;
    // A missing input counts where another row of the same rollout follows.
    let mut open: Option<(usize, usize, Option<LogError>)> = None;
    let mut ended = true;
    for (line, cells) in table.rows() {
        let label = columns.trajectory.map_or("", |c| &*cells[c]);
        let begins = rollouts.last().is_none_or(|r| r.label != label);
        if begins && rollouts.iter().any(|r| r.label == label) {
            let path = table.path().to_owned();
            return Err(LogError::Interleaved { path, row: table.row(line), label: label.to_owned() });
        }
        let of_column = |column: usize| table.columns()[column].name.as_str();
        if let Some((line, column, failure)) = open.take().filter(|_| !begins) {
            seen.misses(place(line), of_column(column), failure);
            ended = true;
        }
        let is_none =
            |(i, column): &(usize, &usize)| is_missing(&cells[**column]) || codes.is_state(*i, &cells[**column]);
        if let Some((_, &column)) = columns.states.iter().enumerate().find(is_none) {
            let failure = table.number(line, column, &cells[column]).err();
            seen.misses(place(line), of_column(column), failure);
            ended = true;
            continue;
        }
        if ended || begins {
            rollouts.push(Rollout { label: label.to_owned(), ..Rollout::default() });
            ended = false;
        }
        let Some(rollout) = rollouts.last_mut() else { continue };
        rollout.lines.push(line);
        if let Some(column) = columns.time {
            let cell = &*cells[column];
            let date = date::nanoseconds(cell);
            seen.dates |= date.is_some();
            let value = date.map_or_else(|| table.number(line, column, cell), |ns| Ok(ns as f64))?;
            let stamp = Stamp { value, whole: date.or_else(|| cell.parse().ok()) };
            let first = *origin.get_or_insert(stamp);
            seen.origin = seen.origin.or(Some(first.value));
            rollout.times.push(stamp.since(first));
            seen.time_decimals = seen.time_decimals.max(decimals(cell));
        }
        for (&column, resolution) in columns.states.iter().zip(&mut seen.resolutions) {
            let value = table.number(line, column, &cells[column])?;
            seen.float32.see(&cells[column], value);
            resolution.see(&cells[column], value);
            rollout.states.push(value);
        }
        let of_inputs = seen.resolutions.iter_mut().skip(columns.states.len());
        for ((i, &column), resolution) in columns.inputs.iter().enumerate().zip(of_inputs) {
            let value = match table.number(line, column, &cells[column]) {
                Err(failure) if is_missing(&cells[column]) => {
                    open = open.or(Some((line, column, Some(failure))));
                    0.0
                }
                Ok(_) if codes.is_input(i, &cells[column]) => {
                    open = open.or(Some((line, column, None)));
                    0.0
                }
                value => {
                    let value = value?;
                    resolution.see(&cells[column], value);
                    value
                }
            };
            rollout.inputs.push(value);
        }
    }
    let (n, k) = (columns.states.len(), columns.inputs.len());
    Ok(rollouts.into_iter().map(|r| r.finish(number, n, k)).collect())
}

/// A time stamp; nanoseconds since 1970 have more digits than a double.
#[derive(Debug, Clone, Copy)]
struct Stamp {
    value: f64,
    whole: Option<i64>,
}

impl Stamp {
    fn since(self, first: Self) -> f64 {
        let whole = self.whole.zip(first.whole).and_then(|(now, then)| now.checked_sub(then));
        whole.map_or(self.value - first.value, |ticks| ticks as f64)
    }
}

#[derive(Default)]
struct Rollout {
    label: String,
    lines: Vec<usize>,
    times: Vec<f64>,
    states: Vec<f64>,
    inputs: Vec<f64>,
}

impl Rollout {
    fn finish(self, table: usize, n: usize, k: usize) -> Recording {
        let rows = self.lines.len();
        let array = |width, values| Array2::from_shape_vec((rows, width), values).expect("rows are pushed whole");
        Recording {
            table,
            label: self.label,
            states: array(n, self.states),
            inputs: array(k, self.inputs),
            lines: self.lines,
            times: self.times,
        }
    }
}

/// Decimals of the number, or of the seconds of a date, that `cell` writes; many where it has an exponent.
fn decimals(cell: &str) -> usize {
    if cell.contains(['e', 'E']) {
        return usize::MAX;
    }
    let digits = |decimals: &str| decimals.chars().take_while(char::is_ascii_digit).count();
    cell.split_once('.').map_or(0, |(_, decimals)| digits(decimals))
}

/// Whether numbers were float32 before they were printed: in full, or with the fewest digits that tell them apart.
#[derive(Debug, Default)]
struct Float32 {
    refuted: bool,
    /// A number was seen that few others than float32 would be.
    telling: bool,
}

impl Float32 {
    /// Bits of a mantissa that numbers of a few digits do not need.
    const TELLING_BITS: u32 = 16;

    fn see(&mut self, text: &str, value: f64) {
        let narrow = value as f32;
        if f64::from(narrow).to_bits() == value.to_bits() {
            let used = 24_u32.saturating_sub((narrow.to_bits() & 0x007f_ffff).trailing_zeros().min(23));
            // Counts are whole in any format.
            self.telling |= used > Self::TELLING_BITS && narrow.fract() != 0.0;
            return;
        }
        // The shortest decimal of a float32 has at most nine digits; seven are more than most logs of anything else have.
        let digits = |s: &str| {
            let mantissa = s.trim_start_matches(['-', '+']).split(['e', 'E']).next().unwrap_or("");
            let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
            digits.trim_start_matches('0').trim_end_matches('0').to_owned()
        };
        let written = digits(text);
        self.refuted |= written != digits(&format!("{narrow:e}"));
        self.telling |= written.len() >= 7;
    }

    fn holds(&self) -> bool {
        self.telling && !self.refuted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn float32_is_told_from_float64_and_from_few_digits() {
        let check = |cells: &[&str], expected| {
            let mut seen = Float32::default();
            cells.iter().for_each(|c| seen.see(c, c.parse().unwrap()));
            assert_eq!(seen.holds(), expected, "{cells:?}");
        };
        check(&["0.10000000149011612", "-0.30000001192092896", "0"], true);
        check(&["0.1", "0.33333334", "-1.2345679e-05", "2"], true);
        check(&["0.1", "0.3333333333333333"], false);
        check(&["0.33333334", "0.1234567891"], false);
        check(&["0.1", "0.25", "3.14"], false);
        check(&["1", "2", "0.5"], false);
        check(&["99990", "99987", "8388607"], false);
    }
}
