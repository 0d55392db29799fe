//! How far coefficients may be off.

use ndarray::Array2;
use sindyna_core::Dataset;
use sindyna_sindy::{EquationReport, Term, Triangle};

/// Standard errors of the coefficients of `equation`, which was fitted to every step of `data` with terms among `terms`:
/// the roots of the diagonal of σ² (Θ_SᵀΘ_S)⁻¹, σ² = RSS / (N − |S|).
///
/// Empty where they are not known: with no more steps than terms, or with terms that depend on each other. Errors of
/// different steps are taken as independent, and those that enter through the terms as small.
pub(super) fn standard_errors(equation: &EquationReport, terms: &[Term], data: &Dataset) -> Vec<f64> {
    let (support, n_rows) = (&equation.support, data.n_steps());
    if n_rows <= support.len() {
        return Vec::new();
    }
    let mut triangle = Triangle::new(support.len());
    let mut z = Vec::new();
    for rollout in data.rollouts() {
        let mut rows = Array2::zeros((rollout.controls.nrows(), support.len()));
        for (i, mut row) in rows.rows_mut().into_iter().enumerate() {
            z.clear();
            z.extend(rollout.observations.row(i).iter().chain(rollout.controls.row(i)));
            for (value, &term) in row.iter_mut().zip(support) {
                *value = terms[term].expr.eval(&z);
            }
        }
        if triangle.push(rows.view()).is_err() {
            return Vec::new();
        }
    }
    let sigma = equation.residual * (n_rows as f64 / (n_rows - support.len()) as f64).sqrt();
    let lengths = inverse_row_norms(&triangle);
    lengths.map_or_else(Vec::new, |lengths| lengths.into_iter().map(|l| sigma * l).collect())
}

/// The length of each row of R⁻¹; `None` where R has none.
fn inverse_row_norms(triangle: &Triangle) -> Option<Vec<f64>> {
    /// Part of a column that must be left after the columns before it are taken out, for it to say anything.
    const OWN: f64 = 1e-12;
    let n = triangle.n_columns();
    let r = |i: usize, j: usize| triangle.column(j).get(i).copied().unwrap_or(0.0);
    if (0..n).any(|j| r(j, j).abs() <= OWN * triangle.norm(j)) {
        return None;
    }
    let mut squares = vec![0.0; n];
    for k in 0..n {
        // Column k of R⁻¹ by back substitution; it is zero below row k.
        let mut column = vec![0.0; n];
        for i in (0..=k).rev() {
            let rest: f64 = (i + 1..=k).map(|j| r(i, j) * column[j]).sum();
            column[i] = (f64::from(u8::from(i == k)) - rest) / r(i, i);
            squares[i] += column[i] * column[i];
        }
    }
    Some(squares.into_iter().map(f64::sqrt).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_sindy::Library;

    #[test]
    fn a_line_through_points_has_the_errors_of_the_textbook() {
        // x⁺ = a + b x with residual standard deviation s: se(b) = s/√Sxx, se(a) = s √(1/N + x̄²/Sxx).
        let xs: Vec<f64> = (0..20).map(|i| 0.3 * f64::from(i) - 1.0).collect();
        let mut data = Dataset::new(1, 0, 0, 1.0);
        data.begin(&[xs[0]]).unwrap();
        xs[1..].iter().for_each(|x| data.push(&[], &[], 0.0, &[*x]).unwrap());
        let (rows, n) = (&xs[..19], 19.0);
        let mean = rows.iter().sum::<f64>() / n;
        let spread: f64 = rows.iter().map(|x| (x - mean).powi(2)).sum();
        let terms = Library::polynomial(1).terms(&["x".to_owned()]).unwrap();
        let mut equation = EquationReport {
            state: "x".into(),
            residual: 0.1,
            floor: 0.0,
            reached_floor: false,
            proved: true,
            support: vec![0, 1],
            coefficients: vec![1.0, 1.0],
            path: vec![],
        };
        let errors = standard_errors(&equation, &terms, &data);
        let s = 0.1 * (n / (n - 2.0)).sqrt();
        let expected = [s * (1.0 / n + mean * mean / spread).sqrt(), s / spread.sqrt()];
        for (error, expected) in errors.iter().zip(expected) {
            assert!((error / expected - 1.0).abs() < 1e-12, "{errors:?} is not {expected:?}");
        }
        assert_eq!(errors.len(), 2);
        equation.support = vec![1, 1];
        assert_eq!(standard_errors(&equation, &terms, &data), [0.0; 0], "a term twice");
    }
}
