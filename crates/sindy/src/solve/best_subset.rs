//! Best-subset regression: for each number of terms, the terms with the smallest residual.

use super::candidates::{Candidate, Kept};
use super::criterion::{Criterion, FLOOR_FACTOR, by_chance, explained, rms};
use super::exchange::{grow, shrink};
use super::path::Subset;
use super::prepare::{distinct, most_promising_first, problem, split, unit};
use super::problem::Problem;
use super::tree::{Bound, Limits, search};
use crate::Triangle;
use serde::{Deserialize, Serialize};

/// Finds, for each size, the best subset of terms, and says which size to believe.
///
/// Forward steps and exchanges find good subsets of each size; [`SubsetPath`](crate::SubsetPath)'s search then looks for
/// better ones, for no more than `budget` operations, of which looking at one subset is about one. A size it does not
/// get through is marked as not proved. Terms that equal another term (up to a factor)
/// on the data are represented by the simplest of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BestSubset {
    max_size: usize,
    budget: u64,
}

impl Default for BestSubset {
    fn default() -> Self {
        Self { max_size: 20, budget: 5_000_000 }
    }
}

/// What is known about an equation before its terms are chosen.
#[derive(Debug, Clone, Copy)]
pub struct Selection<'a> {
    /// RMS residual \[unit of the target\] that rounding alone leaves; zero if it is not known.
    pub floor: f64,
    /// Complexity of each term (F): the simpler of equally good subsets is taken.
    pub complexity: &'a [u32],
    /// The terms (F, and any other columns) over the region where the equation is to be used; without it, where the
    /// data are.
    pub region: Option<&'a Triangle>,
}

/// The best subset of one size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SizeReport {
    /// Its terms, ascending.
    pub support: Vec<usize>,
    /// RMS residual \[unit of the target\].
    pub residual: f64,
    /// Whether no subset of this size is better.
    pub proved: bool,
}

/// The terms chosen for one equation.
#[derive(Debug, Clone, PartialEq)]
pub struct Selected {
    /// Terms, ascending.
    pub support: Vec<usize>,
    /// Their coefficients.
    pub coefficients: Vec<f64>,
    /// RMS residual \[unit of the target\].
    pub residual: f64,
    /// Whether the residual is no more than rounding explains.
    pub reached_floor: bool,
    /// Whether no subset of this size is better.
    pub proved: bool,
    /// Whether the solver came to rest before its last round.
    pub converged: bool,
    /// The best subset of each size tried, from no term on.
    pub path: Vec<SizeReport>,
    /// Other subsets that the data cannot tell from this one, best first, at most eight.
    pub ties: Vec<Vec<usize>>,
}

/// Part of the floor within which residuals are as good as equal: the floor is generous, ties should not be.
const TIE: f64 = 0.25;

/// Difference of scores below which two subsets are not told apart: the odds are less than twenty to one.
const UNDECIDED: f64 = 6.0;

/// Ties reported.
const TIES: usize = 8;

/// Largest part of the rows that the terms of an equation whose residual is not explained may number: of an equation with
/// as many terms as rows nothing is left to judge by, and its score means nothing.
const MOST_TERMS: (usize, usize) = (2, 3);

/// Candidates kept per size.
const KEPT: usize = 24;

/// Residuals this many times the best one's (squared) are of no interest.
const NEAR_BEST: f64 = 4.0;

/// Subsets of one size from which those of the next are grown.
const STARTS: usize = 2;

/// Sizes always tried where rounding is known.
const SHORT: usize = 4;

/// Sizes tried beyond the best one so far.
const PATIENCE: usize = 5;

/// The best subsets of each size.
#[derive(Debug, Clone, Default)]
pub(crate) struct Candidates {
    /// From no term on: the best ones first, and whether none better was missed.
    pub(crate) sizes: Vec<(Vec<Subset>, bool)>,
    /// Columns left out because they equal another, with that one.
    pub(crate) equal: Vec<(usize, usize)>,
    /// Operations that this took.
    pub(crate) work: u64,
}

