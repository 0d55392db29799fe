//! From proposals to the hypothesis with the best score.

use std::cell::Cell;

use ndarray::Array2;

use super::account::Estimate;
use super::hypothesis::{FLOOR, Hypothesis, Start};
use super::problem::{OfPart, Problem};
use super::regression::Proposal;
use super::searched::{Rough, Searched};
use super::strays::{Kept, Rejecting};
use super::white::is_white;
use crate::data::{Segment, Signals, Smoother, sample_of, with_variances, without_glitches};
use crate::design::Path;
use crate::motion::Stepping;
use crate::shooting::Given;

/// Difference of scores beyond which equations that leave states free to follow the data are not tried in earnest.
pub(super) const FAR: f64 = 100.0;

/// Parts of a channel's spread that samples are taken to be wrong by, where equations are looked for first.
const ROUGH: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Part of a channel's spread below which nothing is left to explain.
const NOTHING: f64 = 1e-9;

/// The equations with the best score.
pub(crate) fn estimate(problem: &Problem<'_>, stepping: Stepping) -> Option<Estimate> {
    let floor: Vec<f64> = (0..problem.rates.len()).map(|i| problem.floor[i].max(NOTHING * problem.spread(i))).collect();
    // Before anything is known of the equations the largest errors of sensors tell nothing but how wrong these may be.
    let (segments, glitches) = without_glitches(problem.segments, &floor).unwrap_or((problem.segments.to_vec(), 0));
    let problem = &Problem { floor: &floor, segments: &segments, ..*problem };
    let found = problem.as_stepped(estimated(problem, stepping)?);
    Some(Estimate { astray: found.astray + glitches, ..found })
}

/// The equations with the terms of `problem.of_parts` and what is better near them, if they leave noise alone.
pub(crate) fn completed(problem: &Problem<'_>, stepping: Stepping) -> Option<Estimate> {
    let signals = problem.smoother().signals(problem.floor);
    let with_noise = Problem { noise: &signals.sigma, ..*problem };
    let begun = with_noise.proposed_by_parts(&signals, stepping).filter(|found| with_noise.is_settled(found))?;
    let found = accounted(&Problem { again: true, ..*problem }, (Some(begun), None), stepping)?.found;
    Some(problem.as_stepped(found))
}

/// The equations with the best score, of noise that may grow with the value.
pub(super) fn estimated(problem: &Problem<'_>, stepping: Stepping) -> Option<Estimate> {
    let mut all = searched(problem, stepping)?;
    // One equation that no terms can say spoils the others.
    if all.found.doubts.iter().flatten().any(|doubt| doubt.is_spoilt()) {
        let alone = problem.alone(stepping);
        if !alone.is_empty() {
            let spent = Cell::new(problem.budget / 4 * 3);
            let again = searched(&Problem { alone: &alone, spent: &spent, ..*problem }, stepping);
            all = again.filter(|again| again.found.score < all.found.score).unwrap_or(all);
            all.found.with_separate(&alone);
        }
    }
    let Accounted { best, found, kept } = all;
    if found.leaves_nothing || !problem.watch.go_on() {
        return Some(found);
    }
    // Noise that grows with the value shows in what the equations leave; whether it is believed the score decides.
    let (weighted, shares) = with_variances(&kept.segments, &found.path);
    if shares.iter().all(|s| *s == 0.0) {
        return Some(found);
    }
    // The search goes on from what was found; samples that count differently may tell other terms.
    let problem = &Problem { segments: &weighted, ..*problem };
    let paid = weighted.iter().map(Segment::log_variances).sum::<f64>();
    let signals = problem.smoother().signals(problem.floor);
    let begun = Problem { noise: &signals.sigma, ..*problem }.fitted(&best, &signals);
    let begun = begun.filter(|begun| begun.score + paid < best.score);
    let growing = begun.and_then(|begun| accounted(problem, (Some(begun), None), stepping));
    let growing = growing.filter(|g| g.found.score + kept.price + paid < found.score);
    let with_shares = |g: Accounted| {
        let score = g.found.score + kept.price + paid;
        Estimate { growing: shares, astray: kept.astray + g.found.astray, score, ..g.found }
    };
    Some(growing.map_or(found, with_shares))
}

/// What a search found, told in full, and the data without strays that it is fitted to.
pub(super) struct Accounted {
    best: Hypothesis,
    pub(super) found: Estimate,
    kept: Kept,
}

