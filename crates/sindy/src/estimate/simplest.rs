//! The simplest terms, by themselves.

use std::cell::Cell;

use super::hypothesis::{Hypothesis, Start};
use super::problem::Problem;
use super::regression::Regression;
use super::search::{FAR, measured};
use crate::data::Signals;
use crate::motion::Stepping;

/// Complexities of the terms that are tried by themselves, at most: states and inputs; products of two of them; cubes.
const TIERS: [u32; 3] = [3, 5, 6];

/// Operations for all of them, as a part of the budget of a search.
const SHARE: f64 = 0.3;

/// Terms of an equation that are fitted all at once, at most.
const AT_ONCE: usize = 16;

/// Multiple of what terms cost, when it is asked whether simpler ones explain signals nearly as well.
const DEAR: f64 = 16.0;

impl Problem<'_> {
    /// Equations of the simplest terms, if these explain the data: among many candidates errors of the path take some for others.
    pub(super) fn of_simplest(
        &self,
        signals: &Signals,
        explains: impl Fn(&Hypothesis) -> bool,
        stepping: Stepping,
    ) -> Option<Hypothesis> {
        self.of_tiers(&TIERS, signals, explains, stepping)
    }

    /// The same of terms about as simple as those of `begun`, which explained fewer data, maybe by chance.
    pub(super) fn as_simple_as(&self, begun: &Hypothesis, signals: &Signals) -> Option<Hypothesis> {
        let most = begun.supports.iter().flatten().map(|&j| self.terms[j].complexity).max()?;
        let at = TIERS.iter().position(|tier| *tier >= most)?;
        self.of_tiers(&TIERS[at..=at], signals, |found| self.is_settled(found), begun.flow.stepping())
    }

    fn of_tiers(
        &self,
        tiers: &[u32],
        signals: &Signals,
        explains: impl Fn(&Hypothesis) -> bool,
        stepping: Stepping,
    ) -> Option<Hypothesis> {
        // Where nothing is found the search finds what it would have found: it pays for what is.
        let spent = Cell::new(0);
        let problem = &Problem { budget: (SHARE * self.whole as f64) as u64, spent: &spent, ..*self };
        let along = |tier: &u32| problem.simple(*tier).propose(&measured(signals, stepping), &signals.sigma);
        let tiers: Vec<(u32, Vec<Regression>)> = tiers.iter().map(|tier| (*tier, along(tier))).collect();
        let scores: Vec<f64> = tiers.iter().map(|(_, proposed)| problem.dear(proposed)).collect();
        // What leaves far more of the signals needs no fit.
        let least = scores.iter().copied().fold(f64::INFINITY, f64::min);
        let near = tiers.into_iter().zip(scores).filter(|(_, score)| *score <= least + FAR).map(|(tier, _)| tier);
        let found = near.into_iter().find_map(|(tier, proposed)| {
            let few = problem.simple(tier);
            let all = few.of_all(signals, stepping).filter(&explains);
            let found = few.rounds(signals, proposed, None, stepping).filter(&explains);
            all.into_iter().chain(found).min_by(|a, b| a.score.total_cmp(&b.score))
        })?;
        self.charge(spent.get().min(problem.budget));
        Some(found)
    }

    /// The same with plain terms of this complexity alone, at most.
    fn simple(&self, most_complex: u32) -> Self {
        Self { most_complex, terms: &self.terms[..self.n_plain], ..*self }
    }

    /// The score of what regressions propose where terms are dear.
    fn dear(&self, proposed: &[Regression]) -> f64 {
        let fitted = proposed.iter().zip(self.rates).filter(|(_, rate)| rate.is_none());
        fitted.map(|(regression, _)| regression.best(DEAR, |support| self.penalty(support)).score).sum()
    }

    /// The best terms near those equations that have all there are, where these are few: where signals are alike, their errors mislead regressions along them, but not fits.
    fn of_all(&self, signals: &Signals, stepping: Stepping) -> Option<Hypothesis> {
        let own = |(i, rate): (usize, &Option<usize>)| if rate.is_none() { self.choice(i) } else { Vec::new() };
        let supports: Vec<Vec<usize>> = self.rates.iter().enumerate().map(own).collect();
        if supports.iter().any(|support| support.len() > AT_ONCE) {
            return None;
        }
        let xi = vec![0.0; supports.iter().map(Vec::len).sum()];
        let start = Start { xi: &xi, inside: &[], x: &signals.x, sigma: &signals.sigma };
        let loose = self.hypothesis(supports, stepping, start, 0..2)?;
        let all = self.hypothesis(loose.supports.clone(), loose.flow.stepping(), loose.start(), 2..4)?;
        let mut best = self.beside(&all);
        self.prune(&mut best);
        Some(best)
    }
}
