//! Numbers that stand for a missing value, such as −999.

/// Distance of a code from all other values of its column, as a multiple of their range, that it exceeds.
const APART: f64 = 3.0;

/// Values of a column, below which nothing is told; and the share of them that may be missing.
const FEWEST: usize = 20;
const MOST: f64 = 0.3;

/// Codes of the columns that are read: those of the states, then those of the inputs.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Codes {
    states: Vec<Option<f64>>,
    inputs: Vec<Option<f64>>,
    given: Vec<f64>,
}

impl Codes {
    /// Those that are `given`.
    pub(crate) fn given(given: &[f64]) -> Self {
        Self { given: given.to_vec(), ..Self::default() }
    }

    /// Those that the values of states and inputs show, a list for each column.
    pub(crate) fn shown(states: impl Iterator<Item = Vec<f64>>, inputs: impl Iterator<Item = Vec<f64>>) -> Self {
        Self { states: states.map(code).collect(), inputs: inputs.map(code).collect(), given: Vec::new() }
    }

    /// Whether `cell` of state number `i` is the code of its column.
    pub(crate) fn is_state(&self, i: usize, cell: &str) -> bool {
        self.is(self.states.get(i), cell)
    }

    /// The same of input number `i`.
    pub(crate) fn is_input(&self, i: usize, cell: &str) -> bool {
        self.is(self.inputs.get(i), cell)
    }

    fn is(&self, own: Option<&Option<f64>>, cell: &str) -> bool {
        let own = own.copied().flatten();
        // Most columns have none, and cells are many.
        (own.is_some() || !self.given.is_empty())
            && cell.parse::<f64>().is_ok_and(|value| own == Some(value) || self.given.contains(&value))
    }

    /// What was recognised: numbers of columns, the inputs after the states, and their codes.
    pub(crate) fn recognised(&self) -> impl Iterator<Item = (usize, f64)> {
        self.states.iter().chain(&self.inputs).enumerate().filter_map(|(i, code)| Some((i, (*code)?)))
    }
}

/// The number that stands for a missing value among `values`: the largest or smallest of them, if it occurs more than once and is far from all others.
fn code(mut values: Vec<f64>) -> Option<f64> {
    if values.len() < FEWEST {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let (first, last) = (values[0], values[values.len() - 1]);
    let firsts = values.iter().take_while(|v| v.to_bits() == first.to_bits()).count();
    let lasts = values.iter().rev().take_while(|v| v.to_bits() == last.to_bits()).count();
    let is_code = |end: f64, count: usize, others: &[f64]| {
        let (Some(low), Some(high)) = (others.first(), others.last()) else { return false };
        let (range, apart) = (high - low, (low - end).max(end - high));
        let many = others.len() >= FEWEST / 2 && count as f64 <= MOST * values.len() as f64;
        count > 1 && many && range > 0.0 && apart > APART * range
    };
    if is_code(first, firsts, &values[firsts..]) {
        return Some(first);
    }
    is_code(last, lasts, &values[..values.len() - lasts]).then_some(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_repeated_and_far_from_everything_else() {
        let wave = |i: usize| (0.1 * i as f64).sin();
        let with = |of: &dyn Fn(usize) -> f64| code((0..100).map(of).collect());
        assert_eq!(with(&|i| if i % 40 == 3 { -999.0 } else { wave(i) }), Some(-999.0));
        assert_eq!(with(&|i| if i % 40 == 3 { 9999.0 } else { wave(i) }), Some(9999.0));
        assert_eq!(with(&|i| if i == 3 { -999.0 } else { wave(i) }), None, "a single value is an outlier");
        assert_eq!(with(&|i| if i % 40 == 3 { -2.0 } else { wave(i) }), None, "near the others");
        assert_eq!(with(&|i| if i % 40 == 3 { 24.0 } else { 0.0 }), None, "a switch");
        assert_eq!(with(&|i| if i % 2 == 0 { 1e6 } else { wave(i) }), None, "half of them");
        assert_eq!(code(vec![-999.0, -999.0, 0.1, 0.2]), None, "too few to tell");
    }
}
