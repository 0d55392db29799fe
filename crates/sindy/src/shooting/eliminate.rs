//! Linear least squares over all states of a trajectory and shared parameters, one sample at a time.

use ndarray::Array2;
use sindyna_core::vectorized;

/// A square-root information filter over the states of one trajectory: minimises
/// Σ ‖(y_t − δx_t)/σ‖² + Σ ‖(δx_{t+1} − A_t δx_t − B_t δξ − d_t)/q‖² over all δx_t, with the parameters δξ left open.
///
/// # References
/// Bierman (1977), Factorization Methods for Discrete Sequential Estimation, chapter VI.
pub(super) struct Elimination {
    n: usize,
    p: usize,
    /// Per step, rows over (δx_t, δx_{t+1}, δξ | right-hand side) that are left once δx_t is eliminated from everything before it (n, 2 n +
    /// p + 1), upper triangular in their first n columns; what is needed to go back.
    heads: Vec<Vec<f64>>,
    /// Rows over (δx_t, δξ | right-hand side) that the past leaves (n, n + p + 1).
    prior: Vec<f64>,
    stacked: Vec<f64>,
    /// Rows over (δξ | right-hand side) alone, one after the other.
    left: Vec<f64>,
    /// Whether the states are asked for in the end.
    with_states: bool,
    /// ln √det of the information about all states, the parameters as they are: of those eliminated so far.
    volume: f64,
}

impl Elimination {
    pub(super) fn new(n: usize, p: usize, with_states: bool) -> Self {
        let prior = vec![0.0; n * (n + p + 1)];
        let stacked = vec![0.0; 3 * n * (2 * n + p + 1)];
        Self { n, p, heads: Vec::new(), prior, stacked, left: Vec::new(), with_states, volume: 0.0 }
    }

    /// What a sample adds to what is known before it, with the parameters as they are: y − δx as predicted, one per state, each in
    /// units of its standard deviation. `None` where the samples before do not determine the state.
    ///
    /// # References
    /// Bierman (1977), chapter VI: the prior R δx = z has the estimate R⁻¹ z and the covariance R⁻¹ R⁻ᵀ.
    pub(super) fn innovations(&self, y: &[f64], sigma: &[f64]) -> Option<Vec<f64>> {
        let (n, width) = (self.n, self.n + self.p + 1);
        let predicted = back(&self.prior, width, n, |row| row[width - 1])?;
        let mut innovations = Vec::with_capacity(n);
        for i in 0..n {
            // Row i of R⁻¹, by Rᵀ w = eᵢ.
            let mut w = vec![0.0; n];
            for j in 0..n {
                let known: f64 = (0..j).map(|k| self.prior[k * width + j] * w[k]).sum();
                w[j] = (f64::from(u8::from(i == j)) - known) / self.prior[j * width + j];
            }
            let variance = sigma[i] * sigma[i] + w.iter().map(|v| v * v).sum::<f64>();
            innovations.push((y[i] - predicted[i]) / variance.sqrt());
        }
        innovations.iter().all(|v| v.is_finite()).then_some(innovations)
    }

    /// One sample and the step after it: misses `y` (n) of the sample, `d` (n) of the step, its Jacobian `s` (n, n + p).
    pub(super) fn step(&mut self, y: &[f64], sigma: &[f64], s: &[f64], d: &[f64], q: &[f64]) {
        let (n, p) = (self.n, self.p);
        let width = 2 * n + p + 1;
        let before = n + p + 1;
        self.stacked.fill(0.0);
        for i in 0..n {
            let known = &self.prior[i * before..(i + 1) * before];
            let row = &mut self.stacked[i * width..(i + 1) * width];
            row[..n].copy_from_slice(&known[..n]);
            row[2 * n..].copy_from_slice(&known[n..]);
            let row = &mut self.stacked[(n + i) * width..(n + i + 1) * width];
            row[i] = 1.0 / sigma[i];
            row[width - 1] = y[i] / sigma[i];
            let row = &mut self.stacked[(2 * n + i) * width..(2 * n + i + 1) * width];
            let slopes = &s[i * (n + p)..(i + 1) * (n + p)];
            row[..n].iter_mut().zip(slopes).for_each(|(r, s)| *r = -s / q[i]);
            row[n + i] = 1.0 / q[i];
            row[2 * n..].iter_mut().zip(&slopes[n..]).for_each(|(r, s)| *r = -s / q[i]);
            row[width - 1] = d[i] / q[i];
        }
        reflect(&mut self.stacked, width, 2 * n);
        self.volume += diagonal(&self.stacked, width, n);
        if self.with_states {
            self.heads.push(self.stacked[..n * width].to_vec());
        }
        for i in 0..n {
            let row = &self.stacked[(n + i) * width + n..(n + i + 1) * width];
            self.prior[i * before..(i + 1) * before].copy_from_slice(row);
        }
        for row in self.stacked.chunks_exact(width).skip(2 * n) {
            self.left.extend_from_slice(&row[2 * n..]);
        }
    }

