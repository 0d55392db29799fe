//! Linear least squares over all states of a trajectory and shared parameters, one sample at a time.

use faer::Mat;
use ndarray::Array2;

/// Rows over (δx_t, δx_{t+1}, δξ) that are left once δx_t is eliminated from everything before it; what is needed to go back.
struct Head {
    /// (n, 2 n + p + 1), upper triangular in its first n columns.
    rows: Mat<f64>,
}

/// A square-root information filter over the states of one trajectory: minimises
/// Σ ‖(y_t − δx_t)/σ‖² + Σ ‖(δx_{t+1} − A_t δx_t − B_t δξ − d_t)/q‖² over all δx_t, with the parameters δξ left open.
///
/// # References
/// Bierman (1977), Factorization Methods for Discrete Sequential Estimation, chapter VI.
pub(super) struct Elimination {
    n: usize,
    p: usize,
    heads: Vec<Head>,
    /// Rows over (δx_t, δξ | right-hand side) that the past leaves (n, n + p + 1).
    prior: Mat<f64>,
    /// Rows over (δξ | right-hand side) alone, one after the other.
    left: Vec<f64>,
}

impl Elimination {
    pub(super) fn new(n: usize, p: usize) -> Self {
        Self { n, p, heads: Vec::new(), prior: Mat::zeros(n, n + p + 1), left: Vec::new() }
    }

    /// One sample and the step after it: misses `y` (n) of the sample, `d` (n) of the step, its Jacobian `s` (n, n + p).
    pub(super) fn step(&mut self, y: &[f64], sigma: &[f64], s: &[f64], d: &[f64], q: &[f64]) {
        let (n, p) = (self.n, self.p);
        let width = 2 * n + p + 1;
        let prior = &self.prior;
        let stacked = Mat::from_fn(3 * n, width, |i, j| {
            let (block, i) = (i / n, i % n);
            match block {
                0 if j < n => prior[(i, j)],
                0 if j < 2 * n => 0.0,
                0 => prior[(i, j - n)],
                1 if j == i => 1.0 / sigma[i],
                1 if j == width - 1 => y[i] / sigma[i],
                1 => 0.0,
                _ if j < n => -s[i * (n + p) + j] / q[i],
                _ if j == n + i => 1.0 / q[i],
                _ if j < 2 * n => 0.0,
                _ if j == width - 1 => d[i] / q[i],
                _ => -s[i * (n + p) + j - n] / q[i],
            }
        });
        let r = triangular(stacked);
        self.heads.push(Head { rows: Mat::from_fn(n, width, |i, j| r[(i, j)]) });
        self.prior = Mat::from_fn(n, n + p + 1, |i, j| r[(n + i, n + j)]);
        for i in 2 * n..r.nrows() {
            self.left.extend((2 * n..width).map(|j| r[(i, j)]));
        }
    }

    /// The last sample.
    pub(super) fn finish(&mut self, y: &[f64], sigma: &[f64]) {
        let (n, p) = (self.n, self.p);
        let width = n + p + 1;
        let prior = &self.prior;
        let stacked = Mat::from_fn(2 * n, width, |i, j| match i.checked_sub(n) {
            None => prior[(i, j)],
            Some(i) if i == j => 1.0 / sigma[i],
            Some(i) if j == width - 1 => y[i] / sigma[i],
            Some(_) => 0.0,
        });
        let r = triangular(stacked);
        self.prior = Mat::from_fn(n, width, |i, j| r[(i, j)]);
        for i in n..r.nrows() {
            self.left.extend((n..width).map(|j| r[(i, j)]));
        }
    }

    /// What is known of δξ: rows (·, p + 1), whose last column is the right-hand side.
    pub(super) fn rows(&self) -> Array2<f64> {
        let width = self.p + 1;
        Array2::from_shape_vec((self.left.len() / width, width), self.left.clone()).expect("rows are pushed whole")
    }

    /// δx of every sample (T + 1, n) for given δξ; `None` where the samples do not determine it.
    pub(super) fn states(&self, delta: &[f64]) -> Option<Array2<f64>> {
        let (n, p, steps) = (self.n, self.p, self.heads.len());
        let mut states = Array2::zeros((steps + 1, n));
        let last = back(&self.prior, n, |i| {
            self.prior[(i, n + p)] - (0..p).map(|j| self.prior[(i, n + j)] * delta[j]).sum::<f64>()
        })?;
        states.row_mut(steps).iter_mut().zip(last).for_each(|(slot, v)| *slot = v);
        for t in (0..steps).rev() {
            let rows = &self.heads[t].rows;
            let later = states.row(t + 1).to_vec();
            let found = back(rows, n, |i| {
                let known: f64 = (0..n).map(|j| rows[(i, n + j)] * later[j]).sum();
                rows[(i, 2 * n + p)] - known - (0..p).map(|j| rows[(i, 2 * n + j)] * delta[j]).sum::<f64>()
            })?;
            states.row_mut(t).iter_mut().zip(found).for_each(|(slot, v)| *slot = v);
        }
        Some(states)
    }
}

/// R of the QR factorisation.
fn triangular(a: Mat<f64>) -> Mat<f64> {
    let r = a.qr().thin_R().to_owned();
    Mat::from_fn(r.nrows(), r.ncols(), |i, j| if i <= j { r[(i, j)] } else { 0.0 })
}

/// Solves the upper triangular system in the first n columns of `rows`.
fn back(rows: &Mat<f64>, n: usize, right: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[(i, j)] * x[j]).sum();
        x[i] = (right(i) - known) / rows[(i, i)];
        if !x[i].is_finite() {
            return None;
        }
    }
    Some(x)
}
