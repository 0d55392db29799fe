//! Which rows train, which are held out, and in which order members see them.

use ndarray::ArrayView2;
use rand::RngExt as _;
use sindyna_core::{FitError, Rng};

use super::standard::Standard;

/// The rows of a fit, in two parts.
#[derive(Debug)]
pub(super) struct Split {
    pub(super) training: Vec<usize>,
    pub(super) holdout: Vec<usize>,
}

impl Split {
    /// Holds out a `share` (at most a half) of `n` rows at random, at most `most`.
    pub(super) fn draw(n: usize, share: f64, most: usize, rng: &mut Rng) -> Result<Self, FitError> {
        let held_out = ((n as f64 * share) as usize).min(most);
        // At least one row to judge by and two whose spread is something.
        if held_out == 0 || n < held_out + 2 {
            let needed = 3.max((1.0 / share).ceil() as usize).max(n + 1);
            let unknowns = format!("an ensemble of networks with {share} of the rows held out");
            return Err(FitError::TooFewRows { got: n, needed, unknowns });
        }
        let mut holdout: Vec<usize> = (0..n).collect();
        shuffle(&mut holdout, rng);
        let training = holdout.split_off(held_out);
        Ok(Self { training, holdout })
    }
}

/// As many numbers below `n` as there are places in `rows`, with repetition: a bootstrap sample.
pub(super) fn bootstrap(n: usize, rng: &mut Rng) -> Vec<usize> {
    (0..n).map(|_| rng.random_range(0..n)).collect()
}

/// Brings `rows` into a random order (Fisher, Yates).
pub(super) fn shuffle(rows: &mut [usize], rng: &mut Rng) {
    for last in (1..rows.len()).rev() {
        rows.swap(last, rng.random_range(0..=last));
    }
}

/// Rows of inputs and targets as the networks see them.
#[derive(Debug, Default)]
pub(super) struct Table {
    /// (rows, inputs).
    pub(super) inputs: Vec<f32>,
    /// (rows, targets).
    pub(super) targets: Vec<f32>,
}

impl Table {
    /// The `rows` of both, standardised.
    pub(super) fn new(
        (inputs, input_scale): (ArrayView2<'_, f64>, &Standard),
        (targets, target_scale): (ArrayView2<'_, f64>, &Standard),
        rows: &[usize],
    ) -> Self {
        let mut table = Self::default();
        for &row in rows {
            table.inputs.extend(input_scale.apply(inputs.row(row)));
            table.targets.extend(target_scale.apply(targets.row(row)));
        }
        table
    }

    /// Overwrites this with the rows of `from` that `rows` names; `widths` are those of inputs and targets.
    pub(super) fn gather(&mut self, from: &Self, (inputs, targets): (usize, usize), rows: &[usize]) {
        self.inputs.clear();
        self.targets.clear();
        for &row in rows {
            self.inputs.extend_from_slice(&from.inputs[row * inputs..(row + 1) * inputs]);
            self.targets.extend_from_slice(&from.targets[row * targets..(row + 1) * targets]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::Seed;

    #[test]
    fn every_row_is_in_one_part_and_the_holdout_is_as_large_as_asked() {
        for (n, share, most, held_out) in [(100, 0.2, 5000, 20), (100_000, 0.2, 5000, 5000), (5, 0.2, 5000, 1)] {
            let split = Split::draw(n, share, most, &mut Seed::new(1).numpy()).expect("enough rows");
            assert_eq!(split.holdout.len(), held_out);
            let mut all = [split.training, split.holdout].concat();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..n));
        }
    }

    #[test]
    fn too_few_rows_say_how_many_are_needed() {
        for (n, share, needed) in [(4, 0.2, 5), (0, 0.1, 10), (9, 0.1, 10), (2, 0.5, 3)] {
            let error = Split::draw(n, share, 5000, &mut Seed::new(1).numpy()).expect_err("too few");
            assert!(matches!(error, FitError::TooFewRows { got, needed: m, .. } if (got, m) == (n, needed)), "{error}");
        }
    }
}
