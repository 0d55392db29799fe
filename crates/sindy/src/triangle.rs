//! The triangular factor every solver works on.

use faer::{Mat, MatRef};
use nalgebra::{DMatrix, DVector};
use ndarray::{ArrayView2, Axis};
use serde::{Deserialize, Serialize};

use crate::solve::{Reflected, least_squares, truncated};

/// The factor R of all candidate columns [Θ | targets], rows of the data pushed so far: RᵀR = [Θ | Y]ᵀ[Θ | Y].
///
/// Built block by block with QR, so memory does not grow with the data, blocks from elsewhere merge by one more QR, and
/// the condition number is not squared as a Gram matrix would square it. Any column can be the target of a regression:
/// the columns of R are the columns of the data seen in other coordinates, with all their inner products.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "Table", into = "Table")]
pub struct Triangle {
    /// (min(rows, columns), columns), zero below the diagonal.
    r: Mat<f64>,
    n_columns: usize,
    n_rows: usize,
}

/// A triangle as it is written down: its numbers column by column.
#[derive(Serialize, Deserialize)]
struct Table {
    n_columns: usize,
    n_rows: usize,
    numbers: Vec<f64>,
}

impl From<Triangle> for Table {
    fn from(triangle: Triangle) -> Self {
        let Triangle { r, n_columns, n_rows } = triangle;
        let numbers = (0..n_columns).flat_map(|j| (0..r.nrows()).map(move |i| (i, j))).map(|at| r[at]).collect();
        Self { n_columns, n_rows, numbers }
    }
}

impl From<Table> for Triangle {
    fn from(table: Table) -> Self {
        let Table { n_columns, n_rows, numbers } = table;
        let height = numbers.len().checked_div(n_columns).unwrap_or(0);
        Self { r: Mat::from_fn(height, n_columns, |i, j| numbers[j * height + i]), n_columns, n_rows }
    }
}

/// Why rows or triangles were refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TriangleError {
    /// Rows of another width.
    #[error("the rows have {got} columns, the triangle {expected}")]
    Width {
        /// Columns of the triangle.
        expected: usize,
        /// Columns found.
        got: usize,
    },
    /// A number that is NaN or infinite.
    #[error("column {column} of row {row} is {value}, which is not finite")]
    NotFinite {
        /// Row of the block that was pushed.
        row: usize,
        /// Column.
        column: usize,
        /// The value found.
        value: f64,
    },
}

/// Rows factored at once.
const BLOCK: usize = 512;

impl Triangle {
    /// An empty triangle of `n_columns` columns.
    #[must_use]
    pub fn new(n_columns: usize) -> Self {
        Self { r: Mat::zeros(0, n_columns), n_columns, n_rows: 0 }
    }

    /// That of `n_rows` rows with this factor; `None` if it holds what is not finite.
    pub(crate) fn of_factor(factor: &Reflected, n_rows: usize) -> Option<Self> {
        let n_columns = factor.width();
        let sign = |i: usize| if factor.at(i, i) < 0.0 { -1.0 } else { 1.0 };
        let r = Mat::from_fn(n_columns, n_columns, |i, j| sign(i) * factor.at(i, j));
        let finite = (0..n_columns).all(|j| r.col_as_slice(j).iter().all(|v| v.is_finite()));
        finite.then_some(Self { r, n_columns, n_rows })
    }

    /// Adds `rows` (N, columns).
    ///
    /// # Errors
    /// [`TriangleError`] for another width or a number that is not finite; the triangle is then as before.
    pub fn push(&mut self, rows: ArrayView2<'_, f64>) -> Result<(), TriangleError> {
        if rows.ncols() != self.n_columns {
            return Err(TriangleError::Width { expected: self.n_columns, got: rows.ncols() });
        }
        if !all_finite(rows) {
            let bad = rows.indexed_iter().find(|(_, v)| !v.is_finite());
            let ((row, column), value) = bad.expect("one of them is not finite");
            return Err(TriangleError::NotFinite { row, column, value: *value });
        }
        for block in rows.axis_chunks_iter(Axis(0), BLOCK) {
            let n = self.r.nrows();
            let mut stacked = Mat::zeros(n + block.nrows(), self.n_columns);
            for (j, column) in block.columns().into_iter().enumerate() {
                let (above, below) = stacked.col_as_slice_mut(j).split_at_mut(n);
                above.copy_from_slice(self.r.col_as_slice(j));
                match column.as_slice() {
                    Some(column) => below.copy_from_slice(column),
                    None => below.iter_mut().zip(column).for_each(|(slot, v)| *slot = *v),
                }
            }
            self.r = triangular(stacked.as_ref());
        }
        self.n_rows += rows.nrows();
        Ok(())
    }

