//! Exchanges of terms for others, and which of them the data do not tell apart.

use super::hypothesis::Hypothesis;
use super::propose::{Proposal, Regression};
use super::search::{Problem, Searched, TOLD_APART};

/// Passes of exchanges, at most.
const PASSES: usize = 4;

/// Difference of scores of regressions up to which other terms are tried for an equation, and how many of them.
pub(super) const NEAR: f64 = 12.0;
const RIVALS: usize = 16;

/// Difference of scores beyond which an exchange is not followed to its end.
const HOPELESS: f64 = 30.0;

/// Other terms of an equation that explain the data as well.
pub(super) type Rivals = Vec<Vec<usize>>;

/// `support` with the term `other` instead of `out`.
fn exchanged(support: &[usize], out: usize, other: usize) -> Vec<usize> {
    let mut support: Vec<usize> = support.iter().map(|&j| if j == out { other } else { j }).collect();
    support.sort_unstable();
    support
}

impl Problem<'_> {
    /// `best` with the terms of one equation at a time exchanged for others that explain nearly as much near it, as long as that
    /// improves the score. Also the regressions of the last pass and, per equation, the terms that
    /// explain the data as well.
    pub(super) fn exchanged(&self, mut best: Hypothesis) -> Searched {
        let (mut regressions, mut rivals, mut others) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..PASSES {
            regressions = self.propose_near(&best, &|i| self.most(&best, i));
            let loose = self.loosely(&best);
            rivals = vec![Rivals::new(); self.rates.len()];
            others.clear();
            let mut improved: Option<Hypothesis> = None;
            for (i, regression) in regressions.iter().enumerate() {
                let own = &best.supports[i];
                // Of terms that are the same on all data the simplest is meant.
                rivals[i] = regression.twins(own).into_iter().map(|(out, other)| exchanged(own, out, other)).collect();
                rivals[i].retain(|twin| self.penalty(twin) <= self.penalty(own));
                let mut proposals = regression.near_best(NEAR, RIVALS, |support| self.penalty(support));
                if let Some(loose) = &loose {
                    let more = loose[i].near_best(NEAR, RIVALS, |support| self.penalty(support));
                    let unlike = |p: &Proposal| proposals.iter().all(|other| other.support != p.support);
                    proposals.extend(more.into_iter().filter(unlike).collect::<Vec<_>>());
                }
                if !self.leaves_nothing(&best) && self.rates[i].is_none() && self.is_noise(&best, i) {
                    proposals.extend(self.propose_inside(&best, i));
                }
                for proposal in proposals {
                    let Some(rival) = self.exchange(&best, i, &proposal) else { continue };
                    if self.is_rival(&rival, &best, i) {
                        rivals[i].push(proposal.support.clone());
                        others.push(rival.clone());
                    }
                    if improved.as_ref().map_or(best.score, |h| h.score) > rival.score {
                        improved = Some(rival);
                    }
                }
            }
            match improved {
                Some(better) => best = better,
                None => break,
            }
        }
        for (i, regression) in regressions.iter().enumerate().filter(|_| !self.leaves_nothing(&best)) {
            if rivals[i].is_empty()
                && let Some(rival) = self.unlikely_rival(&best, i, regression)
            {
                rivals[i].push(rival.supports[i].clone());
                others.push(rival);
            }
        }
        Searched { best, regressions, rivals, others }
    }

    /// Regressions near `best` with states that follow the data more than its equations: how errors grow along a path other terms would change, and a
    /// linearisation does not tell. `None` where nothing is left, or a part of the samples was looked at so before.
    fn loosely(&self, best: &Hypothesis) -> Option<Vec<Regression>> {
        if self.leaves_nothing(best) || self.again {
            return None;
        }
        let loose = self.hypothesis(best.supports.clone(), best.flow.stepping(), best.start(), 1..2)?;
        Some(self.propose_near(&loose, &|_| usize::MAX))
    }

    /// Terms equation `i` may have at most in place of those of `best`: where nothing is left, more terms explain nothing, and no more terms may explain
    /// it as well.
    fn most(&self, best: &Hypothesis, i: usize) -> usize {
        if self.leaves_nothing(best) { best.supports[i].len() } else { usize::MAX }
    }

    /// `best` with the terms of `proposal` in equation `i`. `None` if they are the same or hopeless.
    fn exchange(&self, best: &Hypothesis, i: usize, proposal: &Proposal) -> Option<Hypothesis> {
        if self.are_alike(&proposal.support, &best.supports[i]) || proposal.support.len() > self.most(best, i) {
            return None;
        }
        // With states that need not quite follow the equations less is left, so that this score is no worse.
        let hopeful = self.with_equation(best, i, proposal, 2..3).filter(|h| h.score < best.score + HOPELESS)?;
        self.hypothesis(hopeful.supports.clone(), hopeful.flow.stepping(), hopeful.start(), 3..4)
    }

    /// Other terms of equation `i` that nobody would think of first, but that explain the data as well as those of `best`.
    fn unlikely_rival(&self, best: &Hypothesis, i: usize, regression: &Regression) -> Option<Hypothesis> {
        let told = |support: &[usize]| self.penalty(support) - self.prior(support);
        let mut proposals = regression.near_best(NEAR, RIVALS, told);
        proposals.retain(|p| self.n_parameters(&p.support) <= self.n_parameters(&best.supports[i]));
        proposals.iter().find_map(|p| self.exchange(best, i, p).filter(|rival| self.is_rival(rival, best, i)))
    }

    /// Whether the data do not tell `rival`, with other terms in equation `i`, from `best`. What was believed of the terms before tells it from no rival with
    /// as few parameters.
    fn is_rival(&self, rival: &Hypothesis, best: &Hypothesis, i: usize) -> bool {
        let (own, other) = (&best.supports[i], &rival.supports[i]);
        let as_few = self.n_parameters(other) <= self.n_parameters(own);
        let believed = |hypothesis: &Hypothesis, support| self.prior(support) + hypothesis.size;
        let before = if as_few { (believed(rival, other) - believed(best, own)).max(0.0) } else { 0.0 };
        rival.score - before < best.score + TOLD_APART
    }
}
