//! A node of the search: what is left of the regression after some columns are taken out.

use super::errors::Errors;
use super::scan::Pairs;
use crate::solve::problem::{DEPENDENT, Left, Problem, dot, square, take_out_all};

/// Inner products of the columns that may still be chosen, with those already chosen taken out.
///
/// A Gram matrix squares the condition of its columns, so every product carries a bound on its rounding error; where
/// that grows too large the products are computed anew from the columns.
#[derive(Debug, Clone)]
pub(super) struct Node {
    /// The problem's numbers of the columns that may still be chosen (f).
    pub(super) free: Vec<usize>,
    /// Their products with each other (f, f).
    pub(super) gram: Vec<f64>,
    /// Their products with the residual (f).
    pub(super) overlap: Vec<f64>,
    /// Squared length of the residual, without what no column reaches.
    pub(super) rss: f64,
    /// Bounds on the rounding errors.
    pub(super) error: Errors,
    /// No eigenvalue of `gram` is below this.
    pub(super) least: f64,
}

/// Rounding error beyond which products are computed anew from the columns.
const STALE: f64 = 1e-10;

/// Part of the squared residual that may be rounding, if the columns could tell more.
const UNSURE: f64 = 1e-3;

/// Rounding error of a product of two vectors of unit length.
const ROUNDING: f64 = 2e-15;

/// Rounding error of a squared residual that is computed from the columns.
fn at_best(drift: f64, rss: f64) -> f64 {
    4.0 * drift * (drift + rss.sqrt())
}

impl Node {
    /// The products of `free` with the columns `chosen` taken out, each scaled to unit length again. Columns that
    /// depend on those chosen are left out; without a result if the chosen ones depend on each other.
    pub(super) fn fresh(problem: &Problem, chosen: &[usize], free: &[usize], least: f64) -> Option<Self> {
        let Left { basis, residual } = problem.left(chosen)?;
        let (mut kept, mut columns, mut shortest) = (Vec::new(), Vec::new(), 1.0_f64);
        for &j in free {
            let mut a = problem.column(j).to_vec();
            take_out_all(&mut a, &basis);
            let left = square(&a);
            if left < DEPENDENT {
                continue;
            }
            let length = left.sqrt();
            a.iter_mut().for_each(|v| *v /= length);
            shortest = shortest.min(length);
            kept.push(j);
            columns.push(a);
        }
        let f = kept.len();
        let mut gram = vec![0.0; f * f];
        for i in 0..f {
            for j in i..f {
                let product = dot(&columns[i], &columns[j]);
                gram[i * f + j] = product;
                gram[j * f + i] = product;
            }
        }
        let overlap = columns.iter().map(|a| dot(a, &residual)).collect();
        let (rss, gram_error) = (square(&residual), ROUNDING / shortest);
        let drift = ROUNDING * square(problem.target()).sqrt();
        let error = Errors {
            gram: gram_error,
            overlap: 2.0 * drift + gram_error * rss.sqrt(),
            rss: at_best(drift, rss),
            drift,
        };
        // Scaling the columns up again lowers no eigenvalue.
        Some(Self { free: kept, gram, overlap, rss, error, least })
    }

    /// Operations that [`Self::fresh`] costs: `free` columns freed of `chosen` ones, and their products.
    pub(super) fn cost_of_fresh(problem: &Problem, chosen: usize, free: usize) -> u64 {
        ((free + chosen) * chosen * problem.dim() + free * free * problem.dim() / 8) as u64
    }

    pub(super) fn len(&self) -> usize {
        self.free.len()
    }

    pub(super) fn square(&self, i: usize) -> f64 {
        self.gram[i * self.len() + i]
    }

    /// Squared length of column `i`, not above the true one by more than rounding allows, and positive.
    pub(super) fn square_at_least(&self, i: usize) -> f64 {
        (self.square(i) - self.error.gram).max(f64::MIN_POSITIVE)
    }

    /// What column `i` alone would take from the squared residual; an upper bound of it.
    pub(super) fn gain(&self, i: usize) -> f64 {
        let overlap = self.overlap[i].abs() + self.error.overlap;
        overlap * overlap / self.square_at_least(i)
    }

