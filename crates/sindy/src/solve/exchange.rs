//! Good subsets without a proof: forward steps and exchanges.

use std::cell::OnceCell;

use super::candidates::{Candidate, Kept};
use super::problem::{DEPENDENT, Left, Problem, dot, square, subtract, take_out_all};

/// Rounds of exchanges; each one improves the residual, so this is never reached in practice.
const ROUNDS: usize = 40;

/// Offers good subsets of one more column than those in `from` have: a forward step from each, then exchanges until none helps.
pub(crate) fn grow(problem: &Problem, from: &[Candidate], kept: &mut Kept) {
    for start in from {
        if let Some(grown) = forward(problem, &start.subset, kept) {
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

/// The best of `subset` with one more column; all of them are offered.
fn forward(problem: &Problem, subset: &[usize], kept: &mut Kept) -> Option<Candidate> {
    let view = View::new(problem, subset)?;
    let mut best = None;
    view.complete(None, &mut best, kept);
    best
}

/// Exchanges one column of `current` for another as long as that helps, and leads to a subset that no exchanges have come to yet: from there they go on as before.
fn exchange(problem: &Problem, mut current: Candidate, kept: &mut Kept) {
    for _ in 0..ROUNDS {
        if !kept.is_new(&current.subset) {
            break;
        }
        let Some(view) = View::new(problem, &current.subset) else { break };
        let mut better = None;
        for out in 0..current.subset.len() {
            view.complete(Some(out), &mut better, kept);
        }
        match better.filter(|b| b.rss < current.rss * (1.0 - 1e-9)) {
            Some(next) => current = next,
            None => break,
        }
    }
}

/// All columns as a subset leaves them: what its subsets of one column less leave follows from that.
struct View<'a> {
    problem: &'a Problem,
    subset: &'a [usize],
    /// Inner products of the orthonormal basis of the subset with the target (k).
    target: Vec<f64>,
    /// Squared length of what the subset leaves of the target, as far as columns reach.
    rss: f64,
    /// Length of the target.
    length: f64,
    /// R of the subset's columns in the basis, column after column (k, k).
    triangle: Vec<f64>,
    others: Vec<Other>,
    /// Inner products of each of the others with the basis (others, k).
    along: Vec<f64>,
}

/// A column that is not in the subset.
struct Other {
    column: usize,
    /// Squared length of what the subset leaves of it, and length of what that was computed from.
    distance: f64,
    from: f64,
    /// Inner product of that with what it leaves of the target.
    reached: f64,
}

/// Squared length of what a subset leaves of a column, below which it is computed anew from the column.
const TRUSTED: f64 = 1e-4;

/// By how much rounding may change what orthogonal columns leave of one of unit length; and part of what a subset leaves of the target by which that may be wrong before it is computed anew
/// from columns.
const WRONG: f64 = 1e-14;
const TOLD: f64 = 1e-3;

/// Part of the target's length by which rounding may change what a subset leaves of it.
const ROUNDING: f64 = 1e-14;

/// The rest of a subset, and what it leaves, once somebody asked; none where its columns depend on each other.
struct Rest<'a> {
    problem: &'a Problem,
    columns: Vec<usize>,
    left: OnceCell<Option<Left>>,
}

impl<'a> Rest<'a> {
    fn new(problem: &'a Problem, subset: &[usize], out: Option<usize>) -> Self {
        let columns = subset.iter().enumerate().filter(|(at, _)| Some(*at) != out).map(|(_, &i)| i).collect();
        Self { problem, columns, left: OnceCell::new() }
    }

    /// The squared residual, as far as columns reach, with column `j` added, but for rounding below it. `None` if the columns depend on each other.
    fn with(&self, j: usize) -> Option<f64> {
        let Self { problem, columns, .. } = self;
        let Left { basis, residual } = self.left.get_or_init(|| problem.left(columns)).as_ref()?;
        let mut left = problem.column(j).to_vec();
        take_out_all(&mut left, basis);
        problem.worked(4 * (basis.len() + 1), 2, 0);
        let length = square(&left).sqrt();
        if length * length < DEPENDENT {
            return None;
        }
        left.iter_mut().for_each(|v| *v /= length);
        let mut residual = residual.clone();
        subtract(&mut residual, &left);
        let rounding = ROUNDING * square(problem.target()).sqrt();
        Some((square(&residual).sqrt() - rounding).max(0.0).powi(2))
    }
}

impl<'a> View<'a> {
    /// None if the columns of `subset` depend on each other.
    fn new(problem: &'a Problem, subset: &'a [usize]) -> Option<Self> {
        let k = subset.len();
        let Left { basis, residual } = problem.left(subset)?;
        let onto = |a: &[f64], along: &mut Vec<f64>| along.extend(basis.iter().map(|q| dot(q, a)));
        let mut along = Vec::with_capacity(k * problem.n_columns());
        let other = |column: usize| {
            let a = problem.column(column);
            onto(a, &mut along);
            let (mut distance, mut from) = (1.0 - square(&along[along.len() - k..]), 1.0);
            let mut reached = dot(&residual, a);
            if distance < TRUSTED {
                let mut left = a.to_vec();
                take_out_all(&mut left, &basis);
                problem.worked(4 * k, 1, 0);
                (distance, reached) = (square(&left), dot(&residual, &left));
                from = distance.sqrt();
            }
            Other { column, distance, from, reached }
        };
        let others: Vec<Other> = (0..problem.n_columns()).filter(|j| !subset.contains(j)).map(other).collect();
        problem.worked((others.len() + 4 * k) * (k + 1), 0, 0);
        let (mut triangle, mut target) = (Vec::with_capacity(k * k), Vec::with_capacity(k));
        subset.iter().for_each(|&j| onto(problem.column(j), &mut triangle));
        onto(problem.target(), &mut target);
        let length = square(problem.target()).sqrt();
        Some(Self { problem, subset, target, rss: square(&residual), length, triangle, others, along })
    }

    /// The direction, in the basis, in which the subset's column number `out` alone reaches.
    fn direction(&self, out: usize) -> Vec<f64> {
        let k = self.subset.len();
        let mut z = vec![0.0; k];
        for i in out..k {
            let column = &self.triangle[i * k..=i * k + i];
            let known: f64 = column[..i].iter().zip(&z).map(|(r, z)| r * z).sum();
            z[i] = (if i == out { 1.0 } else { 0.0 } - known) / column[i];
        }
        let length = square(&z).sqrt();
        z.iter_mut().for_each(|v| *v /= length);
        z
    }

    /// What the subset leaves of the target with `other` in place of a column, and by how much that may be wrong: of the target that column alone reaches `freed`, of `other` the length `along` lies in its direction.
    ///
    /// It is |w|² − (w·v)²/|v|², w = r + f z, v = a + t z, with r and a what the subset leaves of the target and of `other`, and z of unit length orthogonal to both. By Lagrange's identity this is
    /// (|r|²|a|² − (r·a)² + |t r − f a|²)/|v|², in which nothing of the size of f² is cancelled.
    fn left(&self, other: &Other, freed: f64, along: f64) -> (f64, f64) {
        let Self { rss, length, .. } = *self;
        let Other { distance, from, reached, .. } = *other;
        let (of_residual, of_column) = (along * along * rss, freed * freed * distance);
        let apart = (rss * distance - reached * reached).max(0.0);
        let crossed = (of_residual + of_column - 2.0 * along * freed * reached).max(0.0);
        let distance_wrong = WRONG * (2.0 * from + WRONG);
        let reached_wrong = WRONG * (length * from + rss.sqrt());
        let rss_wrong = WRONG * length * (2.0 * rss.sqrt() + WRONG * length);
        let wrong = (rss + freed * freed) * distance_wrong
            + 2.0 * (reached.abs() + (along * freed).abs()) * reached_wrong
            + WRONG * (rss * distance + of_residual + of_column);
        let whole = distance + along * along;
        ((apart + crossed) / whole, wrong / whole + rss_wrong)
    }

    /// Offers the subset, without its column number `out` if there is one, with each other column added; `best` is the best of all so far.
    fn complete(&self, out: Option<usize>, best: &mut Option<Candidate>, kept: &mut Kept) {
        let Self { problem, subset, .. } = *self;
        let k = subset.len();
        let z = out.map(|out| self.direction(out));
        let along = |of: &[f64]| z.as_ref().map_or(0.0, |z| dot(z, of));
        let freed = along(&self.target);
        let rest = Rest::new(problem, subset, out);
        let mut order: Vec<(f64, usize)> = Vec::with_capacity(self.others.len());
        for (at, other) in self.others.iter().enumerate() {
            let t = along(&self.along[at * k..(at + 1) * k]);
            let distance = other.distance + t * t;
            if distance < DEPENDENT {
                continue;
            }
            let (left, wrong) = self.left(other, freed, t);
            let bound = if wrong < TOLD * left { Some(left - wrong) } else { rest.with(other.column) };
            order.extend(bound.map(|bound| (bound + problem.unreachable(), other.column)));
        }
        problem.worked(0, 1, self.others.len() * (1 + k / 8));
        let is_passed_over = |bound: f64, best: &Option<Candidate>, kept: &Kept| {
            bound * (1.0 - 1e-8) > best.as_ref().map_or(f64::INFINITY, |b| b.rss).max(kept.cutoff())
        };
        order.retain(|(bound, _)| !is_passed_over(*bound, best, kept));
        // The most promising first: what follows is then passed over.
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (bound, j) in order {
            if is_passed_over(bound, best, kept) {
                break;
            }
            let mut with = rest.columns.clone();
            with.insert(with.partition_point(|&i| i < j), j);
            // The same number, to the last bit, by whatever way a subset is met.
            let Some(rss) = kept.known(&with).or_else(|| problem.rss(&with)) else { continue };
            kept.offer(rss, &with);
            if best.as_ref().is_none_or(|b| rss < b.rss) {
                *best = Some(Candidate { rss, subset: with });
            }
        }
    }
}