    /// Adds the rows behind `other`.
    ///
    /// # Errors
    /// [`TriangleError::Width`] if it has other columns.
    pub fn merge(&mut self, other: &Self) -> Result<(), TriangleError> {
        if other.n_columns != self.n_columns {
            return Err(TriangleError::Width { expected: self.n_columns, got: other.n_columns });
        }
        self.r = factor(self.r.as_ref(), other.r.as_ref());
        self.n_rows += other.n_rows;
        Ok(())
    }

    /// The triangle of the columns from number `first` on, with all that those before it explain taken out of them.
    pub(crate) fn trailing(&self, first: usize) -> Self {
        let height = self.r.nrows().saturating_sub(first);
        let r = Mat::from_fn(height, self.n_columns - first, |i, j| self.r[(first + i, first + j)]);
        Self { r, n_columns: self.n_columns - first, n_rows: self.n_rows.saturating_sub(first) }
    }

    /// The same rows over the first `first` columns and, after these, the columns `others`: less work than [`Self::combined`], for the first columns are
    /// triangular already.
    pub(crate) fn with_others(&self, first: usize, others: &[usize]) -> Self {
        let below = self.r.nrows().saturating_sub(first);
        let rest = Mat::from_fn(below, others.len(), |i, j| self.r[(first + i, others[j])]);
        let rest = factor(Mat::zeros(0, others.len()).as_ref(), rest.as_ref());
        let at = |i: usize, j: usize| match j.checked_sub(first) {
            None => self.r[(i, j)],
            Some(other) if i < first => self.r[(i, others[other])],
            Some(other) => rest[(i - first, other)],
        };
        let height = self.r.nrows().min(first) + rest.nrows();
        let r = Mat::from_fn(height, first + others.len(), at);
        Self { r, n_columns: first + others.len(), n_rows: self.n_rows }
    }

    /// The same rows over combinations of the columns: of each, the numbers of columns with their factors.
    pub(crate) fn combined(&self, columns: &[Vec<(usize, f64)>]) -> Self {
        let combination = |i: usize, j: usize| columns[j].iter().map(|&(c, factor)| factor * self.r[(i, c)]).sum();
        let rows = Mat::from_fn(self.r.nrows(), columns.len(), combination);
        let r = factor(Mat::zeros(0, columns.len()).as_ref(), rows.as_ref());
        Self { r, n_columns: columns.len(), n_rows: self.n_rows }
    }

    /// Number of columns.
    #[must_use]
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// Number of data rows behind it.
    #[must_use]
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Column `j` of R; the rest of it is zero.
    #[must_use]
    pub fn column(&self, j: usize) -> &[f64] {
        let length = (j + 1).min(self.r.nrows());
        self.r.col(j).try_as_col_major().map_or(&[], |c| &c.as_slice()[..length])
    }

    /// The Euclidean norm of data column `j`.
    #[must_use]
    pub fn norm(&self, j: usize) -> f64 {
        norm(self.column(j))
    }

    /// The condition number of `columns`, each scaled to unit norm; columns that are zero are left out.
    #[must_use]
    pub fn condition(&self, columns: &[usize]) -> f64 {
        let columns: Vec<usize> = columns.iter().copied().filter(|&j| self.norm(j) > 0.0).collect();
        if columns.is_empty() {
            return 1.0;
        }
        let scaled =
            Mat::from_fn(self.r.nrows(), columns.len(), |i, j| self.r[(i, columns[j])] / self.norm(columns[j]));
        match scaled.singular_values() {
            Ok(values) if columns.len() <= self.r.nrows() => {
                let (first, last) = (values.first().copied(), values.last().copied());
                first.unwrap_or(1.0) / last.unwrap_or(1.0)
            }
            _ => f64::INFINITY,
        }
    }

    /// √ of the diagonal of (Θ_SᵀΘ_S)⁻¹ over the columns `support`: the standard errors of their coefficients for residuals
    /// of unit variance. Infinite where the columns depend on each other.
    #[must_use]
    pub fn spread(&self, support: &[usize]) -> Vec<f64> {
        let k = support.len();
        let norms: Vec<f64> = support.iter().map(|&j| self.norm(j)).collect();
        if k == 0 || k > self.r.nrows() || norms.contains(&0.0) {
            return vec![f64::INFINITY; k];
        }
        let scaled = Mat::from_fn(self.r.nrows(), k, |i, j| self.r[(i, support[j])] / norms[j]);
        let qr = scaled.qr();
        let r = qr.thin_R();
        // Rows of R⁻¹, by substitution from the last column back.
        let mut inverse = Mat::<f64>::zeros(k, k);
        for column in 0..k {
            for row in (0..=column).rev() {
                let known: f64 = (row + 1..=column).map(|m| r[(row, m)] * inverse[(m, column)]).sum();
                let one = if row == column { 1.0 } else { 0.0 };
                inverse[(row, column)] = (one - known) / r[(row, row)];
            }
        }
        let length = |i: usize| norm(&(0..k).map(|j| inverse[(i, j)]).collect::<Vec<_>>()) / norms[i];
        (0..k).map(length).map(|v| if v.is_finite() { v } else { f64::INFINITY }).collect()
    }