    /// What r columns have to take from the squared residual at least, to reach `cutoff`.
    pub(super) fn wanted(&self, cutoff: f64) -> f64 {
        self.rss - self.error.rss - cutoff
    }

    /// The bounds on errors after column `i` is taken out.
    fn error_after(&self, i: usize) -> Errors {
        let inverse = 1.0 / self.square_at_least(i);
        let along = self.overlap[i].abs() * inverse.sqrt();
        let gram = self.error.gram * (1.0 + inverse);
        Errors {
            gram,
            overlap: self.error.overlap * (1.0 + inverse.sqrt()) + gram * self.rss.sqrt(),
            rss: self.error.rss
                + 2.0 * along * self.error.overlap * inverse.sqrt()
                + along * along * self.error.gram * inverse,
            ..self.error
        }
    }

    /// Whether taking out column `i` by its products would leave too much rounding.
    pub(super) fn is_stale_after(&self, i: usize) -> bool {
        let error = self.error_after(i);
        let rss = (self.rss - self.overlap[i] * self.overlap[i] / self.square_at_least(i)).max(0.0);
        error.gram > STALE || (error.rss > UNSURE * rss && error.rss > 10.0 * at_best(error.drift, rss))
    }

    /// The columns `keep` only.
    pub(super) fn restricted(&self, keep: &[usize]) -> Self {
        let f = self.len();
        Self {
            free: keep.iter().map(|&i| self.free[i]).collect(),
            gram: keep.iter().flat_map(|&i| keep.iter().map(move |&j| self.gram[i * f + j])).collect(),
            overlap: keep.iter().map(|&i| self.overlap[i]).collect(),
            ..*self
        }
    }

    /// The columns `keep` after column `i` is chosen too; `chosen` are all of them. Without a result if they depend on
    /// each other.
    pub(super) fn including(&self, problem: &Problem, i: usize, keep: &[usize], chosen: &[usize]) -> Option<Self> {
        if self.is_stale_after(i) {
            let free: Vec<usize> = keep.iter().map(|&j| self.free[j]).collect();
            return Self::fresh(problem, chosen, &free, self.least);
        }
        let f = self.len();
        let pivot = self.square(i).sqrt();
        let along = self.overlap[i] / pivot;
        let shared: Vec<f64> = self.gram[i * f..(i + 1) * f].iter().map(|g| g / pivot).collect();
        let mut gram = Vec::with_capacity(keep.len() * keep.len());
        for &k in keep {
            let (row, of_k) = (&self.gram[k * f..(k + 1) * f], shared[k]);
            gram.extend(keep.iter().map(|&l| row[l] - of_k * shared[l]));
        }
        Some(Self {
            free: keep.iter().map(|&j| self.free[j]).collect(),
            gram,
            overlap: keep.iter().map(|&j| self.overlap[j] - shared[j] * along).collect(),
            rss: (self.rss - along * along).max(0.0),
            error: self.error_after(i),
            least: self.least,
        })
    }

    /// The pairs of columns as they are.
    pub(super) fn pairs(&self, pairs: &mut Pairs) {
        let f = self.len();
        pairs.shared.clear();
        pairs.shared.resize(f, 0.0);
        pairs.overlap.clone_from(&self.overlap);
        pairs.square.clear();
        pairs.square.extend((0..f).map(|i| self.square(i)));
        (pairs.rss, pairs.error) = (self.rss, self.error);
    }

    /// The pairs of the columns after column `i`, with that one chosen too.
    pub(super) fn pairs_after(&self, i: usize, pairs: &mut Pairs) {
        let f = self.len();
        let scale = 1.0 / self.square(i).sqrt();
        let along = self.overlap[i] * scale;
        for of_column in [&mut pairs.shared, &mut pairs.overlap, &mut pairs.square] {
            of_column.resize(f, 0.0);
        }
        for j in i + 1..f {
            let shared = self.gram[i * f + j] * scale;
            pairs.shared[j] = shared;
            pairs.overlap[j] = self.overlap[j] - shared * along;
            pairs.square[j] = self.square(j) - shared * shared;
        }
        (pairs.rss, pairs.error) = ((self.rss - along * along).max(0.0), self.error_after(i));
    }
}
