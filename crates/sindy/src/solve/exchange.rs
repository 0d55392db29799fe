//! Good subsets without a proof: forward steps and exchanges.

use super::candidates::{Candidate, Kept};
use super::problem::{DEPENDENT, Problem, dot, square, subtract, take_out_all};

/// Subsets to start from.
const STARTS: usize = 2;

/// Rounds of exchanges; each one improves the residual, so this is never reached in practice.
const ROUNDS: usize = 40;

/// Offers good subsets of one more column than `from` have: a forward step from each, then exchanges until none helps.
pub(crate) fn grow(problem: &Problem, from: &[Candidate], kept: &mut Kept) {
    for start in from.iter().take(STARTS) {
        if let Some(grown) = complete(problem, &start.subset, kept) {
            exchange(problem, grown, kept);
        }
    }
}

/// Offers good subsets of one column less than `from` have: the best that is left of each, then exchanges until none helps.
///
/// # References
/// Pudil, Novovičová, Kittler (1994), Floating search methods in feature selection, Pattern Recognition Letters 15(11).
pub(crate) fn shrink(problem: &Problem, from: &[Candidate], kept: &mut Kept) {
    for start in from.iter().take(STARTS) {
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
    let rss = square(&residual);
    let mut best: Option<Candidate> = None;
    for j in (0..problem.n_columns()).filter(|j| !subset.contains(j)) {
        let of = |c: &Candidate| c.rss;
        let bar = best.as_ref().map_or(f64::INFINITY, of).max(kept.cutoff()) - problem.unreachable();
        if promising(problem.column(j), &basis, &residual, rss) > bar {
            continue;
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

/// A quick lower bound on the squared residual after `column` is chosen too.
fn promising(column: &[f64], basis: &[Vec<f64>], residual: &[f64], rss: f64) -> f64 {
    /// Lengths below this (squared) are not trusted to a difference of squares.
    const TRUSTED: f64 = 1e-6;
    let shared: f64 = basis.iter().map(|q| dot(column, q).powi(2)).sum();
    let left = 1.0 - shared;
    if left < TRUSTED {
        return 0.0;
    }
    rss - dot(column, residual).powi(2) / left - 1e-8 * rss
}
