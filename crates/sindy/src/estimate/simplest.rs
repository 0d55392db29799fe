//! The simplest terms, by themselves.

use std::cell::Cell;

use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::propose::DEAR;
use super::quotients::Quotients;
use super::regression::Regression;
use super::search::{FAR, measured};
use crate::data::Signals;
use crate::motion::Stepping;

/// Complexities of the terms that are tried by themselves, at most: states and inputs; products of two of them; cubes.
const TIERS: [u32; 3] = [3, 5, 6];

/// Operations for all of them, as a part of the budget of a search.
const SHARE: f64 = 0.3;

/// The part of that for regressions along the measured path.
const OF_PROPOSALS: f64 = 0.15;

/// Terms that are tried by themselves.
enum Few {
    /// Those of this complexity, at most, and what regressions propose of them.
    Plain(u32, Vec<Regression>),
    Quotients(Quotients),
}

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
        let all = problem.with_share(OF_PROPOSALS, |problem| problem.few(signals, stepping));
        // What leaves far more of the signals needs no fit.
        let least = all.iter().map(|(score, _)| *score).fold(f64::INFINITY, f64::min);
        let found = |few: Few| match few {
            Few::Plain(tier, proposed) => problem.simple(tier).rounds(signals, proposed, None, stepping),
            Few::Quotients(among) => problem.of_quotients(among, signals, stepping),
        };
        let near = all.into_iter().filter(|(score, _)| *score <= least + FAR).map(|(_, few)| few);
        let found = near.filter_map(found).find(&explains)?;
        self.charge(spent.get().min(problem.budget));
        Some(found)
    }

    /// What regressions propose of few terms, with their scores where terms are dear.
    fn few(&self, signals: &Signals, stepping: Stepping) -> Vec<(f64, Few)> {
        let plain = TIERS.into_iter().map(|tier| {
            let proposed = self.simple(tier).propose(&measured(signals, stepping), &signals.sigma);
            (self.dear(&proposed), Few::Plain(tier, proposed))
        });
        let quotients = TIERS.into_iter().filter_map(|tier| self.propose_quotients(signals, tier, stepping));
        plain.chain(quotients.map(|q| (q.score, Few::Quotients(q)))).collect()
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
