//! Linear regressions along a path: which terms each equation may have.

use ndarray::{Array2, Axis, concatenate};

use super::problem::Problem;
use super::regression::Regression;
use crate::Triangle;
use crate::design::{Path, averages, whiten};
use crate::library::Term;
use crate::shooting::{Flow, Samples};
use crate::solve::Subset;

/// Equations found before, their coefficients, and the states (T + 1, n) of each segment that follow them.
pub(super) type Along<'a> = (&'a Flow, &'a [f64], &'a [Array2<f64>]);

/// Part of the noise that is left on a smoothed path.
const SMOOTHED: f64 = 0.5;

/// Rates of errors on the path before anything is known of the equations, in standard deviations of a channel per step.
const UNKNOWN: f64 = 0.2;

/// Sizes looked at beyond the best one.
const PATIENCE: usize = 4;

/// What is spent on one regression.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Operations for each size.
    pub(super) budget: u64,
    /// Subsets of each size from which larger ones are grown.
    pub(super) starts: usize,
}

pub(super) const THOROUGHLY: Effort = Effort { budget: 100_000, starts: 8 };
pub(super) const ROUGHLY: Effort = Effort { budget: 10_000, starts: 2 };

/// Multiples of an own derivative that are looked at thoroughly, of those that score best, and of those that do when terms are dear.
const PROMISING: usize = 2;

/// Multiple of what terms cost when they are dear.
pub(super) const DEAR: f64 = 16.0;

