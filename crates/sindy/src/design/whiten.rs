//! Differences of neighbouring samples share an error; here they are made independent.

use ndarray::ArrayViewMut2;

/// Multiplies the rows of a run by L⁻¹, where L Lᵀ is the covariance of the errors of (x₁ − x₀)/Δt₀, (x₂ − x₁)/Δt₁, … for
/// independent errors of the samples with standard deviations `sigma` (T + 1); `dt` are the Δt (T). Afterwards the rows' errors are
/// independent and have unit variance. `extra` (T) are standard deviations of further errors of the differences, one
/// for each and independent. (It adds the differences up again, which is why noise that would drown an acceleration
/// is bearable.)
pub(crate) fn whiten(mut rows: ArrayViewMut2<'_, f64>, sigma: &[f64], extra: &[f64], dt: &[f64]) {
    let (mut last, mut shared) = (0.0, 0.0);
    for t in 0..rows.nrows() {
        let (now, next) = ((sigma[t] / dt[t]).powi(2), (sigma[t + 1] / dt[t]).powi(2));
        let below = if t == 0 { 0.0 } else { shared / last };
        let diagonal = (now + next + extra[t] * extra[t] - below * below).sqrt();
        for j in 0..rows.ncols() {
            let before = if t == 0 { 0.0 } else { rows[[t - 1, j]] };
            rows[[t, j]] = (rows[[t, j]] - below * before) / diagonal;
        }
        let later = dt.get(t + 1).copied().unwrap_or(dt[t]);
        (last, shared) = (diagonal, -sigma[t + 1].powi(2) / (dt[t] * later));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn the_covariance_of_differences_becomes_the_identity() {
        let (sigma, dt) = ([0.1, 0.3, 0.2, 0.5, 0.4], [0.5, 0.2, 0.5, 0.9]);
        // Column s: what an error of one standard deviation in sample s does to the differences.
        let mut rows = Array2::from_shape_fn((4, 5), |(t, s)| match s {
            _ if s == t + 1 => sigma[s] / dt[t],
            _ if s == t => -sigma[s] / dt[t],
            _ => 0.0,
        });
        whiten(rows.view_mut(), &sigma, &[0.0; 4], &dt);
        let covariance = rows.dot(&rows.t());
        for ((i, j), value) in covariance.indexed_iter() {
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((value - expected).abs() < 1e-12, "{i} {j}: {value}");
        }
    }
}
