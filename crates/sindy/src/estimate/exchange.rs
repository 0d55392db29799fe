//! Exchanges of terms for others, and which of them the data do not tell apart.

use super::hypothesis::{Hypothesis, TOLD_APART};
use super::problem::Problem;
use super::regression::{Proposal, Regression};
use super::searched::{Rivals, Searched};

/// Passes of exchanges, at most.
const PASSES: usize = 4;

/// Difference of scores of regressions up to which other terms are tried for an equation, and how many of them.
pub(super) const NEAR: f64 = 12.0;
const RIVALS: usize = 16;

/// Difference of scores beyond which an exchange is not followed to its end.
const HOPELESS: f64 = 30.0;

/// `support` with the term `other` instead of `out`.
fn exchanged(support: &[usize], out: usize, other: usize) -> Vec<usize> {
    let mut support: Vec<usize> = support.iter().map(|&j| if j == out { other } else { j }).collect();
    support.sort_unstable();
    support
}

/// What is found near a hypothesis.
struct Near {
    regressions: Vec<Regression>,
    /// Per equation, other terms that explain the data as well.
    rivals: Vec<Rivals>,
    /// Hypotheses with these.
    others: Vec<Hypothesis>,
    /// The best hypothesis of all, if it is another.
    improved: Option<Hypothesis>,
    /// Per equation, whether all that was to be tried was.
    finished: Vec<bool>,
}

impl Near {
    /// Notes in `compared`, per equation, the terms of `best` that were compared with all others, and those that explain the data as well.
    fn note(&self, best: &Hypothesis, compared: &mut [Option<(Vec<usize>, Rivals)>]) {
        for (i, slot) in compared.iter_mut().enumerate().filter(|(i, _)| self.finished[*i]) {
            *slot = Some((best.supports[i].clone(), self.rivals[i].clone()));
        }
    }
}