impl BestSubset {
    /// The same search with no more than `max_size` terms in an equation.
    #[must_use]
    pub fn with_max_size(self, max_size: usize) -> Self {
        Self { max_size, ..self }
    }

    /// The same search with at most about `budget` operations for each size.
    #[must_use]
    pub fn with_budget(self, budget: u64) -> Self {
        Self { budget, ..self }
    }

    /// The same search with no more than `budget` operations for each size.
    #[must_use]
    pub(crate) fn within(self, budget: u64) -> Self {
        Self { budget: self.budget.min(budget), ..self }
    }

    /// The best subsets of each size from none on, at most [`KEPT`] of each, best first, and whether none better was missed; until
    /// `enough` says of the best of a size that larger ones are of no interest.
    ///
    /// `complexity` (F) decides which of equal columns stands for the others. Larger subsets are grown from `starts` smaller ones: noise
    /// hides which of them lead on.
    pub(crate) fn candidates(
        &self,
        triangle: &Triangle,
        (target, starts): (usize, usize),
        complexity: &[u32],
        go_on: &dyn Fn() -> bool,
        mut enough: impl FnMut(&Subset) -> bool,
    ) -> Candidates {
        let (columns, equal, problem) = simplest(triangle, target, complexity);
        let rows = triangle.n_rows();
        let limits = Limits { bound: Bound::Gains, budget: self.budget, go_on };
        let mut sizes: Vec<(Kept, bool)> = Vec::new();
        let mut work = 0;
        let mut smaller: Vec<Candidate> = Vec::new();
        let subset = |c: &Candidate| Subset { support: support_of(c, &columns), rss: c.rss };
        for size in 0..=self.max_size.min(columns.len()).min(rows.saturating_sub(2)) {
            let mut kept = Kept::new(KEPT, NEAR_BEST, 0.0);
            if size > 0 {
                grow(&problem, &smaller[..smaller.len().min(starts)], &mut kept);
            }
            let begun = rows > columns.len() || problem.n_subsets(size) <= self.budget as f64;
            let searched = begun.then(|| search(&problem, size, &limits, &mut kept));
            work += searched.as_ref().map_or(0, |account| account.work);
            let complete = searched.is_some_and(|account| account.open.is_infinite());
            smaller = kept.clone().into_best();
            let stop = smaller.first().is_none_or(|c| enough(&subset(c)));
            sizes.push((kept, complete));
            if stop || !go_on() {
                break;
            }
        }
        // Back down: a larger subset may hold a better smaller one than those that grew.
        for at in (1..sizes.len()).rev() {
            let (below, from) = sizes.split_at_mut(at);
            if let (Some((kept, false)), Some((larger, _))) = (below.last_mut(), from.first()) {
                let larger = larger.clone().into_best();
                shrink(&problem, &larger[..larger.len().min(starts)], kept);
            }
        }
        let of = |(kept, proved): (Kept, bool)| (kept.into_best().iter().map(subset).collect(), proved);
        work += problem.work();
        Candidates { sizes: sizes.into_iter().map(of).collect(), equal, work }
    }

    /// Chooses among the first `complexity.len()` columns of `triangle` for its column `target`.
    #[must_use]
    pub fn solve(&self, triangle: &Triangle, target: usize, selection: Selection<'_>) -> Selected {
        self.solve_while(triangle, target, selection, &|| true)
    }