    /// The δ (|z|) with R δ = `z` over the first columns: for `z` with the covariance 1 that of δ is (ΘᵀΘ)⁻¹. `None` where the columns depend
    /// on each other.
    pub(crate) fn whitened_inverse(&self, z: &[f64]) -> Option<Vec<f64>> {
        let mut delta = z.to_vec();
        for i in (0..z.len()).rev() {
            let known: f64 = (i + 1..z.len()).map(|j| self.r[(i, j)] * delta[j]).sum();
            delta[i] = (z[i] - known) / self.r[(i, i)];
        }
        delta.iter().all(|d| d.is_finite()).then_some(delta)
    }

    /// Minimises ‖Θ_S ξ − y‖² + ridge ‖ξ‖² over the columns `support` for the column `target`; ξ (|S|).
    ///
    /// Where the columns depend on each other and there is no ridge, of all best ξ the one with the smallest norm.
    #[must_use]
    pub fn solve(&self, support: &[usize], target: usize, ridge: f64) -> Vec<f64> {
        self.solve_scaled(support, target, ridge, |_| 1.0)
    }

    /// Minimises ‖Θ_S ξ − y‖² over the columns `support` for the column `target`, ξ (|S|), each column scaled to unit length first: so
    /// that units of the columns decide nothing.
    pub(crate) fn solve_unit(&self, support: &[usize], target: usize) -> Vec<f64> {
        let length = |j: usize| self.norm(j).max(f64::MIN_POSITIVE);
        let xi = self.solve_scaled(support, target, 0.0, length);
        xi.iter().zip(support).map(|(c, &j)| c / length(j)).collect()
    }

    /// [`Self::solve`] with column j of Θ divided by `scale(j)` first; ξ belongs to the scaled columns.
    pub(crate) fn solve_scaled(
        &self,
        support: &[usize],
        target: usize,
        ridge: f64,
        scale: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        if support.is_empty() {
            return Vec::new();
        }
        let (a, b) = self.system(support, target, ridge, scale);
        least_squares(a.as_ref(), b.as_ref())
    }

    /// The same without a ridge, and with singular values up to `cutoff` times the largest taken as zero.
    pub(crate) fn solve_truncated(
        &self,
        support: &[usize],
        target: usize,
        cutoff: f64,
        scale: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        if support.is_empty() {
            return Vec::new();
        }
        let (a, b) = self.system(support, target, 0.0, scale);
        truncated(a.as_ref(), b.as_ref(), cutoff)
    }

    /// (Θ_S, y) in the triangle's coordinates, with √ridge I below.
    fn system(
        &self,
        support: &[usize],
        target: usize,
        ridge: f64,
        scale: impl Fn(usize) -> f64,
    ) -> (Mat<f64>, Mat<f64>) {
        let (n, k) = (self.r.nrows(), support.len());
        let extra = if ridge > 0.0 { k } else { 0 };
        let a = Mat::from_fn(n + extra, k, |i, j| {
            if i < n {
                self.r[(i, support[j])] / scale(support[j])
            } else if i - n == j {
                ridge.sqrt()
            } else {
                0.0
            }
        });
        let b = Mat::from_fn(n + extra, 1, |i, _| if i < n { self.r[(i, target)] } else { 0.0 });
        (a, b)
    }

    /// R⁻¹ over all columns but the last (p, p); `None` where these depend on each other.
    pub(crate) fn inverse(&self) -> Option<DMatrix<f64>> {
        let p = self.n_columns - 1;
        let r = DMatrix::from_fn(p, p, |i, j| self.column(j).get(i).copied().unwrap_or(0.0));
        r.solve_upper_triangular(&DMatrix::identity(p, p)).filter(|inverse| inverse.iter().all(|v| v.is_finite()))
    }

    /// (RᵀR)⁻¹ g over all columns but the last, `g` one number for each; `None` where these depend on each other.
    pub(crate) fn shift(&self, g: &[f64]) -> Option<Vec<f64>> {
        let inverse = self.inverse()?;
        Some((&inverse * inverse.tr_mul(&DVector::from_column_slice(g))).iter().copied().collect())
    }

    /// ‖Θ_S ξ − y‖ for coefficients `xi` of the columns `support`.
    #[must_use]
    pub fn residual_norm(&self, support: &[usize], xi: &[f64], target: usize) -> f64 {
        let mut residual = vec![0.0; self.r.nrows()];
        residual[..self.column(target).len()].copy_from_slice(self.column(target));
        for (&j, &c) in support.iter().zip(xi) {
            for (r, v) in residual.iter_mut().zip(self.column(j)) {
                *r -= c * v;
            }
        }
        norm(&residual)
    }
}