    /// The last sample.
    pub(super) fn finish(&mut self, y: &[f64], sigma: &[f64]) {
        let (n, p) = (self.n, self.p);
        let width = n + p + 1;
        let mut stacked = self.prior.clone();
        stacked.resize(2 * n * width, 0.0);
        for i in 0..n {
            stacked[(n + i) * width + i] = 1.0 / sigma[i];
            stacked[(n + i + 1) * width - 1] = y[i] / sigma[i];
        }
        reflect(&mut stacked, width, n);
        self.volume += diagonal(&stacked, width, n);
        self.prior.copy_from_slice(&stacked[..n * width]);
        for row in stacked.chunks_exact(width).skip(n) {
            self.left.extend_from_slice(&row[n..]);
        }
    }

    /// ln √det of the information about the states of all samples, the parameters as they are.
    pub(super) fn volume(&self) -> f64 {
        self.volume
    }

    /// What became known of δξ since this was asked last: rows (·, p + 1), whose last column is the right-hand side.
    pub(super) fn rows(&mut self) -> Array2<f64> {
        let width = self.p + 1;
        let left = std::mem::take(&mut self.left);
        Array2::from_shape_vec((left.len() / width, width), left).expect("rows are pushed whole")
    }

    /// δx of every sample (T + 1, n) for given δξ; `None` where the samples do not determine it.
    pub(super) fn states(&self, delta: &[f64]) -> Option<Array2<f64>> {
        let (n, p, steps) = (self.n, self.p, self.heads.len());
        let mut states = Array2::zeros((steps + 1, n));
        let before = n + p + 1;
        let last = back(&self.prior, before, n, |row| {
            row[n + p] - row[n..].iter().zip(delta).map(|(r, d)| r * d).sum::<f64>()
        })?;
        states.row_mut(steps).iter_mut().zip(last).for_each(|(slot, v)| *slot = v);
        for t in (0..steps).rev() {
            let later = states.row(t + 1).to_vec();
            let found = back(&self.heads[t], before + n, n, |row| {
                let known: f64 = row[n..].iter().zip(later.iter().chain(delta)).map(|(r, d)| r * d).sum();
                row[2 * n + p] - known
            })?;
            states.row_mut(t).iter_mut().zip(found).for_each(|(slot, v)| *slot = v);
        }
        Some(states)
    }
}

/// Σ ln |r_ii| of the first `n` rows, each `width` long.
fn diagonal(rows: &[f64], width: usize, n: usize) -> f64 {
    (0..n).map(|i| rows[i * width + i].abs().ln()).sum()
}

/// Makes the first `columns` columns of `rows` (each `width` long) upper triangular, by Householder's reflections.
///
/// By hand: a dozen rows for every sample are too few for the blocked factorisations of the crates, which took most of the time
/// of a fit.
fn reflect(rows: &mut [f64], width: usize, columns: usize) {
    vectorized(
        #[inline(always)]
        || reflected(rows, width, columns),
    );
}

#[inline(always)]
fn reflected(rows: &mut [f64], width: usize, columns: usize) {
    let count = rows.len() / width;
    let mut sums = vec![0.0; width];
    for c in 0..columns.min(count) {
        let norm = rows[c * width..].chunks_exact(width).map(|r| r[c] * r[c]).sum::<f64>().sqrt();
        if norm == 0.0 {
            continue;
        }
        let head = rows[c * width + c];
        let diagonal = if head > 0.0 { -norm } else { norm };
        // v = (head − diagonal, what is below it); 2/(v·v) = 1/(−diagonal v₀).
        let first = head - diagonal;
        rows[c * width + c] = first;
        sums[c + 1..].fill(0.0);
        for row in rows[c * width..].chunks_exact(width) {
            let v = row[c];
            if v != 0.0 {
                sums[c + 1..].iter_mut().zip(&row[c + 1..]).for_each(|(sum, r)| *sum += v * r);
            }
        }
        let scale = -1.0 / (diagonal * first);
        for row in rows[c * width..].chunks_exact_mut(width) {
            let v = row[c] * scale;
            if v != 0.0 {
                row[c + 1..].iter_mut().zip(&sums[c + 1..]).for_each(|(r, sum)| *r -= v * sum);
            }
            row[c] = 0.0;
        }
        rows[c * width + c] = diagonal;
    }
}

/// Solves the upper triangular system in the first n columns of `rows`, each `width` long.
fn back(rows: &[f64], width: usize, n: usize, right: impl Fn(&[f64]) -> f64) -> Option<Vec<f64>> {
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let row = &rows[i * width..(i + 1) * width];
        let known: f64 = (i + 1..n).map(|j| row[j] * x[j]).sum();
        x[i] = (right(row) - known) / row[i];
        if !x[i].is_finite() {
            return None;
        }
    }
    Some(x)
}