/// The equations with the best score, and the data without strays that they are fitted to. Where there are many samples, terms are looked for in a part
/// of these, where there are very many then in a larger one, and judged with all of them. `None` if something else explains the data better than what was found in that.
fn searched(problem: &Problem<'_>, stepping: Stepping) -> Option<Accounted> {
    if !problem.is_long() {
        return accounted(problem, (None, None), stepping);
    }
    let (mut part, mut complete) = in_part(problem, (SAMPLE, IN_SAMPLE), None, stepping);
    let is_very_long = problem.samples() > 2.0 * LARGER_SAMPLE as f64;
    // What explains the data better than what leaves more than noise of a part leaves nothing to look for in a larger one.
    let is_explained_otherwise = |part: &Option<Rejecting>, complete: bool| {
        let Some((instead, Rejecting { searched, signals, kept })) = problem.instead.zip(part.as_ref()) else {
            return false;
        };
        let of_part = Problem { segments: &kept.segments, noise: &signals.sigma, ..*problem };
        if of_part.is_settled(&searched.best) {
            return false;
        }
        let Estimate { terms, fits, stepping, .. } = of_part.account(searched.clone(), signals);
        instead(OfPart { terms: &terms, fits: &fits, stepping, complete })
    };
    if is_very_long {
        if is_explained_otherwise(&part, complete) {
            return None;
        }
        if let Some(few) = &part {
            let (more, finished) = in_part(problem, (LARGER_SAMPLE, IN_LARGER), Some(&few.searched.best), stepping);
            complete &= finished;
            part = more.or(part);
            if is_explained_otherwise(&part, complete) {
                return None;
            }
        }
    }
    let signals = problem.smoother().signals(problem.floor);
    let all = Problem { noise: &signals.sigma, ..*problem };
    let begun = part.as_ref().and_then(|part| all.fitted(&part.searched.best, &signals));
    let before = part.as_ref().map(|part| &part.searched).filter(|_| is_very_long);
    let mut all = accounted(&Problem { again: begun.is_some(), ..*problem }, (begun, before), stepping)?;
    all.found.complete &= complete;
    Some(all)
}

/// What is found in the `steps` steps that tell most, from `begun` where that is given, for a `share` of what is left of the budget; and whether that was enough.
fn in_part(
    problem: &Problem<'_>,
    (steps, share): (usize, f64),
    begun: Option<&Hypothesis>,
    stepping: Stepping,
) -> (Option<Rejecting>, bool) {
    let (sample, spent) = (sample_of(problem.segments, steps), Cell::new(0));
    let budget = (share * (problem.budget - problem.spent.get().min(problem.budget)) as f64) as u64;
    let part = Problem { segments: &sample, spent: &spent, budget, again: begun.is_some(), ..*problem };
    let begun = begun.and_then(|begun| {
        let signals = part.smoother().signals(part.floor);
        Problem { noise: &signals.sigma, ..part }.fitted(begun, &signals)
    });
    let found = part.rejecting((begun, None), stepping);
    problem.charge(spent.get().min(budget));
    (found, spent.get() <= budget)
}

/// The same, from `begun` or, without it, from nothing; terms are looked for in all samples, and compared in all of them or as a part told `before`.
pub(super) fn accounted(
    problem: &Problem<'_>,
    (begun, before): (Option<Hypothesis>, Option<&Searched>),
    stepping: Stepping,
) -> Option<Accounted> {
    let Rejecting { searched, signals, kept } = problem.rejecting((begun, before), stepping)?;
    let best = searched.best.clone();
    let found = Problem { segments: &kept.segments, noise: &signals.sigma, ..*problem }.account(searched, &signals);
    let found = Estimate { score: found.score + kept.price, astray: kept.astray, ..found };
    Some(Accounted { best, found, kept })
}

/// Parts of what is left of the budget for the first part of the samples, and for a larger one.
const IN_SAMPLE: f64 = 0.75;
const IN_LARGER: f64 = 0.9;

/// Steps of the part of long recordings in which terms are looked for first.
pub(super) const SAMPLE: usize = 300;

/// Steps of a larger part, in which terms are compared where there are twice as many or more.
pub(super) const LARGER_SAMPLE: usize = 1800;

/// How exact samples are taken to be: the smallest error of each state that is believed (n), and what the signals are then.
pub(super) struct Level {
    pub(super) floor: Vec<f64>,
    pub(super) signals: Signals,
}

/// The path of the signals, as `stepping` has it between samples.
pub(super) fn measured(signals: &Signals, stepping: Stepping) -> Path<'_> {
    match stepping {
        stepping if stepping.is_continuous() => Path::Measured(signals),
        _ => Path::Held { x: &signals.x },
    }
}

/// The path of a hypothesis.
pub(super) fn followed(hypothesis: &Hypothesis) -> Path<'_> {
    let (flow, fit) = (&hypothesis.flow, &hypothesis.fit);
    match flow.stepping() {
        stepping if stepping.is_continuous() => Path::Model { flow, xi: &fit.xi, x: &fit.x },
        _ => Path::Held { x: &fit.x },
    }
}

