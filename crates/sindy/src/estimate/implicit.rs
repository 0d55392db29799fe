//! Equations with terms that multiply their own derivative.

use super::constraints::Constraints;
use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::regression::{Proposal, Regression};
use super::rounds::ROUNDS;
use super::search::{FAR, TIMES, followed, measured};
use crate::data::Signals;

/// Factors of an own derivative that are tried at each price of a term.
const FACTORS: usize = 3;

/// Multiple of the smallest residual of all proposals beyond which one is not tried.
const HOPELESS: f64 = 4.0;

impl Problem<'_> {
    /// Tries, for each equation, terms that multiply its own derivative: of ratios such as x/(1 + x) they make sums, and of the
    /// inertia of joints. Whether one was taken.
    pub(super) fn implicit(&self, best: &mut Hypothesis, signals: &Signals) -> bool {
        let mut taken = false;
        // Multiplied by anything, an equation would be another than the one that is known something of.
        let free = |i: &usize| self.rates[*i].is_none() && self.constraints.get(*i).is_none_or(Constraints::is_empty);
        for i in (0..self.rates.len()).filter(free) {
            let mut tried: Vec<Vec<usize>> = vec![best.supports[i].clone()];
            for round in 0..ROUNDS {
                if self.leaves_nothing(best) || !self.may_spend() {
                    return taken;
                }
                // Of an equation that leaves noise alone only a shorter one is better.
                let noise = self.is_noise(best, i);
                let most = if noise { best.supports[i].len().saturating_sub(1) } else { usize::MAX };
                let symmetric = self.symmetric(i, &best.supports);
                let mut proposals = self.implicit_proposals(i, best, (&symmetric, most));
                if round == 0 {
                    let path = measured(signals, best.flow.stepping());
                    let regressions = self.propose_implicit(i, &path, &signals.sigma, None, (&symmetric, most));
                    proposals.extend(self.most_promising(&regressions));
                }
                let mut better = self.best_of(proposals, best, i, &mut tried);
                let all = self.choice(i);
                if better.is_none() && all.len() > symmetric.len() {
                    better = self.best_of(self.implicit_proposals(i, best, (&all, most)), best, i, &mut tried);
                }
                let Some(better) = better else { break };
                *best = better;
                taken = true;
            }
        }
        taken
    }

    /// The best of `proposals` for equation `i` that were not `tried` before, if its score is better than that of `base`.
    pub(super) fn best_of(
        &self,
        proposals: Vec<Proposal>,
        base: &Hypothesis,
        i: usize,
        tried: &mut Vec<Vec<usize>>,
    ) -> Option<Hypothesis> {
        let mut better: Option<Hypothesis> = None;
        for proposal in proposals {
            if tried.contains(&proposal.support) {
                continue;
            }
            tried.push(proposal.support.clone());
            let loose = self.with_equation(base, i, &proposal, 0..2).filter(|l| l.score <= base.score + FAR);
            let Some(loose) = loose else { continue };
            let strict = self.hypothesis(loose.supports.clone(), loose.flow.stepping(), loose.start(), 2..4);
            let bar = better.as_ref().map_or(base.score, |h| h.score);
            better = strict.filter(|h| h.score < bar).or(better);
            if better.as_ref().is_some_and(|h| self.leaves_nothing(h)) {
                break;
            }
        }
        better
    }

    /// Proposals for equation `i` with at most `most` terms, one of which multiplies its own derivative, along the path of `best`.
    fn implicit_proposals(&self, i: usize, best: &Hypothesis, among: (&[usize], usize)) -> Vec<Proposal> {
        let (flow, fit) = (&best.flow, &best.fit);
        let path = followed(best);
        self.most_promising(&self.propose_implicit(i, &path, &fit.sigma, Some((flow, &fit.xi, &fit.x)), among))
    }

    /// The best of each of the [`FACTORS`] best `regressions`, at each price of a term.
    fn most_promising(&self, regressions: &[Regression]) -> Vec<Proposal> {
        let proposals = TIMES.iter().flat_map(|times| {
            let best = regressions.iter().map(|r| r.best(*times, |support| self.penalty(support)));
            let mut best: Vec<Proposal> = best.collect();
            best.sort_by(|a, b| a.score.total_cmp(&b.score));
            best.truncate(FACTORS);
            best
        });
        let mut proposals: Vec<Proposal> = proposals.collect();
        let least = proposals.iter().map(|p| p.residual).fold(f64::INFINITY, f64::min);
        proposals.retain(|p| p.residual <= HOPELESS * least);
        proposals
    }
}
