//! Plain least squares of small systems.

use faer::MatRef;
use faer::linalg::solvers::SolveLstsq as _;

/// The x that minimises ‖A x − b‖; of several the one with the smallest norm. A is (n, k), b (n, 1).
pub(crate) fn least_squares(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Vec<f64> {
    let k = a.ncols();
    let qr = (a.nrows() >= k).then(|| a.qr());
    // A diagonal without tiny entries means the columns are independent; anything doubtful goes to the SVD.
    if let Some(qr) = qr.filter(|qr| well_conditioned(qr.thin_R())) {
        let x = qr.solve_lstsq(b);
        return (0..k).map(|j| x[(j, 0)]).collect();
    }
    truncated(a, b, f64::EPSILON)
}

/// The x of smallest norm that minimises ‖A x − b‖ where singular values up to `cutoff` times the largest count as zero.
pub(crate) fn truncated(a: MatRef<'_, f64>, b: MatRef<'_, f64>, cutoff: f64) -> Vec<f64> {
    let mut x = vec![0.0; a.ncols()];
    let Ok(svd) = a.thin_svd() else { return x };
    let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
    for i in (0..s.nrows()).filter(|&i| s[i] > cutoff * s[0]) {
        let weight: f64 = (0..a.nrows()).map(|row| u[(row, i)] * b[(row, 0)]).sum::<f64>() / s[i];
        for (j, x) in x.iter_mut().enumerate() {
            *x += weight * v[(j, i)];
        }
    }
    x
}

fn well_conditioned(r: MatRef<'_, f64>) -> bool {
    let diagonal = (0..r.ncols()).map(|j| r[(j, j)].abs());
    let largest = diagonal.clone().fold(0.0, f64::max);
    largest > 0.0 && diagonal.fold(f64::INFINITY, f64::min) > 1e-12 * largest
}
