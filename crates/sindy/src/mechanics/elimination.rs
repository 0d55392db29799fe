//! Fewer and fewer columns of a regression.

use faer::Mat;
use faer::linalg::solvers::Solve as _;

use crate::Triangle;

/// Part of a column of unit length that is added to it in a direction of its own, so that columns that depend on each other have coefficients too.
const RIDGE: f64 = 1e-13;

/// Columns with coefficients, and what they leave.
#[derive(Debug, Clone)]
pub(super) struct Size {
    pub(super) columns: Vec<usize>,
    pub(super) values: Vec<f64>,
    /// Norm of the residual.
    pub(super) left: f64,
}

/// The regression of a target on all columns before the last one of `triangle`, and on fewer and fewer of them, each time without the one that is missed
/// least. The last column is what `known` coefficients of all leave of the target, so that what is small is told from what is rounding.
pub(super) fn eliminated(triangle: &Triangle, known: &[f64]) -> Vec<Size> {
    let target = triangle.n_columns() - 1;
    let height = triangle.column(target).len();
    let at = |i: usize, j: usize| triangle.column(j).get(i).copied().unwrap_or(0.0);
    let mut left: Vec<f64> = (0..height).map(|i| at(i, target)).collect();
    let mut columns: Vec<usize> = (0..target).collect();
    let mut path = Vec::with_capacity(target);
    while !columns.is_empty() {
        let k = columns.len();
        let norms: Vec<f64> = columns.iter().map(|&j| triangle.norm(j).max(f64::MIN_POSITIVE)).collect();
        let a = Mat::from_fn(height + k, k, |i, j| match i.checked_sub(height) {
            None => at(i, columns[j]) / norms[j],
            Some(own) if own == j => RIDGE,
            Some(_) => 0.0,
        });
        let b = Mat::from_fn(height + k, 1, |i, _| left.get(i).copied().unwrap_or(0.0));
        let qr = a.qr();
        let r = qr.thin_R();
        let rotated = qr.compute_thin_Q().transpose() * &b;
        let upper = Mat::from_fn(k, k, |i, j| if i <= j { r[(i, j)] } else { 0.0 });
        let lu = upper.partial_piv_lu();
        let change = lu.solve(&rotated);
        let inverse = lu.solve(Mat::<f64>::identity(k, k));
        let values: Vec<f64> = (0..k).map(|j| known[columns[j]] + change[(j, 0)] / norms[j]).collect();
        path.push(Size { columns: columns.clone(), values: values.clone(), left: (&a * &change - &b).norm_l2() });
        let missed = |j: usize| {
            let size: f64 = (0..k).map(|i| inverse[(j, i)].powi(2)).sum();
            (values[j] * norms[j]).powi(2) / size
        };
        let least = (0..k).min_by(|&i, &j| missed(i).total_cmp(&missed(j))).unwrap_or(0);
        let out = columns.remove(least);
        left.iter_mut().enumerate().for_each(|(i, left)| *left += known[out] * at(i, out));
    }
    path
}