/// The factor R of `above` on top of `below`.
fn factor(above: MatRef<'_, f64>, below: MatRef<'_, f64>) -> Mat<f64> {
    let n = above.nrows();
    let stacked =
        Mat::from_fn(n + below.nrows(), above.ncols(), |i, j| if i < n { above[(i, j)] } else { below[(i - n, j)] });
    triangular(stacked.as_ref())
}

/// The factor R of `rows`.
fn triangular(rows: MatRef<'_, f64>) -> Mat<f64> {
    let qr = rows.qr();
    let r = qr.thin_R();
    // A positive diagonal makes R unique.
    let sign = |i: usize| if r[(i, i)] < 0.0 { -1.0 } else { 1.0 };
    Mat::from_fn(r.nrows(), r.ncols(), |i, j| if i <= j { sign(i) * r[(i, j)] } else { 0.0 })
}

/// Whether every number is finite.
pub(crate) fn all_finite(rows: ArrayView2<'_, f64>) -> bool {
    match rows.as_slice_memory_order() {
        // All of them are looked at, side by side.
        Some(values) => values.iter().fold(true, |all, v| all & v.is_finite()),
        None => rows.iter().all(|v| v.is_finite()),
    }
}

pub(crate) fn norm(v: &[f64]) -> f64 {
    // Scaled, so that the squares of tiny residuals do not vanish.
    let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 {
        return 0.0;
    }
    largest * v.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array2, array, s};

    fn rows() -> Array2<f64> {
        Array2::from_shape_fn((40, 4), |(i, j)| ((i * (j + 2)) as f64 * 0.37).sin() + j as f64)
    }

    #[test]
    fn inner_products_are_those_of_the_data() {
        let rows = rows();
        let mut triangle = Triangle::new(4);
        triangle.push(rows.view()).expect("finite rows");
        let gram = rows.t().dot(&rows);
        for a in 0..4 {
            for b in 0..4 {
                let (x, y) = (triangle.column(a), triangle.column(b));
                let dot: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
                assert!((dot - gram[[a, b]]).abs() < 1e-10, "{a} {b}");
            }
        }
        assert_eq!(triangle.n_rows(), 40);
    }

    #[test]
    fn columns_after_the_first_are_chosen_without_loss() {
        for n_rows in [2, 40] {
            let rows = rows();
            let mut triangle = Triangle::new(4);
            triangle.push(rows.slice(s![..n_rows, ..])).expect("finite rows");
            let chosen = triangle.with_others(1, &[3, 2]);
            let combined = triangle.combined(&[0, 3, 2].map(|c| vec![(c, 1.0)]));
            assert_eq!((chosen.n_columns(), chosen.n_rows()), (3, n_rows));
            for (a, b) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                let product = |t: &Triangle| t.column(a).iter().zip(t.column(b)).map(|(x, y)| x * y).sum::<f64>();
                assert!((product(&chosen) - product(&combined)).abs() < 1e-10, "{a} {b} of {n_rows}");
            }
        }
    }

    #[test]
    fn pieces_merge_to_the_whole() {
        let rows = rows();
        let mut whole = Triangle::new(4);
        whole.push(rows.view()).expect("finite rows");
        let (mut first, mut second) = (Triangle::new(4), Triangle::new(4));
        first.push(rows.slice(s![..3, ..])).expect("finite rows");
        second.push(rows.slice(s![3.., ..])).expect("finite rows");
        second.merge(&first).expect("same columns");
        for j in 0..4 {
            for (a, b) in whole.column(j).iter().zip(second.column(j)) {
                assert!((a - b).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn wrong_rows_are_refused() {
        let mut triangle = Triangle::new(2);
        let width = triangle.push(array![[1.0]].view());
        assert_eq!(width, Err(TriangleError::Width { expected: 2, got: 1 }));
        let nan = triangle.push(array![[1.0, 2.0], [3.0, f64::NAN]].view()).expect_err("NaN");
        assert_eq!(nan.to_string(), "column 1 of row 1 is NaN, which is not finite");
        assert_eq!(triangle.n_rows(), 0);
    }

    #[test]
    fn dependent_columns_get_the_smallest_solution() {
        let mut triangle = Triangle::new(3);
        triangle.push(array![[1.0, 1.0, 2.0], [2.0, 2.0, 4.0], [0.0, 0.0, 0.0]].view()).expect("finite rows");
        let xi = triangle.solve(&[0, 1], 2, 0.0);
        assert!((xi[0] - 1.0).abs() < 1e-12 && (xi[1] - 1.0).abs() < 1e-12, "{xi:?}");
        assert_eq!(triangle.solve(&[], 2, 0.0), Vec::<f64>::new());
    }
}