    /// The same as long as `go_on` says so, which is asked at every node.
    #[must_use]
    pub fn solve_while(
        &self,
        triangle: &Triangle,
        target: usize,
        selection: Selection<'_>,
        go_on: &dyn Fn() -> bool,
    ) -> Selected {
        let (columns, equal, problem) = simplest(triangle, target, selection.complexity);
        let rows = triangle.n_rows();
        let criterion = Criterion {
            problem: &problem,
            triangle,
            columns: &columns,
            complexity: selection.complexity,
            region: selection.region,
            floor: selection.floor,
        };
        let most_terms = rows * MOST_TERMS.0 / MOST_TERMS.1;
        let exact = |c: &Candidate| c.rss <= explained(selection.floor, rows, c.subset.len());
        let mut sizes: Vec<(Vec<Candidate>, bool)> = Vec::new();
        let mut winner: Option<(f64, Candidate)> = None;
        let limits = Limits { bound: Bound::Gains, budget: self.budget, go_on };
        for size in 0..=self.max_size.min(columns.len()).min(rows.saturating_sub(2)) {
            let interesting = explained(selection.floor, rows, size);
            let mut kept = Kept::new(KEPT, NEAR_BEST, interesting);
            if let Some((smaller, _)) = sizes.last() {
                grow(&problem, &smaller[..smaller.len().min(STARTS)], &mut kept);
            }
            // Where nothing bounds, what is too much to look at is not begun, and larger sizes are still more.
            let begun = rows > columns.len()
                || (problem.n_subsets(size) <= self.budget as f64 && sizes.last().is_none_or(|s| s.1));
            let complete = begun && search(&problem, size, &limits, &mut kept).open.is_infinite();
            let found = kept.into_best();
            // More terms than this can only fit rounding.
            let enough =
                found.first().is_some_and(|c| exact(c) && !by_chance(&problem, c.rss.max(interesting), rows, size));
            if enough || size <= most_terms {
                let scored = found.iter().map(|c| (criterion.score(c), c)).min_by(|(a, _), (b, _)| a.total_cmp(b));
                if let Some((score, candidate)) = scored.filter(|(s, _)| winner.as_ref().is_none_or(|(w, _)| s < w)) {
                    winner = Some((score, candidate.clone()));
                }
            }
            sizes.push((found, complete));
            let best_size = winner.as_ref().map_or(0, |(_, c)| c.subset.len());
            // Exact equations are short; they may be found on hardly more rows than terms.
            let short = size < SHORT && selection.floor > 0.0;
            if enough || (size >= most_terms.min(best_size + PATIENCE) && !short) || !go_on() {
                break;
            }
        }
        let reached_floor = winner.as_ref().is_some_and(|(_, c)| exact(c));
        let mut equals: Vec<&Candidate> = match &winner {
            None => Vec::new(),
            Some((_, winner)) if reached_floor => {
                let found = &sizes[winner.subset.len()].0;
                let best = found.first().map_or(0.0, |c| c.rss);
                let tolerated = explained(TIE * selection.floor, rows, winner.subset.len()).max(NEAR_BEST * best);
                let cost = |c: &&Candidate| c.subset.iter().map(|&j| selection.complexity[columns[j]]).sum::<u32>();
                let mut equals: Vec<&Candidate> = found.iter().filter(|c| c.rss <= tolerated).collect();
                equals.sort_by_key(cost);
                equals
            }
            Some((least, _)) => {
                let tried = sizes.iter().flat_map(|(found, _)| found).filter(|c| c.subset.len() <= most_terms);
                let mut equals: Vec<(f64, &Candidate)> = tried.map(|c| (criterion.score(c), c)).collect();
                equals.retain(|(score, _)| *score < least + UNDECIDED);
                equals.sort_by(|(a, _), (b, _)| a.total_cmp(b));
                equals.into_iter().map(|(_, c)| c).collect()
            }
        };
        equals.truncate(TIES + 1);
        let mut equals = equals.into_iter().map(|c| support_of(c, &columns));
        let support = equals.next().unwrap_or_default();
        let exchanged = |&(out, kept): &(usize, usize)| {
            let mut other: Vec<usize> = support.iter().map(|&j| if j == kept { out } else { j }).collect();
            other.sort_unstable();
            (other != support).then_some(other)
        };
        let mut ties: Vec<Vec<usize>> = equal.iter().filter_map(exchanged).take(TIES).collect();
        let n_twins = ties.len();
        ties.extend(equals.take(TIES - n_twins));
        let proved = sizes.get(support.len()).is_some_and(|(_, proved)| *proved);
        let coefficients = triangle.solve_unit(&support, target);
        let residual = rms(triangle.residual_norm(&support, &coefficients, target).powi(2), rows, support.len());
        let path = sizes.iter().map(|(found, proved)| SizeReport {
            support: found.first().map_or(vec![], |c| support_of(c, &columns)),
            residual: found.first().map_or(f64::NAN, |c| rms(c.rss, rows, c.subset.len())),
            proved: *proved,
        });
        Selected { support, coefficients, residual, reached_floor, proved, converged: true, path: path.collect(), ties }
    }
}

