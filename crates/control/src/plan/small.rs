//! Small dense matrices.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};
use ndarray::{Array1, Array2, ArrayView1};

use crate::matrix::{inner, outer};

/// Rounds in which the set of controls at their limits is found: one more than there can be changes of few controls.
const ROUNDS: usize = 20;

/// C + A B in the place of C (n, p), all row by row, where A and C have n rows and B has as many as A has columns. Smaller than any packed product is worth.
pub(crate) fn add_product(a: &[f64], b: &[f64], n: usize, c: &mut [f64]) {
    let (m, p) = (a.len() / n, c.len() / n);
    for (a, c) in a.chunks_exact(m).zip(c.chunks_exact_mut(p)) {
        for (a, b) in a.iter().zip(b.chunks_exact(p)) {
            c.iter_mut().zip(b).for_each(|(c, b)| *c += a * b);
        }
    }
}

/// C + Aᵀ B in the place of C, where A and B have `m` rows.
pub(crate) fn add_transposed(a: &[f64], b: &[f64], m: usize, c: &mut [f64]) {
    let (n, p) = (a.len() / m, b.len() / m);
    for (a, b) in a.chunks_exact(n).zip(b.chunks_exact(p)) {
        for (a, c) in a.iter().zip(c.chunks_exact_mut(p)) {
            c.iter_mut().zip(b).for_each(|(c, b)| *c += a * b);
        }
    }
}

/// Whether symmetric `a` is positive definite.
pub(crate) fn is_positive(a: &Array2<f64>) -> bool {
    match a.dim() {
        (1, 1) => a[[0, 0]] > 0.0,
        _ => inner(a.view()).llt(Side::Lower).is_ok(),
    }
}

/// Symmetric `a` with its negative eigenvalues at 0.
pub(crate) fn without_negative(a: &Array2<f64>) -> Array2<f64> {
    let Ok(eigen) = inner(a.view()).self_adjoint_eigen(Side::Lower) else { return Array2::zeros(a.dim()) };
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    if (0..a.nrows()).all(|i| values[i] >= 0.0) {
        return a.clone();
    }
    let scaled = Mat::from_fn(a.nrows(), a.nrows(), |i, j| vectors[(i, j)] * values[j].max(0.0));
    outer((scaled * vectors.transpose()).as_ref())
}

/// The least of ½ dᵀHd + gᵀd within `low` and `high`, by projected Newton steps, and the gain −H⁻¹ C of those values that are not at a limit, where C (k, n) is given
/// row by row.
pub(crate) fn box_newton(
    h: &Array2<f64>,
    g: &[f64],
    c: &[f64],
    low: &[f64],
    high: &[f64],
) -> Option<(Array1<f64>, Array2<f64>)> {
    let k = g.len();
    let n = c.len() / k;
    let mut d: Array1<f64> = Array1::zeros(k);
    if let ([g], [low], [high]) = (g, low, high) {
        let inverse = Some(h[[0, 0]].recip()).filter(|inverse| inverse.is_finite())?;
        d[0] = (-g * inverse).clamp(*low, *high);
        // A control that ends at its limit is not corrected.
        let times = if *low < d[0] && d[0] < *high { -inverse } else { 0.0 };
        return Some((d, Array2::from_shape_fn((1, n), |(_, i)| times * c[i])));
    }
    let g = ArrayView1::from(g);
    let mut free: Vec<usize> = (0..k).collect();
    for _ in 0..ROUNDS {
        let slope = h.dot(&d) + g;
        let held = |j: usize| (d[j] <= low[j] && slope[j] > 0.0) || (d[j] >= high[j] && slope[j] < 0.0);
        let now: Vec<usize> = (0..k).filter(|j| !held(*j)).collect();
        if now.is_empty() {
            free = now;
            break;
        }
        let step = solved(h, &now, |i, _| -slope[now[i]], 1)?;
        let (mut moved, mut most) = (d.clone(), 0.0_f64);
        for (i, &j) in now.iter().enumerate() {
            moved[j] = (d[j] + step[(i, 0)]).clamp(low[j], high[j]);
            most = most.max((moved[j] - d[j]).abs());
        }
        let settled = now == free && most <= 1e-12;
        (d, free) = (moved, now);
        if settled {
            break;
        }
    }
    let mut gain = Array2::zeros((k, n));
    if !free.is_empty() {
        let of_free = solved(h, &free, |i, j| -c[free[i] * n + j], n)?;
        for (i, &row) in free.iter().enumerate() {
            // A control that ends at its limit is not corrected.
            if d[row] > low[row] && d[row] < high[row] {
                (0..n).for_each(|j| gain[[row, j]] = of_free[(i, j)]);
            }
        }
    }
    Some((d, gain))
}

/// H⁻¹ of the rows and columns `of`, times a right side (rows of `of`, `columns`).
fn solved(h: &Array2<f64>, of: &[usize], right: impl Fn(usize, usize) -> f64, columns: usize) -> Option<Mat<f64>> {
    let right = Mat::from_fn(of.len(), columns, right);
    if let [j] = of {
        let inverse = h[[*j, *j]].recip();
        return inverse.is_finite().then(|| right * faer::Scale(inverse));
    }
    let part = Mat::from_fn(of.len(), of.len(), |i, j| h[[of[i], of[j]]]);
    Some(part.llt(Side::Lower).ok()?.solve(right))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn limits_are_met_and_what_is_free_is_the_least() {
        let (h, g) = (array![[2.0, 1.0], [1.0, 2.0]], [-4.0, 0.0]);
        let c = [1.0, 1.0];
        let (d, gain) = box_newton(&h, &g, &c, &[-9.0; 2], &[9.0; 2]).expect("positive");
        assert!((d[0] - 8.0 / 3.0).abs() < 1e-12 && (d[1] + 4.0 / 3.0).abs() < 1e-12, "{d}");
        assert!((gain[[0, 0]] + 1.0 / 3.0).abs() < 1e-12);
        // With d₀ at 1, d₁ is the least of d₁² + d₁.
        let (d, gain) = box_newton(&h, &g, &c, &[-1.0; 2], &[1.0; 2]).expect("positive");
        assert!((d[0] - 1.0).abs() < 1e-12 && (d[1] + 0.5).abs() < 1e-12, "{d}");
        assert_eq!((gain[[0, 0]], gain[[1, 0]]), (0.0, -0.5));
    }

    #[test]
    fn negative_curvature_is_taken_away() {
        let a = without_negative(&array![[1.0, 2.0], [2.0, 1.0]]);
        // Eigenvalues 3 and −1: what is left is 3 along (1, 1)/√2.
        assert!(a.iter().all(|v| (v - 1.5).abs() < 1e-12), "{a}");
    }
}
