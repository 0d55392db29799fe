//! Rollouts in a table: which rows belong together, what was measured, what was done.

use ndarray::Array2;

use crate::LogError;
use crate::resolution::Resolution;
use crate::table::Table;

/// The rows of one rollout.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Recording {
    /// What the column `trajectory` says.
    pub(crate) label: String,
    /// Number of each row's line in the file (T).
    pub(crate) lines: Vec<usize>,
    /// Time stamps \[s\] (T); empty where there are none.
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
    /// Whether every state is a float32, as far as the text tells.
    pub(crate) float32: bool,
    /// Per state: the step to which it was rounded, where it was.
    pub(crate) steps: Vec<Option<f64>>,
}

/// Numbers of the columns to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Selected {
    pub(crate) states: Vec<usize>,
    pub(crate) inputs: Vec<usize>,
    pub(crate) time: Option<usize>,
    pub(crate) trajectory: Option<usize>,
}

/// The rollouts of `table`, in order.
pub(crate) fn recordings(table: &Table, columns: &Selected) -> Result<(Vec<Recording>, Digits), LogError> {
    let mut rollouts: Vec<Rollout> = Vec::new();
    let mut float32 = Float32::default();
    let mut resolutions = vec![Resolution::default(); columns.states.len()];
    let mut time_decimals = 0;
    // A missing input is forgiven where no row of the same rollout follows.
    let mut missing: Option<LogError> = None;
    for row in table.rows() {
        let (line, cells) = row?;
        let label = columns.trajectory.map_or("", |c| &*cells[c]);
        if rollouts.last().is_none_or(|r| r.label != label) {
            if rollouts.iter().any(|r| r.label == label) {
                let path = table.path().to_owned();
                return Err(LogError::Interleaved { path, line, label: label.to_owned() });
            }
            missing = None;
            rollouts.push(Rollout { label: label.to_owned(), ..Rollout::default() });
        }
        if let Some(failure) = missing {
            return Err(failure);
        }
        missing = None;
        let Some(rollout) = rollouts.last_mut() else { continue };
        rollout.lines.push(line);
        if let Some(column) = columns.time {
            rollout.times.push(table.number(line, column, &cells[column])?);
            time_decimals = time_decimals.max(decimals(&cells[column]));
        }
        for (&column, resolution) in columns.states.iter().zip(&mut resolutions) {
            let value = table.number(line, column, &cells[column])?;
            float32.see(&cells[column], value);
            resolution.see(&cells[column], value);
            rollout.states.push(value);
        }
        for &column in &columns.inputs {
            let value = match table.number(line, column, &cells[column]) {
                Err(failure) if cells[column].is_empty() => {
                    missing = missing.or(Some(failure));
                    0.0
                }
                value => value?,
            };
            rollout.inputs.push(value);
        }
    }
    let rollouts = rollouts.into_iter().map(|r| r.finish(columns.states.len(), columns.inputs.len())).collect();
    let steps = resolutions.iter().map(Resolution::step).collect();
    Ok((rollouts, Digits { time_decimals, float32: float32.holds(), steps }))
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
    fn finish(self, n: usize, k: usize) -> Recording {
        let rows = self.lines.len();
        let array = |width, values| Array2::from_shape_vec((rows, width), values).expect("rows are pushed whole");
        Recording {
            label: self.label,
            states: array(n, self.states),
            inputs: array(k, self.inputs),
            lines: self.lines,
            times: self.times,
        }
    }
}

/// Decimals of the number that `cell` writes; many where it has an exponent.
fn decimals(cell: &str) -> usize {
    if cell.contains(['e', 'E']) {
        return usize::MAX;
    }
    cell.split_once('.').map_or(0, |(_, decimals)| decimals.len())
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
            self.telling |= used > Self::TELLING_BITS;
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
    }
}
