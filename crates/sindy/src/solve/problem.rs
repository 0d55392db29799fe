//! One regression as the searches see it: columns of unit length and a target.

use std::cell::Cell;

use sindyna_core::vectorized;

use super::candidates::binomial;

/// Columns of one regression, each of unit length, and their target.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    /// Length of a column.
    dim: usize,
    /// (columns, dim), one column after the other.
    columns: Vec<f64>,
    target: Vec<f64>,
    /// Squared length of the part of the target that no column reaches.
    unreachable: f64,
    /// Operations of searches without a tree so far.
    work: Cell<u64>,
}

/// An orthonormal basis of columns, and what they leave of the target.
pub(super) struct Left {
    pub(super) basis: Vec<Vec<f64>>,
    pub(super) residual: Vec<f64>,
}

/// Multiplications, with an addition each, of long columns that take as long as one operation of the tree; and operations for a product of two columns
/// besides its multiplications, for a list of numbers, and for a number that is kept in order.
const LANES_AT_ONCE: usize = 3;
const PRODUCT: usize = 6;
const LIST: usize = 25;
const IN_ORDER: usize = 4;

/// Squared distance from the span of the others at which a column of unit length counts as dependent.
pub(super) const DEPENDENT: f64 = 1e-18;

impl Problem {
    /// A problem of `columns` and a `target`, all of length `dim`; `unreachable` is the squared length of what was cut
    /// off the target. The columns must have unit length.
    pub(crate) fn new(dim: usize, columns: Vec<f64>, target: Vec<f64>, unreachable: f64) -> Self {
        Self { dim, columns, target, unreachable, work: Cell::new(0) }
    }

    /// Operations so far, of about a nanosecond each, as those of the tree.
    pub(super) fn work(&self) -> u64 {
        self.work.get()
    }

    /// Counts `products` of two columns, `lists` of numbers that were made, and numbers that were put in order.
    pub(super) fn worked(&self, products: usize, lists: usize, ordered: usize) {
        let operations = products * (self.dim / LANES_AT_ONCE + PRODUCT) + lists * LIST + ordered * IN_ORDER;
        self.work.set(self.work.get() + operations as u64);
    }

    pub(crate) fn n_columns(&self) -> usize {
        self.columns.len().checked_div(self.dim).unwrap_or(0)
    }

    /// Length of a column: no more of them than this can be independent.
    pub(crate) fn dim(&self) -> usize {
        self.dim
    }

    pub(crate) fn column(&self, j: usize) -> &[f64] {
        &self.columns[j * self.dim..(j + 1) * self.dim]
    }

    /// The part of the target that columns may reach.
    pub(crate) fn target(&self) -> &[f64] {
        &self.target
    }

    pub(crate) fn unreachable(&self) -> f64 {
        self.unreachable
    }

    /// Number of subsets of `size`.
    pub(crate) fn n_subsets(&self, size: usize) -> f64 {
        binomial(self.n_columns(), size)
    }

    /// Squared length of the target.
    pub(crate) fn total(&self) -> f64 {
        square(&self.target) + self.unreachable
    }

    /// Orthonormal columns with the span of `subset`; none if they depend on each other.
    pub(crate) fn basis(&self, subset: &[usize]) -> Option<Vec<Vec<f64>>> {
        self.worked(2 * subset.len() * subset.len(), 2 * subset.len() + 2, 0);
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(subset.len());
        for &j in subset {
            let mut a = self.column(j).to_vec();
            take_out_all(&mut a, &basis);
            let left = square(&a);
            if left < DEPENDENT {
                return None;
            }
            let length = left.sqrt();
            a.iter_mut().for_each(|v| *v /= length);
            basis.push(a);
        }
        Some(basis)
    }

    /// What `subset` leaves of the target; none if its columns depend on each other.
    pub(super) fn left(&self, subset: &[usize]) -> Option<Left> {
        let basis = self.basis(subset)?;
        let mut residual = self.target.clone();
        basis.iter().for_each(|q| subtract(&mut residual, q));
        Some(Left { basis, residual })
    }

    /// The squared residual of `subset` by orthogonal columns, without cancellation; none if they depend on each other.
    pub(crate) fn rss(&self, subset: &[usize]) -> Option<f64> {
        Some(square(&self.left(subset)?.residual) + self.unreachable)
    }

    /// The squared residual of the span of `subset`, whose columns may depend on each other.
    pub(crate) fn span_rss(&self, subset: &[usize]) -> f64 {
        self.remainders(&[], subset)[0] + self.unreachable
    }

    /// For each i the squared residual of all columns in `chosen` and `order[i..]`, without the unreachable part: no
    /// subset of them falls below it.
    pub(crate) fn remainders(&self, chosen: &[usize], order: &[usize]) -> Vec<f64> {
        let mut residual = self.target.clone();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut left = vec![0.0; order.len() + 1];
        let columns =
            chosen.iter().map(|&j| (j, order.len())).chain(order.iter().enumerate().rev().map(|(i, &j)| (j, i)));
        left[order.len()] = square(&residual);
        for (j, at) in columns {
            let mut a = self.column(j).to_vec();
            take_out_all(&mut a, &basis);
            let length = square(&a).sqrt();
            if length * length >= DEPENDENT {
                a.iter_mut().for_each(|v| *v /= length);
                subtract(&mut residual, &a);
                basis.push(a);
            }
            left[at] = square(&residual);
        }
        left
    }
}

/// a·b, in eight lanes.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    vectorized(
        #[inline(always)]
        || in_lanes(a, b),
    )
}

pub(super) fn square(a: &[f64]) -> f64 {
    dot(a, a)
}

/// r ← r − (r·q) q.
pub(super) fn subtract(r: &mut [f64], q: &[f64]) {
    vectorized(
        #[inline(always)]
        || without(r, q),
    );
}

/// Part of a squared length, above which what is left of it has no rounding to speak of.
const CLEAN: f64 = 0.5;

/// Takes every direction of an orthonormal `basis` out of `a`; twice where little is left, so that rounding leaves nothing behind.
///
/// # References
/// Daniel, Gragg, Kaufman, Stewart (1976), Mathematics of Computation 30(136).
pub(super) fn take_out_all(a: &mut [f64], basis: &[Vec<f64>]) {
    vectorized(
        #[inline(always)]
        || {
            let whole = in_lanes(a, a);
            // Closures that adaptors of iterators call may be compiled apart, without these instructions.
            for q in basis {
                without(a, q);
            }
            if in_lanes(a, a) < CLEAN * whole {
                for q in basis {
                    without(a, q);
                }
            }
        },
    );
}

/// a·b, to be compiled into a loop that is [`vectorized`].
#[inline(always)]
fn in_lanes(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (a_chunks, a_rest) = a.as_chunks::<LANES>();
    let (b_chunks, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// r − (r·q) q in the place of r, likewise.
#[inline(always)]
fn without(r: &mut [f64], q: &[f64]) {
    let along = in_lanes(r, q);
    for (r, q) in r.iter_mut().zip(q) {
        *r -= along * q;
    }
}
