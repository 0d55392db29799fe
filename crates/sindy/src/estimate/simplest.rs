//! The simplest terms, by themselves.

use std::cell::Cell;

use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::propose::DEAR;
use super::regression::Regression;
use super::search::{FAR, measured};
use crate::data::Signals;
use crate::motion::Stepping;

/// Complexities of the terms that are tried by themselves, at most: states and inputs; products of two of them; cubes.
const TIERS: [u32; 3] = [3, 5, 6];

/// Operations for all of them, as a part of the budget of a search.
const SHARE: f64 = 0.3;

impl Problem<'_> {
    /// Equations of the simplest terms, if these explain the data: among many candidates errors of the path take some for others.
    pub(super) fn of_simplest(
        &self,
        signals: &Signals,
        explains: impl Fn(&Hypothesis) -> bool,
        stepping: Stepping,
    ) -> Option<Hypothesis> {
        // Where nothing is found the search finds what it would have found: it pays for what is.
        let spent = Cell::new(0);
        let problem = &Problem { budget: (SHARE * self.whole as f64) as u64, spent: &spent, ..*self };
        let along = |tier: &u32| problem.simple(*tier).propose(&measured(signals, stepping), &signals.sigma);
        let tiers: Vec<(u32, Vec<Regression>)> = TIERS.iter().map(|tier| (*tier, along(tier))).collect();
        let scores: Vec<f64> = tiers.iter().map(|(_, proposed)| problem.dear(proposed)).collect();
        // What leaves far more of the signals needs no fit.
        let least = scores.iter().copied().fold(f64::INFINITY, f64::min);
        let near = tiers.into_iter().zip(scores).filter(|(_, score)| *score <= least + FAR).map(|(tier, _)| tier);
        let found = near.into_iter().find_map(|(tier, proposed)| {
            let few = problem.simple(tier);
            few.rounds(signals, proposed, None, stepping).filter(&explains)
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
}