impl Problem<'_> {
    /// `best` with the terms of one equation at a time exchanged for others that explain nearly as much near it, as long as that
    /// improves the score. Of terms that the data do not tell apart the simplest are meant. Also the regressions of the last pass and, per equation,
    /// the terms that explain the data as well.
    ///
    /// Where a part of the samples was searched `before`, and found the same terms, those that explained the data as well there are fitted to all samples.
    pub(super) fn exchanged(&self, mut best: Hypothesis, before: Option<&Searched>) -> Searched {
        let compared = before.filter(|before| before.best.supports == best.supports && self.is_settled(&best));
        if let Some(before) = compared {
            return self.confirmed(best, before);
        }
        let mut near = self.near(&best, &|_| true);
        let mut compared = vec![None; self.rates.len()];
        near.note(&best, &mut compared);
        for _ in 1..PASSES {
            let Some(better) = near.improved.take() else { break };
            best = better;
            near = self.near(&best, &|_| true);
            near.note(&best, &mut compared);
        }
        let likeliest = best.clone();
        for _ in 0..PASSES {
            let Some(simpler) = self.simpler(&best, &near.others, likeliest.score) else { break };
            best = simpler;
            near = self.near(&best, &|_| true);
            near.note(&best, &mut compared);
        }
        // Where the operations ended in the last pass, what an earlier one told of the same terms counts.
        let mut finished = vec![false; self.rates.len()];
        for (i, (own, seen)) in compared.into_iter().enumerate().filter_map(|(i, c)| Some((i, c?))) {
            finished[i] = own == best.supports[i];
            let more = seen.into_iter().filter(|_| own == best.supports[i]);
            let more: Rivals = more.filter(|rival| !near.rivals[i].contains(rival)).collect();
            near.rivals[i].extend(more);
        }
        // An equation that is settled is compared with others even if the operations went into one that is not.
        let settled: Vec<bool> = (0..finished.len()).map(|i| !finished[i] && self.is_noise(&best, i)).collect();
        if settled.contains(&true) {
            let more = self.with_reserve(|problem| problem.near(&best, &|i| settled[i]));
            for i in (0..finished.len()).filter(|&i| settled[i]) {
                let new: Rivals = more.rivals[i].iter().filter(|r| !near.rivals[i].contains(r)).cloned().collect();
                near.rivals[i].extend(new);
                finished[i] = more.finished[i];
            }
            near.others.extend(more.others);
        }
        for (i, rivals) in near.rivals.iter_mut().enumerate() {
            let own = &likeliest.supports[i];
            if *own != best.supports[i] && !rivals.contains(own) {
                rivals.push(own.clone());
            }
        }
        if likeliest.supports != best.supports {
            near.others.push(likeliest);
        }
        let Near { regressions, mut rivals, mut others, .. } = near;
        for (i, regression) in regressions.iter().enumerate().filter(|_| !self.leaves_nothing(&best)) {
            if rivals[i].is_empty()
                && let Some(rival) = self.unlikely_rival(&best, i, regression)
            {
                rivals[i].push(rival.supports[i].clone());
                others.push(rival);
            }
        }
        Searched { best, regressions, rivals, others, finished }
    }

    /// `best`, which has the terms of what was found `before` in a part of the samples, with those of the equally good terms there that are so in all samples.
    fn confirmed(&self, best: Hypothesis, before: &Searched) -> Searched {
        let mut others = Vec::new();
        let mut is_left = |i: usize, rival: &Vec<usize>| {
            let Some(like) = before.others.iter().find(|other| other.supports[i] == *rival) else { return true };
            let found = self.with_reserve(|problem| problem.exchange(&best, i, &like.equation(i)));
            let found = found.filter(|found| self.is_rival(found, &best, i));
            others.extend(found.clone());
            found.is_some()
        };
        let rivals = before.rivals.iter().enumerate();
        let rivals = rivals.map(|(i, all)| all.iter().filter(|rival| is_left(i, rival)).cloned().collect()).collect();
        let Searched { regressions, finished, .. } = before;
        Searched { best, regressions: regressions.clone(), rivals, others, finished: finished.clone() }
    }

    /// What other terms in one of the equations `of` come to.
    fn near(&self, best: &Hypothesis, of: &dyn Fn(usize) -> bool) -> Near {
        let regressions = self.propose_near(best, &|i| self.most(best, i));
        let loose = self.loosely(best);
        let mut rivals = vec![Rivals::new(); self.rates.len()];
        let mut others = Vec::new();
        let mut finished = Vec::with_capacity(self.rates.len());
        let mut improved: Option<Hypothesis> = None;
        for (i, regression) in regressions.iter().enumerate() {
            if !of(i) {
                finished.push(false);
                continue;
            }
            let own = &best.supports[i];
            // Of terms that are the same on all data the simplest is meant.
            rivals[i] = regression.twins(own).into_iter().map(|(out, other)| exchanged(own, out, other)).collect();
            rivals[i].retain(|twin| self.penalty(twin) <= self.penalty(own));
            let mut proposals = regression.near_best(NEAR, RIVALS, |support| self.penalty(support));
            let mut propose = |more: Vec<Proposal>| {
                let unlike = |p: &Proposal| proposals.iter().all(|other| other.support != p.support);
                let more: Vec<Proposal> = more.into_iter().filter(unlike).collect();
                proposals.extend(more);
            };
            if let Some(loose) = &loose {
                propose(loose[i].near_best(NEAR, RIVALS, |support| self.penalty(support)));
            }
            if !self.leaves_nothing(best) {
                let complexity = |j: usize| self.terms[j].complexity;
                let (simpler, work) =
                    regression.simpler(own, (NEAR, RIVALS), |support| self.penalty(support), complexity);
                self.charge(work);
                propose(simpler);
                let is_inside = |j: usize| self.terms.get(j).is_some_and(|t| t.shape.is_some());
                let (pairs, work) =
                    regression.in_place_of_one(own, (NEAR, RIVALS), |support| self.penalty(support), is_inside);
                self.charge(work);
                propose(pairs);
            }
            if !self.leaves_nothing(best) && self.rates[i].is_none() && self.is_noise(best, i) {
                proposals.extend(self.propose_inside(best, i));
                proposals.extend(self.instead(best, i));
            }
            // Terms that are the same on all data, and no simpler, were compared above.
            let is_new =
                |p: &Proposal| !regression.are_twins(own, &p.support) || self.penalty(&p.support) < self.penalty(own);
            for proposal in proposals.into_iter().filter(is_new) {
                let Some(rival) = self.exchange(best, i, &proposal) else { continue };
                if self.is_rival(&rival, best, i) {
                    rivals[i].push(proposal.support.clone());
                    others.push(rival.clone());
                }
                if improved.as_ref().map_or(best.score, |h| h.score) > rival.score {
                    improved = Some(rival);
                }
            }
            let has_others = self.rates[i].is_none() && !self.choice(i).is_empty();
            let is_compared = !has_others || !regression.choice.is_empty();
            finished.push(is_compared && self.spent.get() <= self.budget);
        }
        Near { regressions, rivals, others, improved, finished }
    }

    /// `best` with the simplest terms of as many parameters in every equation, of those in `others` that the data do not tell from the likeliest, whose
    /// score is `likeliest`. `None` if these are its own.
    fn simpler(&self, best: &Hypothesis, others: &[Hypothesis], likeliest: f64) -> Option<Hypothesis> {
        let is_as_likely = |h: &Hypothesis| h.score < likeliest + TOLD_APART;
        let mut simplest: Option<Hypothesis> = None;
        for (i, own) in best.supports.iter().enumerate() {
            let is_simpler = |h: &&Hypothesis| {
                let other = &h.supports[i];
                let as_many = self.n_parameters(other) == self.n_parameters(own);
                as_many && self.prior(other) < self.prior(own) && is_as_likely(h)
            };
            let simpler = others.iter().filter(is_simpler);
            let believed = |h: &&Hypothesis| self.prior(&h.supports[i]);
            let Some(simpler) = simpler.min_by(|a, b| believed(a).total_cmp(&believed(b))) else { continue };
            simplest = match simplest {
                None => Some(simpler.clone()),
                Some(begun) => {
                    let both = self.with_equation(&begun, i, &simpler.equation(i), 3..4);
                    both.filter(is_as_likely).or(Some(begun))
                }
            };
        }
        simplest
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
        let own = &best.supports[i];
        proposals.retain(|p| self.n_parameters(&p.support) <= self.n_parameters(own));
        proposals.retain(|p| !regression.are_twins(own, &p.support));
        proposals.iter().find_map(|p| self.exchange(best, i, p).filter(|rival| self.is_rival(rival, best, i)))
    }

    /// Whether the data do not tell `rival`, with other terms in equation `i` that say something else of the system, from `best`. What was believed of the terms before tells it from no rival with
    /// as few parameters.
    fn is_rival(&self, rival: &Hypothesis, best: &Hypothesis, i: usize) -> bool {
        let (own, other) = (&best.supports[i], &rival.supports[i]);
        if self.are_the_same_by_substitution(other, &best.supports, i) {
            return false;
        }
        let as_few = self.n_parameters(other) <= self.n_parameters(own);
        let believed = |hypothesis: &Hypothesis, support| self.prior(support) + hypothesis.size;
        let before = if as_few { (believed(rival, other) - believed(best, own)).max(0.0) } else { 0.0 };
        rival.score - before < best.score + TOLD_APART
    }
}
