//! Between ndarray's arrays, which cross the crate's border, and faer's matrices, which compute.

use faer::{Mat, MatRef};
use ndarray::{Array2, ArrayView2};

pub(crate) fn inner(a: ArrayView2<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[[i, j]])
}

pub(crate) fn outer(a: MatRef<'_, f64>) -> Array2<f64> {
    Array2::from_shape_fn((a.nrows(), a.ncols()), |(i, j)| a[(i, j)])
}

/// max |a_ij|; infinite where an entry is NaN, so that a comparison can see it.
pub(crate) fn largest(a: MatRef<'_, f64>) -> f64 {
    let entries = (0..a.ncols()).flat_map(|j| (0..a.nrows()).map(move |i| a[(i, j)].abs()));
    entries.fold(0.0, |most, v| if v.is_nan() { f64::INFINITY } else { f64::max(most, v) })
}
