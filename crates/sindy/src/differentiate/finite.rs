//! Finite differences of any order.

use faer::Mat;
use faer::linalg::solvers::Solve as _;
use ndarray::{Array2, ArrayView2};

use crate::error::InvalidParam;

/// A trajectory with too few samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a trajectory of {got} samples is too short, at least {needed} are needed")]
pub struct TooShort {
    /// Samples found.
    pub got: usize,
    /// Samples needed.
    pub needed: usize,
}

/// First derivatives by finite differences of order p on uniform samples.
///
/// The stencil has p + 1 samples: around the point where there are enough on both sides (for odd p one more after it, so
/// that p = 1 is the forward difference), at the ends the first or last p + 1. Order 2 is
/// `numpy.gradient(edge_order=2)`.
///
/// # References
/// PySINDy 2.1, `FiniteDifference`: same stencils, same ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiniteDifference {
    order: usize,
}

impl Default for FiniteDifference {
    /// Order 2.
    fn default() -> Self {
        Self { order: 2 }
    }
}

/// Stencils beyond this are numerically worthless.
const MAX_ORDER: usize = 12;

impl FiniteDifference {
    /// Differences of `order`, from 1 to 12.
    ///
    /// # Errors
    /// [`InvalidParam`] for another order.
    pub fn new(order: usize) -> Result<Self, InvalidParam> {
        if (1..=MAX_ORDER).contains(&order) {
            Ok(Self { order })
        } else {
            Err(InvalidParam { name: "order", value: order as f64, wanted: "between 1 and 12" })
        }
    }

    /// ẋ (T, n) of one trajectory `x` (T, n) of samples `dt` \[s\] apart.
    ///
    /// # Errors
    /// [`TooShort`] if T is smaller than the stencil.
    pub fn differentiate(&self, x: ArrayView2<'_, f64>, dt: f64) -> Result<Array2<f64>, TooShort> {
        let (t, n) = x.dim();
        let count = self.order + 1;
        if t < count {
            return Err(TooShort { got: t, needed: count });
        }
        let before = (count - 1) / 2;
        let inside = weights(-(before as f64), count);
        let x = x.as_standard_layout();
        let values = x.as_slice().expect("standard layout was made");
        // The number that adding anything to leaves as it is.
        let mut x_dot = Array2::from_elem((t, n), -0.0);
        let out = x_dot.as_slice_mut().expect("it was made in standard layout");
        // Samples that have the same weights lie one after the other: those at the start one by one, all between, those at the end one by one.
        let last = t - (count - 1 - before);
        let alone = (0..before).chain(last..t).map(|i| i..i + 1);
        for rows in alone.chain(std::iter::once(before..last)) {
            let first = rows.start.saturating_sub(before).min(t - count);
            let at_end = rows.start - first != before;
            let edge = at_end.then(|| weights(first as f64 - rows.start as f64, count));
            let out = &mut out[rows.start * n..rows.end * n];
            differences(out, &values[first * n..], n, edge.as_ref().unwrap_or(&inside), dt);
        }
        Ok(x_dot)
    }
}

/// Adds Σ `weights`ₖ of `values` k rows of `n` further on to each of `out`, and divides it by `dt`.
fn differences(out: &mut [f64], values: &[f64], n: usize, weights: &[f64], dt: f64) {
    /// Numbers that are computed side by side.
    const LANES: usize = 16;
    let n_out = out.len();
    let (chunks, rest) = out.as_chunks_mut::<LANES>();
    let n_chunked = n_out - rest.len();
    for (number, chunk) in chunks.iter_mut().enumerate() {
        for (k, w) in weights.iter().enumerate() {
            let Some(values) = values[k * n + number * LANES..].first_chunk::<LANES>() else { return };
            for l in 0..LANES {
                chunk[l] += w * values[l];
            }
        }
        for slot in chunk {
            *slot /= dt;
        }
    }
    for (i, slot) in rest.iter_mut().enumerate() {
        let sum = weights.iter().enumerate().fold(*slot, |sum, (k, w)| sum + w * values[k * n + n_chunked + i]);
        *slot = sum / dt;
    }
}

/// Weights w with Σ wₖ f(first + k) ≈ f'(0), exact for polynomials of degree < `count`.
fn weights(first: f64, count: usize) -> Vec<f64> {
    // Row m: Σ wₖ sₖᵐ = d/ds sᵐ at 0.
    let vandermonde = Mat::from_fn(count, count, |m, k| (first + k as f64).powi(m as i32));
    let right = Mat::from_fn(count, 1, |m, _| if m == 1 { 1.0 } else { 0.0 });
    let w = vandermonde.partial_piv_lu().solve(right);
    (0..count).map(|k| w[(k, 0)]).collect()
}
