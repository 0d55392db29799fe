//! Simple terms and quotients by one variable in each equation, by themselves: among all terms at once errors of the path take some for others.

use super::constraints::Constraints;
use super::hypothesis::{Hypothesis, Start};
use super::problem::{Alone, Problem, Separate};
use super::propose::{DEAR, Effort, ROUGHLY, THOROUGHLY};
use super::regression::Regression;
use super::search::measured;
use crate::data::Signals;
use crate::library::{Term, divisor};
use crate::motion::Stepping;

/// Plain terms, and quotients by one variable in each equation.
pub(super) struct Quotients {
    /// The terms, as places among those of the problem: first those without a variable below.
    chosen: Vec<usize>,
    constraints: Vec<Constraints>,
    proposed: Vec<Regression>,
    /// That of what regressions propose where terms are dear.
    pub(super) score: f64,
}

/// Quotients in one equation.
struct Divided {
    by: usize,
    score: f64,
    /// Whether regressions propose any.
    divides: bool,
    regression: Regression,
}

impl Problem<'_> {
    /// Plain terms of complexity `most_complex`, at most, and for each equation the quotients by the variable of which they leave least along the measured path.
    /// `None` if regressions propose no quotient.
    pub(super) fn propose_quotients(
        &self,
        signals: &Signals,
        most_complex: u32,
        stepping: Stepping,
    ) -> Option<Quotients> {
        if self.quotients().is_empty() || self.constraints.iter().any(|c| !c.is_empty()) {
            return None;
        }
        let is_simple = |j: &usize| self.terms[*j].complexity <= most_complex;
        let plain: Vec<usize> = (0..self.n_plain).filter(is_simple).collect();
        let chosen: Vec<usize> = plain.iter().copied().chain(self.quotients()).collect();
        let (terms, alone) = self.among(&chosen);
        let problem = Problem { terms: &terms, n_plain: terms.len(), constraints: &[], alone: &alone, ..*self };
        let best = problem.best_divisors(plain.len(), signals, stepping)?;
        let others = |by: usize| (plain.len()..terms.len()).filter(|&j| divisor(&terms[j]) != Some(by)).collect();
        let constraints =
            best.iter().map(|b| Constraints { forbidden: others(b.by), ..Constraints::default() }).collect();
        let score = best.iter().map(|b| b.score).sum();
        Some(Quotients { chosen, constraints, proposed: best.into_iter().map(|b| b.regression).collect(), score })
    }

    /// Equations of terms that were proposed.
    pub(super) fn of_quotients(&self, among: Quotients, signals: &Signals, stepping: Stepping) -> Option<Hypothesis> {
        let Quotients { chosen, constraints, proposed, .. } = among;
        let (terms, alone) = self.among(&chosen);
        let problem = Problem {
            terms: &terms,
            n_plain: terms.len(),
            of_parts: None,
            mechanics: &[],
            constraints: &constraints,
            alone: &alone,
            ..*self
        };
        let found = problem.rounds(signals, proposed, None, stepping)?;
        let supports = found.supports.iter().map(|s| s.iter().map(|&c| chosen[c]).collect()).collect();
        let start = Start { inside: &[], ..found.start() };
        self.hypothesis(supports, found.flow.stepping(), start, 2..4)
    }

    /// The terms `chosen`, and what was found alone in places among them.
    fn among(&self, chosen: &[usize]) -> (Vec<Term>, Vec<Alone>) {
        let told = |alone: &Alone| -> Alone {
            let known = alone.as_ref()?;
            let place = |j: &usize| chosen.iter().position(|k| k == j);
            Some(Separate { support: known.support.iter().map(place).collect::<Option<_>>()?, ..known.clone() })
        };
        (chosen.iter().map(|&j| self.terms[j].clone()).collect(), self.alone.iter().map(told).collect())
    }

    /// Per equation: the variable of which quotients leave least along the measured path, beside the first `n_plain` terms. `None` if no equation has one.
    fn best_divisors(&self, n_plain: usize, signals: &Signals, stepping: Stepping) -> Option<Vec<Divided>> {
        let mut divisors: Vec<usize> = self.terms[n_plain..].iter().filter_map(divisor).collect();
        divisors.dedup();
        let theta = self.averaged(self.terms, &measured(signals, stepping));
        let errors = self.errors(&signals.sigma, None);
        let of = |i: usize, by: usize, effort: Effort| {
            let may = |j: &usize| *j < n_plain || divisor(&self.terms[*j]) == Some(by);
            let choice = self.choice(i).into_iter().filter(may).collect();
            let regression = self.regression(&theta, i, choice, (&signals.sigma, &errors), (usize::MAX, effort));
            let best = regression.best(DEAR, |support| self.penalty(support));
            let divides = best.support.iter().any(|&j| j >= n_plain);
            Divided { by, score: best.score, divides, regression }
        };
        let best = |i: usize| {
            let all = divisors.iter().filter(|_| self.rates[i].is_none()).map(|&by| of(i, by, ROUGHLY));
            let least = all.min_by(|a, b| a.score.total_cmp(&b.score)).map(|least| of(i, least.by, THOROUGHLY));
            least.unwrap_or(Divided { by: usize::MAX, score: 0.0, divides: false, regression: Regression::none() })
        };
        let all: Vec<Divided> = (0..self.rates.len()).map(best).collect();
        all.iter().any(|b| b.divides).then_some(all)
    }

    /// The quotients by the variables that terms of `support` are divided by.
    pub(super) fn quotients_like(&self, support: &[usize]) -> impl Iterator<Item = usize> {
        let is_quotient = |j: &usize| self.quotients().contains(j);
        let mut by: Vec<usize> =
            support.iter().filter(|j| is_quotient(j)).filter_map(|&j| divisor(&self.terms[j])).collect();
        by.dedup();
        self.quotients().filter(move |&j| divisor(&self.terms[j]).is_some_and(|d| by.contains(&d)))
    }
}
