//! The state that a model has after samples that were measured.

use nalgebra::{DMatrix, DVector};
use ndarray::{ArrayView2, Axis};

use super::{Inputs, Model};

/// Rounds of Gauss–Newton.
const ROUNDS: usize = 8;

/// Part of the size of an error by which derivatives are taken.
const NUDGE: f64 = 1e-3;

impl Model {
    /// The state (n) at the last of the samples `x` (T + 1, n), under the inputs `u` (T, k) held for `dt` \[s\] each (T): the end of the path of the model that is
    /// nearest to the samples, each state's errors divided by its `sizes` (n), where they are finite. `None` where the model diverges.
    #[must_use]
    pub fn state_after<'a>(
        &self,
        x: ArrayView2<'_, f64>,
        u: impl Into<Inputs<'a>>,
        dt: &[f64],
        sizes: &[f64],
    ) -> Option<Vec<f64>> {
        let n = sizes.len();
        let counted: Vec<usize> = (0..n).filter(|&i| sizes[i].is_finite() && sizes[i] > 0.0).collect();
        let end = x.index_axis(Axis(0), x.nrows() - 1).to_vec();
        if counted.is_empty() || dt.is_empty() {
            return Some(end);
        }
        let u = u.into();
        let residuals = |start: &[f64]| {
            let path = self.simulate_at(start, u, dt).ok()?;
            let of = |(simulated, measured): (ndarray::ArrayView1<'_, f64>, ndarray::ArrayView1<'_, f64>)| {
                counted.iter().map(|&i| (simulated[i] - measured[i]) / sizes[i]).collect::<Vec<_>>()
            };
            let all: Vec<f64> = path.rows().into_iter().zip(x.rows()).flat_map(of).collect();
            Some((DVector::from_vec(all), path.row(path.nrows() - 1).to_vec()))
        };
        let mut start = x.row(0).to_vec();
        let (mut left, mut reached) = residuals(&start)?;
        for _ in 0..ROUNDS {
            let mut slopes = DMatrix::zeros(left.len(), counted.len());
            for (column, &i) in counted.iter().enumerate() {
                let h = NUDGE * sizes[i];
                let mut moved = start.clone();
                moved[i] += h;
                slopes.set_column(column, &((residuals(&moved)?.0 - &left) / h));
            }
            let Some(factor) = (slopes.transpose() * &slopes).cholesky() else { break };
            let change = factor.solve(&(slopes.transpose() * &left));
            let mut next = start.clone();
            counted.iter().zip(change.iter()).for_each(|(&i, d)| next[i] -= d);
            let Some((nearer, end)) = residuals(&next).filter(|(r, _)| r.norm() < left.norm()) else { break };
            (start, left, reached) = (next, nearer, end);
        }
        Some(reached)
    }
}
