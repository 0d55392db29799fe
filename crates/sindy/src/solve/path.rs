//! The best subset of every size, with what is proved about it.

use super::candidates::{Candidate, Kept};
use super::constraints::{ConstraintError, Constraints};
use super::exchange::grow;
use super::grouped;
use super::prepare::{Prepared, prepare};
use super::tree::{Account, Bound, Limits, search};
use crate::Triangle;

/// Finds, for every number of terms up to a largest one, the subset with the smallest residual.
///
/// Minimises ‖Θ_S ξ − y‖² over ξ and S with |S| = 0, 1, …, k by branch and bound on the triangle. Good subsets come
/// first from forward steps and exchanges; the tree of all subsets is then searched for better ones, the last two
/// columns of a subset together by their inner products, and every subset that might be better is computed anew from
/// orthogonal columns. What the search may cost is counted in operations, so that a result does not depend on the
/// machine; where the budget ends, the gap that is left is told.
///
/// A squared residual below 10⁻²⁸ of the squared target is nothing but rounding: a subset that comes so close is as good
/// as any, and no better one is looked for.
///
/// Columns that equal another column up to a factor are represented by the first of them.
///
/// # References
/// Furnival, Wilson (1974), Technometrics 16(4), leaps and bounds. [`Bound`] says what else cuts the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubsetPath {
    max_size: usize,
    keep: usize,
    budget: u64,
    bound: Bound,
}

/// A subset and its squared residual.
#[derive(Debug, Clone, PartialEq)]
pub struct Subset {
    /// Columns, ascending, fixed ones among them.
    pub support: Vec<usize>,
    /// ‖Θ_S ξ − y‖².
    pub rss: f64,
}

/// What is known about the subsets of one size.
#[derive(Debug, Clone, PartialEq)]
pub struct SizeResult {
    /// Number of terms: free columns and groups.
    pub size: usize,
    /// The best subsets found, best first; as many as were asked for, or all there are.
    pub subsets: Vec<Subset>,
    /// No subset of this size has a squared residual below this.
    pub lower_bound: f64,
    /// Whether `subsets` are proved to be the best ones.
    pub proved: bool,
    /// Operations spent on it.
    pub operations: u64,
    /// Nodes of the tree looked at, those with the last two columns to choose not counted.
    pub nodes: u64,
}

/// The best subsets of every size from no term on.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// One entry per size, ascending, until the columns that do not depend on each other are used up.
    pub sizes: Vec<SizeResult>,
    /// Columns left out because another one equals them up to a factor, with that one.
    pub equal: Vec<(usize, usize)>,
}

impl Default for SubsetPath {
    /// Ten terms, the best subset of each size only, at most 4·10⁸ operations (about a second) for each, bounded by gains.
    fn default() -> Self {
        Self { max_size: 10, keep: 1, budget: 400_000_000, bound: Bound::Gains }
    }
}

impl SubsetPath {
    /// The same for up to `max_size` terms.
    #[must_use]
    pub fn with_max_size(self, max_size: usize) -> Self {
        Self { max_size, ..self }
    }

    /// The same with the `keep` best subsets of each size.
    #[must_use]
    pub fn with_keep(self, keep: usize) -> Self {
        Self { keep: keep.max(1), ..self }
    }

    /// The same with at most about `operations` for each size.
    #[must_use]
    pub fn with_budget(self, operations: u64) -> Self {
        Self { budget: operations, ..self }
    }

    /// The same with other bounds.
    #[must_use]
    pub fn with_bound(self, bound: Bound) -> Self {
        Self { bound, ..self }
    }

    /// Chooses among the first `n_features` columns of `triangle` for its column `target`.
    ///
    /// # Errors
    /// [`ConstraintError`] for a column that is not there or is named twice, or an empty group.
    pub fn solve(
        &self,
        triangle: &Triangle,
        n_features: usize,
        target: usize,
        constraints: &Constraints,
    ) -> Result<Path, ConstraintError> {
        self.solve_while(triangle, n_features, target, constraints, &|| true)
    }

    /// The same as long as `go_on` says so, which is asked at every node: this is where a time limit goes. What is not
    /// searched any more is not proved.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_while(
        &self,
        triangle: &Triangle,
        n_features: usize,
        target: usize,
        constraints: &Constraints,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Path, ConstraintError> {
        constraints.check(n_features)?;
        let prepared = prepare(triangle, n_features, target, constraints);
        let limits = Limits { bound: self.bound, budget: self.budget, go_on };
        let n_units = prepared.units.len();
        let mut sizes: Vec<SizeResult> = Vec::new();
        let mut smaller: Vec<Candidate> = Vec::new();
        for size in 0..=self.max_size.min(n_units) {
            let mut kept = Kept::new(self.keep, f64::INFINITY, f64::INFINITY);
            if size == 0 {
                kept.offer(prepared.problem.total(), &[]);
            }
            let account = if prepared.singles {
                grow(&prepared.problem, &smaller, &mut kept);
                search(&prepared.problem, size, &limits, &mut kept)
            } else {
                grouped::search(&prepared.problem, &prepared.units, size, &limits, &mut kept)
            };
            smaller = kept.into_best();
            if smaller.is_empty() && account.open.is_infinite() {
                break;
            }
            sizes.push(prepared.result(size, &smaller, account));
        }
        // A subset of fewer terms is no better than the best one of more.
        for at in (1..sizes.len()).rev() {
            let of_more = sizes[at].lower_bound;
            let fewer = &mut sizes[at - 1];
            let best = fewer.subsets.first().map_or(f64::INFINITY, |s| s.rss);
            fewer.lower_bound = fewer.lower_bound.max(of_more).min(best);
        }
        Ok(Path { sizes, equal: prepared.equal })
    }
}

impl SizeResult {
    /// (rss − lower bound) / rss of the best subset: 0 when it is proved.
    #[must_use]
    pub fn gap(&self) -> f64 {
        match self.subsets.first() {
            Some(best) if best.rss > self.lower_bound => 1.0 - self.lower_bound / best.rss,
            Some(_) => 0.0,
            None => 1.0,
        }
    }
}

impl Prepared {
    fn result(&self, size: usize, found: &[Candidate], account: Account) -> SizeResult {
        let subsets: Vec<Subset> =
            found.iter().map(|c| Subset { support: self.support(&c.subset), rss: c.rss }).collect();
        let best = found.first().map_or(f64::INFINITY, |c| c.rss);
        let worst = found.last().map_or(f64::INFINITY, |c| c.rss);
        SizeResult {
            size,
            subsets,
            lower_bound: best.min(account.open).max(0.0),
            proved: account.open >= worst && account.open.is_infinite() || account.open > worst,
            operations: account.work,
            nodes: account.nodes,
        }
    }
}