/// What every term costs in the regressions that propose, as multiples of its penalty.
pub(super) const TIMES: [f64; 4] = [64.0, 16.0, 4.0, 1.0];

impl Problem<'_> {
    /// Whether terms are looked for in a part of the samples first.
    pub(super) fn is_long(&self) -> bool {
        self.samples() > 2.0 * SAMPLE as f64
    }

    /// What tells signals from noise before anything is known of the equations.
    pub(super) fn smoother(&self) -> Smoother<'_> {
        Smoother::new(self.segments, self.rates, self.floor, self.watch.asks())
    }

    /// Terms of each equation with coefficients that are given.
    pub(super) fn given(&self) -> Vec<Given> {
        self.constraints.iter().map(|c| c.fixed.clone()).collect()
    }

    /// Terms equation `i` has in any case.
    pub(super) fn required(&self, i: usize) -> &[usize] {
        self.constraints.get(i).map_or(&[], |c| &c.required)
    }

    /// What is found if samples are taken for less exact than they are: at first for wrong by a hundredth of their spread, then by less, until what is left
    /// of every state is more. To the last digit many terms explain more, before the true ones are among them, than these do with parameters that are
    /// nearly right.
    pub(super) fn roughly(&self, stepping: Stepping) -> Option<Rough> {
        let smoother = self.smoother();
        let signals = smoother.signals(self.floor);
        let problem = Problem { noise: &signals.sigma, ..*self };
        let explains = |found: &Hypothesis| problem.is_settled(found) || problem.with_corrected_inputs(found).is_some();
        if let Some(parts) = problem.proposed_by_parts(&signals, stepping).filter(explains) {
            return Some(Rough::Begun(parts));
        }
        let levels: Vec<Level> = ROUGH.iter().map(|part| self.level(&smoother, *part)).collect();
        // Of mechanics that does not explain the data nothing is kept.
        if let Some(mechanics) = problem.mechanical(&signals, &levels, stepping) {
            return Some(Rough::Begun(mechanics));
        }
        if let Some(simplest) = problem.of_simplest(&signals, explains, stepping) {
            return Some(Rough::Begun(simplest));
        }
        let mut begun: Option<Hypothesis> = None;
        for Level { floor, signals } in &levels {
            let leaves_less = |b: &Hypothesis| b.fit.left.iter().zip(floor).all(|(left, floor)| left <= floor);
            if begun.as_ref().is_some_and(leaves_less) {
                continue;
            }
            // Half of what may be spent is left for what comes after.
            let budget = self.spent.get().midpoint(self.budget);
            let problem = Problem { floor, noise: &signals.sigma, budget, ..*self };
            let from = begun.as_ref().and_then(|best| problem.fitted(best, signals));
            let Some(mut found) = problem.first(signals, from, stepping) else { break };
            let measured: Vec<usize> = (0..floor.len()).filter(|&i| self.measures(i)).collect();
            let is_noisy = |h: &Hypothesis| measured.iter().all(|&i| h.fit.left[i] > FLOOR * floor[i]);
            // What it leaves is what rounding of the inputs does.
            if problem.with_corrected_inputs(&found).is_some() {
                return Some(Rough::Begun(found));
            }
            if is_noisy(&found) {
                let searched = problem.finished(found, signals, None);
                if is_noisy(&searched.best) {
                    return Some(Rough::Noisy(searched));
                }
                found = searched.best;
            }
            self.spent.set(self.spent.get().min(budget));
            begun = Some(found);
        }
        begun.map(Rough::Begun)
    }

    /// Samples taken for wrong by the part `part` of their spread.
    fn level(&self, smoother: &Smoother<'_>, part: f64) -> Level {
        let floor: Vec<f64> = (0..self.rates.len()).map(|i| self.floor[i].max(part * self.spread(i))).collect();
        let signals = smoother.signals(&floor);
        Level { floor, signals }
    }

    /// What explains parts of the data, fitted to all of them.
    fn proposed_by_parts(&self, signals: &Signals, stepping: Stepping) -> Option<Hypothesis> {
        let (supports, xi) = self.of_parts?;
        let start = Start { xi, inside: &[], x: &signals.x, sigma: &signals.sigma };
        self.hypothesis(supports.clone(), stepping, start, 2..4)
    }

    /// The terms of `found`, fitted to these samples.
    pub(super) fn fitted(&self, found: &Hypothesis, signals: &Signals) -> Option<Hypothesis> {
        let stepping = found.flow.stepping();
        if matches!(stepping, Stepping::Continuous { .. }) {
            let start = Start { x: &signals.x, sigma: &signals.sigma, ..found.start() };
            return self.with_reserve(|problem| problem.hypothesis(found.supports.clone(), stepping, start, 0..4));
        }
        // Steps of a simulator are those of the samples, not of what is smooth.
        let x: Vec<Array2<f64>> = self.segments.iter().map(|s| s.x.clone()).collect();
        let start = Start { x: &x, sigma: &signals.sigma, ..found.start() };
        self.with_reserve(|problem| problem.hypothesis(found.supports.clone(), stepping, start, 2..4))
    }

    /// The hypothesis with the best score, from `begun` where that leaves noise alone; other terms are compared with its own in all samples, or were so in a part of
    /// them `before`.
    pub(super) fn search(
        &self,
        signals: &Signals,
        (begun, before): (Option<Hypothesis>, Option<&Searched>),
        stepping: Stepping,
    ) -> Option<Searched> {
        self.first(signals, begun, stepping).map(|first| self.finished(first, signals, before))
    }

    /// The best of what regressions propose, from `begun` where that leaves noise alone.
    fn first(&self, signals: &Signals, begun: Option<Hypothesis>, stepping: Stepping) -> Option<Hypothesis> {
        let explains = |found: &Hypothesis| self.is_settled(found) || self.with_corrected_inputs(found).is_some();
        let mut best = match begun.map(|begun| self.as_simulated(begun)) {
            Some(begun) if explains(&begun) => begun,
            begun => match begun.map(|begun| self.gone_on(begun, signals)) {
                Some(begun) if explains(&begun) => begun,
                begun => {
                    let proposed = self.propose(&measured(signals, stepping), &signals.sigma);
                    self.rounds(signals, proposed, begun, stepping)?
                }
            },
        };
        self.prune(&mut best);
        Some(best)
    }

    /// `best` with terms that multiply their own derivative, and with others in place of its own, as long as that improves the score.
    fn finished(&self, mut best: Hypothesis, signals: &Signals, before: Option<&Searched>) -> Searched {
        // The part of the samples in which these equations were found was searched for shorter ones.
        if !(self.again && self.is_settled(&best)) && self.implicit(&mut best, signals) {
            self.prune(&mut best);
        }
        self.mirror(&mut best);
        self.exchanged(best, before)
    }

    /// `base` with other terms in equation `i`, fitted anew.
    pub(super) fn with_equation(
        &self,
        base: &Hypothesis,
        i: usize,
        proposal: &Proposal,
        parts: std::ops::Range<usize>,
    ) -> Option<Hypothesis> {
        let mut supports = base.supports.clone();
        supports[i].clone_from(&proposal.support);
        let first: usize = base.supports[..i].iter().map(Vec::len).sum();
        let mut xi = base.coefficients().to_vec();
        xi.splice(first..first + base.supports[i].len(), proposal.coefficients.iter().copied());
        let inside = [&proposal.inside[..], &base.inside].concat();
        let start = Start { xi: &xi, inside: &inside, ..base.start() };
        self.hypothesis(supports, base.flow.stepping(), start, parts)
    }

    /// Whether all equations leave noise alone.
    pub(super) fn is_settled(&self, hypothesis: &Hypothesis) -> bool {
        (0..self.rates.len()).all(|i| self.is_noise(hypothesis, i))
    }

    /// Whether the prediction errors of state `i`, and of those it is the rate of, are uncorrelated.
    pub(super) fn is_noise(&self, hypothesis: &Hypothesis, i: usize) -> bool {
        let Some(innovations) = hypothesis.innovations(self) else { return false };
        let mut at = Some(i);
        let mut seen = Vec::new();
        while let Some(i) = at.filter(|i| !seen.contains(i)) {
            if self.measures(i)
                && !is_white(innovations, i)
                && hypothesis.fit.left[i] > FLOOR * self.floor[i]
                && !hypothesis.numerical
            {
                return false;
            }
            seen.push(i);
            at = self.rates.iter().position(|r| *r == Some(i));
        }
        true
    }

    /// Whether what is left of every state is below all that numbers can tell.
    pub(super) fn leaves_nothing(&self, hypothesis: &Hypothesis) -> bool {
        hypothesis.numerical || self.is_rounding(hypothesis)
    }

    /// Whether what is left of every state is no more than the smallest error that is believed, nor what its path misses the equations by in all: one that was not measured leaves nothing,
    /// and is free to miss them.
    pub(super) fn is_rounding(&self, hypothesis: &Hypothesis) -> bool {
        let left = hypothesis.fit.left.iter().zip(&hypothesis.fit.drift).map(|(left, drift)| left.hypot(*drift));
        left.zip(self.floor).all(|(left, floor)| left <= FLOOR * floor)
    }

    /// Standard deviation of state `i` over all samples.
    pub(super) fn spread(&self, i: usize) -> f64 {
        let values: Vec<f64> = self.segments.iter().flat_map(|s| s.x.column(i).to_vec()).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt()
    }
}
