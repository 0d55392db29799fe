//! Good subsets without a proof: forward steps and exchanges.

use super::candidates::{Candidate, Kept};
use super::problem::{DEPENDENT, Problem, dot, square, subtract, take_out_all};

/// Rounds of exchanges; each one improves the residual, so this is never reached in practice.
const ROUNDS: usize = 40;

/// Offers good subsets of one more column than those in `from` have: a forward step from each, then exchanges until none helps.
pub(crate) fn grow(problem: &Problem, from: &[Candidate], kept: &mut Kept) {
    for start in from {
        if let Some(grown) = complete(problem, &start.subset, kept) {
            exchange(problem, grown, kept);
        }
    }
}

/// Offers good subsets of one column less than those in `from` have: the best that is left of each, then exchanges until none helps.
///
/// # References
/// Pudil, Novovičová, Kittler (1994), Floating search methods in feature selection, Pattern Recognition Letters 15(11).
pub(crate) fn shrink(problem: &Problem, from: &[Candidate], kept: &mut Kept) {
    for start in from {
        let mut best: Option<Candidate> = None;
        for out in 0..start.subset.len() {
            let mut rest = start.subset.clone();
            rest.remove(out);
            let Some(rss) = problem.rss(&rest) else { continue };
            kept.offer(rss, &rest);
            if best.as_ref().is_none_or(|b| rss < b.rss) {
                best = Some(Candidate { rss, subset: rest });
            }
        }
        if let Some(shrunk) = best {
            exchange(problem, shrunk, kept);
        }
    }
}

/// Exchanges one column of `current` for another as long as that helps.
fn exchange(problem: &Problem, mut current: Candidate, kept: &mut Kept) {
    for _ in 0..ROUNDS {
        let mut better: Option<Candidate> = None;
        for out in 0..current.subset.len() {
            let mut rest = current.subset.clone();
            rest.remove(out);
            let found = complete(problem, &rest, kept);
            let bar = better.as_ref().map_or(current.rss * (1.0 - 1e-9), |b| b.rss);
            better = found.filter(|c| c.rss < bar).or(better);
        }
        match better {
            Some(next) => current = next,
            None => break,
        }
    }
}

/// Offers `subset` with each other column added; the best of these.
fn complete(problem: &Problem, subset: &[usize], kept: &mut Kept) -> Option<Candidate> {
    let basis = problem.basis(subset)?;
    let mut residual = problem.target().to_vec();
    basis.iter().for_each(|q| subtract(&mut residual, q));
    let quick = Quick::new(problem, subset, &residual);
    let mut scratch = vec![0.0; subset.len()];
    let mut best: Option<Candidate> = None;
    // The most promising first: what follows is then mostly passed over.
    let mut order: Vec<(f64, usize)> = (0..problem.n_columns())
        .filter(|j| !subset.contains(j))
        .map(|j| (quick.bound(j, &mut scratch) + problem.unreachable(), j))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (bound, j) in order {
        let of = |c: &Candidate| c.rss;
        if bound > best.as_ref().map_or(f64::INFINITY, of).max(kept.cutoff()) {
            break;
        }
        let mut a = problem.column(j).to_vec();
        take_out_all(&mut a, &basis);
        if square(&a) < DEPENDENT {
            continue;
        }
        let along = dot(&residual, &a) / square(&a);
        let left = residual.iter().zip(&a).map(|(r, a)| (r - along * a) * (r - along * a)).sum::<f64>();
        let rss = left + problem.unreachable();
        let mut with = subset.to_vec();
        with.insert(with.partition_point(|&i| i < j), j);
        if rss <= kept.cutoff() && !kept.holds(&with) {
            // The same number, to the last bit, by whatever way a subset is met.
            kept.offer(problem.rss(&with).unwrap_or(f64::NAN), &with);
        }
        if best.as_ref().is_none_or(|b| rss < b.rss) {
            best = Some(Candidate { rss, subset: with });
        }
    }
    best
}

/// Bounds on residuals, with lengths by inner products of columns.
struct Quick<'a> {
    problem: &'a Problem,
    subset: &'a [usize],
    /// What the subset leaves of the target, and its squared length.
    residual: &'a [f64],
    rss: f64,
    /// L of L Lᵀ = Gram of the subset, row by row; empty if it cannot be trusted.
    factor: Vec<f64>,
}

/// Squared lengths below this are not trusted to a difference of inner products.
const TRUSTED: f64 = 1e-6;

impl<'a> Quick<'a> {
    fn new(problem: &'a Problem, subset: &'a [usize], residual: &'a [f64]) -> Self {
        let k = subset.len();
        let mut factor = vec![0.0; k * k];
        for i in 0..k {
            for j in 0..=i {
                let known: f64 = (0..j).map(|m| factor[i * k + m] * factor[j * k + m]).sum();
                let left = problem.product(subset[i], subset[j]) - known;
                if i == j && left < TRUSTED {
                    return Self { problem, subset, residual, rss: square(residual), factor: Vec::new() };
                }
                factor[i * k + j] = if i == j { left.sqrt() } else { left / factor[j * k + j] };
            }
        }
        Self { problem, subset, residual, rss: square(residual), factor }
    }

    /// A lower bound on the squared residual, in the reachable part, after column `j` is chosen too. `v` (k) is scratch space.
    fn bound(&self, j: usize, v: &mut [f64]) -> f64 {
        let k = self.subset.len();
        if self.factor.len() < k * k {
            return 0.0;
        }
        let mut left = 1.0;
        for i in 0..k {
            let row = &self.factor[i * k..=i * k + i];
            let known: f64 = row[..i].iter().zip(&*v).map(|(l, v)| l * v).sum();
            v[i] = (self.problem.product(self.subset[i], j) - known) / row[i];
            left -= v[i] * v[i];
        }
        if left < TRUSTED {
            return 0.0;
        }
        self.rss - dot(self.problem.column(j), self.residual).powi(2) / left - 1e-8 * self.rss
    }
}