fn support_of(candidate: &Candidate, columns: &[usize]) -> Vec<usize> {
    let mut support: Vec<usize> = candidate.subset.iter().map(|&j| columns[j]).collect();
    support.sort_unstable();
    support
}

/// The columns that differ, the simplest of equal ones and the most promising first, as a problem; with their numbers
/// in the triangle, and the columns left out, each with the one that equals it.
fn simplest(triangle: &Triangle, target: usize, complexity: &[u32]) -> (Vec<usize>, Vec<(usize, usize)>, Problem) {
    let dim = complexity.len().min(triangle.n_rows());
    let mut order: Vec<usize> = (0..complexity.len()).collect();
    order.sort_by_key(|&j| complexity[j]);
    let (mut kept, equal) = distinct(order.into_iter().filter_map(|j| unit(triangle, j, dim)));
    let (y, unreachable) = split(triangle, target, dim);
    most_promising_first(&mut kept, &y);
    let (columns, problem) = problem(dim, kept, y, unreachable);
    (columns, equal, problem)
}

impl Selected {
    /// All columns before `target`, with their least-squares coefficients.
    pub(crate) fn all(triangle: &Triangle, target: usize, floor: f64) -> Self {
        let support: Vec<usize> = (0..target).collect();
        let coefficients = triangle.solve_unit(&support, target);
        Self::unsearched(triangle, target, (support, coefficients), floor)
    }

    /// The same with term j called `numbers[j]`.
    pub(crate) fn renumbered(mut self, numbers: &[usize]) -> Self {
        let paths = self.path.iter_mut().flat_map(|s| s.support.iter_mut());
        for j in self.support.iter_mut().chain(paths).chain(self.ties.iter_mut().flatten()) {
            *j = numbers[*j];
        }
        self
    }

    /// The same with the account of the search that found the terms.
    pub(crate) fn found_by(self, search: &Self) -> Self {
        Self { proved: search.proved, path: search.path.clone(), ties: search.ties.clone(), ..self }
    }

    /// The account of a fit of all terms, with coefficients that may be zero.
    pub(crate) fn dense(triangle: &Triangle, target: usize, coefficients: &[f64], floor: f64) -> Self {
        let kept = coefficients.iter().copied().enumerate().filter(|(_, c)| *c != 0.0);
        Self::unsearched(triangle, target, kept.unzip(), floor)
    }

    /// The account of terms and coefficients that nobody searched for.
    fn unsearched(
        triangle: &Triangle,
        target: usize,
        (support, coefficients): (Vec<usize>, Vec<f64>),
        floor: f64,
    ) -> Self {
        let rows = triangle.n_rows();
        let residual = rms(triangle.residual_norm(&support, &coefficients, target).powi(2), rows, support.len());
        let reached_floor = rows > support.len() && residual <= FLOOR_FACTOR * floor;
        Self {
            support,
            coefficients,
            residual,
            reached_floor,
            proved: false,
            converged: true,
            path: Vec::new(),
            ties: Vec::new(),
        }
    }
}
