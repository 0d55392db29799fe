//! Regressions linearised at a trajectory: which other terms each equation may have.

use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::propose::THOROUGHLY;
use super::regression::Regression;
use crate::Triangle;
use crate::design::{Path, averages};
use crate::expr::Expr;
use crate::library::Term;
use crate::shooting::{Flow, linearised};

impl Problem<'_> {
    /// The best terms of every equation near `along`, at most `most(i)` in equation i: as all samples tell them, to first order, with all
    /// states and the coefficients of the other equations free.
    ///
    /// # References
    /// Rao (1948), Proc. Camb. Phil. Soc. 44: score tests of terms with no coefficient yet.
    pub(super) fn propose_near(&self, along: &Hypothesis, most: &dyn Fn(usize) -> usize) -> Vec<Regression> {
        let regression = |i: usize| match self.rates[i] {
            Some(_) => None,
            None => self.regression_near(along, i, most(i)),
        };
        (0..self.rates.len()).map(|i| regression(i).unwrap_or_else(Regression::none)).collect()
    }

    pub(super) fn regression_near(&self, along: &Hypothesis, i: usize, most: usize) -> Option<Regression> {
        let own = along.supports[i].iter().any(|&j| self.terms[j].rate == Some(i));
        let mut choice = if own { self.symmetric(i, &along.supports) } else { self.choice(i) };
        choice.extend(self.quotients_like(&along.supports[i]));
        choice.extend(along.supports[i].iter().filter(|j| !choice.contains(j)).copied().collect::<Vec<_>>());
        let triangle = self.triangle_near(self.terms, along, i, &choice)?;
        Some(self.subsets(i, (triangle, self.least_near(along)), choice, None, (most, THOROUGHLY)))
    }

    /// The smallest mean square of what rows near `along` leave that is believed.
    pub(super) fn least_near(&self, along: &Hypothesis) -> f64 {
        self.least(0..=self.rates.len() - 1, &along.fit.sigma)
    }

    /// The triangle of the terms `choice` of equation `i`, of `terms`, which begin with those of the problem, and what they should explain;
    /// everything else is free.
    pub(super) fn triangle_near(
        &self,
        terms: &[Term],
        along: &Hypothesis,
        i: usize,
        choice: &[usize],
    ) -> Option<Triangle> {
        let mut supports = along.supports.clone();
        supports[i] = choice.to_vec();
        let free = self.free(&along.supports);
        let structure = (&supports[..], &self.given()[..], &free[..]);
        // Kinks of candidates are found one by one once they are fitted.
        let acts = |j: usize| along.supports.iter().flatten().any(|&k| k == j);
        let trying =
            |terms: &[Term]| Flow::trying(terms, structure, self.rates, self.n_controls, along.flow.stepping(), &acts);
        let first: usize = supports[..i].iter().map(Vec::len).sum();
        let fit = &along.fit;
        let coefficient =
            |j: usize| along.supports[i].iter().position(|k| *k == j).map_or(0.0, |at| fit.xi[first + at]);
        let now: Vec<f64> = choice.iter().map(|&j| coefficient(j)).collect();
        let (before, after) = (&fit.xi[..first], &fit.xi[first + along.supports[i].len()..]);
        let xi = [before, &now, after].concat();
        let linearised_with = |flow: &Flow| {
            self.working(|work| {
                let go_on = self.watch.asks();
                linearised(flow, self.segments, (&xi, &fit.x), &fit.sigma, along.part, (work, go_on))
            })
        };
        let defined = || self.watch.go_on().then(|| self.without_undefined(terms, along, choice)).flatten();
        let all = linearised_with(&trying(terms)).or_else(|| linearised_with(&trying(&defined()?)))?;
        // The other equations first, so that what they explain can be taken out; then the terms, and coefficients instead of changes.
        let (others, terms) = (before.len() + after.len(), first..first + choice.len());
        let alone = |c: usize| vec![(c, 1.0)];
        let mut columns: Vec<Vec<(usize, f64)>> = (0..xi.len()).filter(|c| !terms.contains(c)).map(alone).collect();
        columns.extend(terms.clone().map(alone));
        columns.push(terms.zip(now).chain([(xi.len(), 1.0)]).collect());
        Some(all.combined(&columns).trailing(others))
    }

    /// `terms` with zero for those of `choice` that are not finite, or have no finite slope, somewhere on the way of `along`: a root or a logarithm of what noise
    /// alone keeps positive. `None` if all are.
    fn without_undefined(&self, terms: &[Term], along: &Hypothesis, choice: &[usize]) -> Option<Vec<Term>> {
        let acts = |j: &usize| along.supports.iter().flatten().any(|k| k == j);
        let mut told: Vec<(usize, Term)> = Vec::new();
        for &j in choice.iter().filter(|j| !acts(j)) {
            let of = |expr: Expr, rate| Term { expr, rate, shape: None, ..terms[j].clone() };
            told.push((j, of(terms[j].expr.clone(), terms[j].rate)));
            let slopes = (0..self.rates.len()).filter_map(|state| terms[j].expr.derivative(state));
            told.extend(slopes.map(|slope| (j, of(slope, None))));
        }
        let (of, told): (Vec<usize>, Vec<Term>) = told.into_iter().unzip();
        let path = Path::Model { flow: &along.flow, xi: &along.fit.xi, x: &along.fit.x };
        let mut terms = terms.to_vec();
        let mut undefined = false;
        for (at, segment) in self.segments.iter().enumerate() {
            let averages = averages(&told, segment, at, &path);
            for (column, &j) in averages.columns().into_iter().zip(&of) {
                if column.iter().any(|v| !v.is_finite()) {
                    terms[j].expr = Expr::Constant(0.0);
                    undefined = true;
                }
            }
        }
        undefined.then_some(terms)
    }
}