impl Problem<'_> {
    /// The best terms of every equation on `path`, for noise of standard deviations `sigma` (n).
    pub(super) fn propose(&self, path: &Path<'_>, sigma: &[f64]) -> Vec<Regression> {
        let theta = self.averaged(&self.terms[..self.n_plain], path);
        let errors = self.errors(sigma, None);
        let regression = |i: usize| match self.rates[i] {
            Some(_) => Regression::none(),
            None => self.regression(&theta, i, self.choice(i), (sigma, &errors), (usize::MAX, THOROUGHLY)),
        };
        (0..self.rates.len()).map(regression).collect()
    }

    /// The same for equation `i` alone, with one term that multiplies its own derivative beside the others: one regression for each
    /// such term, of at most `most` terms besides one of `choice`. `along` are equations found before and their coefficients, whose
    /// derivatives tell what errors of the path do.
    pub(super) fn propose_implicit(
        &self,
        i: usize,
        path: &Path<'_>,
        sigma: &[f64],
        along: Option<Along<'_>>,
        (choice, most): (&[usize], usize),
    ) -> Vec<Regression> {
        let theta = self.averaged(&self.terms[..self.n_plain], path);
        let errors = self.errors(sigma, along);
        let own = (0..self.n_plain).filter(|&j| self.terms[j].rate == Some(i) && !self.terms[j].expr.is_one());
        let regression = |j: usize, effort: Effort| {
            self.regression(&theta, i, [choice, &[j]].concat(), (sigma, &errors), (most, effort))
        };
        let mut ranked: Vec<(f64, f64, usize)> = own
            .map(|j| {
                let roughly = regression(j, ROUGHLY);
                let score = |times: f64| roughly.best(times, |support| self.penalty(support)).score;
                (score(1.0), score(DEAR), j)
            })
            .collect();
        let mut promising: Vec<usize> = Vec::new();
        let mut take = |ranked: &[(f64, f64, usize)]| promising.extend(ranked.iter().take(PROMISING).map(|r| r.2));
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        take(&ranked);
        ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
        take(&ranked);
        promising.sort_unstable();
        promising.dedup();
        promising.into_iter().map(|j| regression(j, THOROUGHLY)).collect()
    }

    /// The average of each of `terms` over each step of `path` (T, F), one array per segment; zero for terms that are not finite somewhere.
    pub(super) fn averaged(&self, terms: &[Term], path: &Path<'_>) -> Vec<Array2<f64>> {
        let mut all: Vec<Array2<f64>> =
            self.segments.iter().enumerate().map(|(at, s)| averages(terms, s, at, path)).collect();
        for j in 0..terms.len() {
            if all.iter().any(|theta| theta.column(j).iter().any(|v| !v.is_finite())) {
                all.iter_mut().for_each(|theta| theta.column_mut(j).fill(0.0));
            }
        }
        all
    }

    pub(super) fn regression(
        &self,
        theta: &[Array2<f64>],
        i: usize,
        choice: Vec<usize>,
        (sigma, errors): (&[f64], &[Array2<f64>]),
        (most, effort): (usize, Effort),
    ) -> Regression {
        match self.rows(theta, &choice, i, sigma, errors) {
            Some((triangle, own)) => self.subsets(i, (triangle, self.least(i..=i, sigma)), choice, own, (most, effort)),
            None => Regression::none(),
        }
    }

    /// The smallest mean square of what rows of the states `of` leave, whitened with `sigma` (n), that is believed: that of the smallest errors believed.
    pub(super) fn least(&self, of: std::ops::RangeInclusive<usize>, sigma: &[f64]) -> f64 {
        let squares: Vec<f64> = of.map(|i| (self.floor[i] / sigma[i]).powi(2).min(1.0)).collect();
        squares.iter().sum::<f64>() / squares.len().max(1) as f64
    }

    /// The best subsets of the terms `choice` of equation `i`, the first columns of `triangle`, for the column after them; a mean square below
    /// `least` counts as that.
    pub(super) fn subsets(
        &self,
        i: usize,
        (triangle, least): (Triangle, f64),
        mut choice: Vec<usize>,
        own: Option<f64>,
        (most, effort): (usize, Effort),
    ) -> Regression {
        // Terms that are required come first, and what they explain is taken out of the others.
        let required = self.required(i);
        let n_required = required.len();
        let mut triangle = triangle;
        if n_required > 0 {
            let is_required = |c: &usize| required.contains(&choice[*c]);
            let (first, last): (Vec<usize>, Vec<usize>) = (0..choice.len()).partition(is_required);
            let order: Vec<usize> = first.into_iter().chain(last).collect();
            let columns: Vec<Vec<(usize, f64)>> =
                order.iter().chain([&choice.len()]).map(|&c| vec![(c, 1.0)]).collect();
            triangle = triangle.combined(&columns);
            choice = order.into_iter().map(|c| choice[c]).collect();
        }
        let others = triangle.trailing(n_required);
        let complexity: Vec<u32> = choice[n_required..].iter().map(|&j| self.terms[j].complexity).collect();
        let (rows, mut best, mut since) = (triangle.n_rows() as f64, f64::INFINITY, 0);
        let enough = |best_of_size: &Subset| {
            let own = best_of_size.support.iter().map(|&c| choice[n_required + c]);
            let support: Vec<usize> = choice[..n_required].iter().copied().chain(own).collect();
            let left = (best_of_size.rss / rows).max(least).max(f64::MIN_POSITIVE);
            let score = rows * left.ln() + self.penalty(&support);
            since = if score < best { 0 } else { since + 1 };
            best = best.min(score);
            since > PATIENCE || support.len() >= most
        };
        // Where nothing is left to fit what a regression proposes, it tells no more than which terms are alike.
        let effort = if self.spent.get() < self.budget { effort } else { ROUGHLY };
        let solver = self.solver.within(effort.budget);
        let of = (choice.len() - n_required, effort.starts);
        let found = solver.candidates(&others, of, &complexity, self.watch.asks(), enough);
        self.charge(found.work);
        let constraints = self.constraints.get(i).cloned().unwrap_or_default();
        Regression { found, triangle, least, choice, n_required, own, constraints }
    }

    /// Terms equation `i` may have. Its own derivative explains itself; derivatives of states that are rates couple equations of motion, which
    /// are those of such states.
    pub(super) fn choice(&self, i: usize) -> Vec<usize> {
        let is_rate = |i: usize| self.rates.contains(&Some(i));
        let allowed = |rate: Option<usize>| rate.is_none_or(|l| l != i && is_rate(l) && is_rate(i));
        let constrained = |j: &usize| self.constraints.get(i).is_none_or(|c| c.allows(*j));
        let is_simple = |j: &usize| self.terms[*j].complexity <= self.most_complex || self.required(i).contains(j);
        (0..self.n_plain).filter(|&j| allowed(self.terms[j].rate)).filter(is_simple).filter(constrained).collect()
    }

    /// The same, but equation `i` is coupled to others as they are to it: the matrix of masses is symmetric.
    pub(super) fn symmetric(&self, i: usize, supports: &[Vec<usize>]) -> Vec<usize> {
        let coupled = |l: usize, j: usize| {
            supports[l].iter().any(|&k| self.terms[k].rate == Some(i) && self.terms[k].expr == self.terms[j].expr)
        };
        let mut choice = self.choice(i);
        choice.retain(|&j| self.terms[j].rate.is_none_or(|l| coupled(l, j)));
        choice
    }

    /// Whether equation `i` multiplies every acceleration by the same terms as the equation of that one does its own, where both have any: multiples of
    /// the rows of a symmetric matrix.
    pub(super) fn is_coupled_symmetrically(&self, supports: &[Vec<usize>], i: usize) -> bool {
        let coupling = |row: usize, to: usize| {
            let own = supports[row].iter().filter(move |&&j| self.terms[j].rate == Some(to));
            own.map(|&j| &self.terms[j].expr).collect::<Vec<_>>()
        };
        (0..supports.len()).filter(|&l| l != i).all(|l| {
            let (there, back) = (coupling(i, l), coupling(l, i));
            let alike = there.len() == back.len() && there.iter().all(|expr| back.contains(expr));
            alike || there.is_empty() || back.is_empty()
        })
    }

    /// The triangle of [Θ of `choice` | Δxᵢ/Δt], its rows whitened; `None` if a number is not finite. From a last column that
    /// multiplies the own derivative its projection on the derivative is taken, c times the derivative, lest the derivative
    /// explain itself; the number is c.
    pub(super) fn rows(
        &self,
        theta: &[Array2<f64>],
        choice: &[usize],
        i: usize,
        sigma: &[f64],
        errors: &[Array2<f64>],
    ) -> Option<(Triangle, Option<f64>)> {
        let mut whitened = Vec::with_capacity(self.segments.len());
        for ((segment, theta), errors) in self.segments.iter().zip(theta).zip(errors) {
            let given = |t: usize| -> f64 {
                let fixed = self.constraints.get(i).map_or(&[][..], |c| &c.fixed);
                fixed.iter().map(|&(j, c)| c * theta[[t, j]]).sum()
            };
            let rate = |t: usize| (segment.x[[t + 1, i]] - segment.x[[t, i]]) / segment.dt[t] - given(t);
            let target = Array2::from_shape_fn((segment.len(), 1), |(t, _)| rate(t));
            let mut rows = concatenate![Axis(1), theta.select(Axis(1), choice), target];
            let extra: Vec<f64> = errors.column(i).to_vec();
            let deviations: Vec<f64> = (0..=segment.len()).map(|t| sigma[i] * segment.relative_or_one(t, i)).collect();
            whiten(rows.view_mut(), &deviations, &extra, &segment.dt);
            whitened.push(rows);
        }
        let target = choice.len();
        let own = choice.last().filter(|&&j| self.terms.get(j).is_some_and(|t| t.rate == Some(i))).map(|_| {
            let product = |a: usize, b: usize| whitened.iter().map(|r| r.column(a).dot(&r.column(b))).sum::<f64>();
            let c = product(target - 1, target) / product(target, target);
            for rows in &mut whitened {
                let derivative = rows.column(target).to_owned();
                rows.column_mut(target - 1).scaled_add(-c, &derivative);
            }
            c
        });
        let mut triangle = Triangle::new(choice.len() + 1);
        whitened.iter().try_for_each(|rows| triangle.push(rows.view())).ok()?;
        Some((triangle, own))
    }

    /// Standard deviations of what errors of the path add to the rate of each state in each step (T, n).
    pub(super) fn errors(&self, sigma: &[f64], along: Option<Along<'_>>) -> Vec<Array2<f64>> {
        let n = sigma.len();
        let unknown = |(t, i): (usize, usize), dt: &[f64]| UNKNOWN * sigma[i] / dt[t];
        let Some((flow, xi, x)) = along else {
            let of = |s: &crate::data::Segment| Array2::from_shape_fn((s.len(), n), |at| unknown(at, &s.dt));
            return self.segments.iter().map(of).collect();
        };
        let flow = flow.for_derivatives();
        let width = n + flow.n_parameters();
        let mut all = Vec::with_capacity(self.segments.len());
        for (segment, x) in self.segments.iter().zip(x) {
            let mut errors = Array2::zeros((segment.len(), n));
            flow.each_step(Samples { segment, x, every: 1 }, xi, true, &mut |made| {
                let t = made.t;
                for i in 0..n {
                    let moved = |j: usize| made.s[i * width + j] - if i == j { 1.0 } else { 0.0 };
                    let through = (0..n).map(|j| (moved(j) * SMOOTHED * sigma[j]).powi(2)).sum::<f64>().sqrt();
                    errors[[t, i]] = if made.finite { through / segment.dt[t] } else { unknown((t, i), &segment.dt) };
                }
                true
            });
            all.push(errors);
        }
        all
    }
}
