//! Rounds of proposals, each along the path of what the last one found.

use super::hypothesis::{Hypothesis, Start};
use super::problem::{Problem, Separate};
use super::regression::Regression;
use super::search::{FAR, TIMES};
use crate::data::Signals;
use crate::motion::Stepping;

/// Rounds of proposals, at most.
pub(super) const ROUNDS: usize = 6;

/// Noise larger than this many times what the smoothness of the signals tells is no noise.
const LARGER: f64 = 1.25;

impl Problem<'_> {
    /// The best of `begun`, which leaves more than noise, of other terms near it, and, unless few of these leave noise alone, of one more with parameters
    /// inside: this before many terms make up for one that is missing.
    pub(super) fn gone_on(&self, begun: Hypothesis, signals: &Signals) -> Hypothesis {
        let best = self.beside(&begun);
        if self.is_settled(&best) && self.is_simple(&best) {
            return best;
        }
        let inside = self.search_inside(&begun, signals);
        inside.filter(|inside| inside.score < best.score).unwrap_or(best)
    }

    /// The best of `begun` and of the terms near it that explain what it leaves.
    pub(super) fn beside(&self, begun: &Hypothesis) -> Hypothesis {
        let proposed = self.propose_near(begun, &|_| usize::MAX);
        let mut best = begun.clone();
        let mut tried = vec![begun.supports.clone()];
        for times in TIMES {
            let (supports, xi) = self.best_terms(&proposed, times);
            if tried.contains(&supports) {
                continue;
            }
            tried.push(supports.clone());
            let from = Start { xi: &xi, ..begun.start() };
            let loose = self.hypothesis(supports, begun.flow.stepping(), from, 0..2);
            let strict = loose.and_then(|l| self.hypothesis(l.supports.clone(), l.flow.stepping(), l.start(), 2..4));
            best = strict.filter(|s| s.score < best.score).unwrap_or(best);
        }
        best
    }

    /// The terms of every equation that are best if each costs `times` what it does, and their coefficients, equation by equation; of equations that were found
    /// alone those.
    fn best_terms(&self, proposed: &[Regression], times: f64) -> (Vec<Vec<usize>>, Vec<f64>) {
        let of = |(i, r): (usize, &Regression)| {
            if let Some(Some(Separate { support, coefficients, .. })) = self.alone.get(i) {
                return (support.clone(), coefficients.clone());
            }
            let best = r.best(times, |support| self.penalty(support));
            (best.support, best.coefficients)
        };
        let (supports, xi): (_, Vec<Vec<f64>>) = proposed.iter().enumerate().map(of).unzip();
        (supports, xi.concat())
    }

    /// Proposals along the path of the best hypothesis so far until none is new, and that hypothesis.
    pub(super) fn rounds(
        &self,
        signals: &Signals,
        mut proposed: Vec<Regression>,
        mut best: Option<Hypothesis>,
        stepping: Stepping,
    ) -> Option<Hypothesis> {
        let mut tried: Vec<Vec<Vec<usize>>> = Vec::new();
        let simulated = best.as_ref().map(|b| b.flow.stepping()).filter(|s| !matches!(s, Stepping::Continuous { .. }));
        let stepping = simulated.unwrap_or(stepping);
        // The best that has no term with parameters inside from before.
        let mut fresh: Option<Hypothesis> = None;
        for round in 0..ROUNDS {
            let mut along: Option<Hypothesis> = None;
            let plain = TIMES.map(|times| self.best_terms(&proposed, times));
            let plain = plain.into_iter().map(|(supports, xi)| (supports, xi, Vec::new()));
            let joint = if round == 0 { self.jointly(signals, &proposed, stepping) } else { Vec::new() };
            for (supports, xi, inside) in joint.into_iter().chain(plain) {
                if tried.contains(&supports) {
                    continue;
                }
                tried.push(supports.clone());
                let from = Start { xi: &xi, inside: &inside, x: &signals.x, sigma: &signals.sigma };
                // First with states that follow the data more than the equations, which may be wrong.
                let Some(loose) = self.hypothesis(supports.clone(), stepping, from, 0..2) else { continue };
                let bar = if round == 0 { &fresh } else { &best };
                if bar.as_ref().is_some_and(|b| loose.score > b.score + FAR) {
                    continue;
                }
                let strict = self.hypothesis(supports, stepping, loose.start(), 2..4);
                let improves = |s: &&Hypothesis, b: &Option<Hypothesis>| b.as_ref().is_none_or(|b| s.score < b.score);
                if let Some(strict) = strict.as_ref().filter(|s| round == 0 && improves(s, &fresh)) {
                    fresh = Some(strict.clone());
                }
                let better = strict.as_ref().filter(|s| improves(s, &best)).cloned();
                if let Some(strict) = better {
                    if self.leaves_nothing(&strict) {
                        return self.search_inside(&strict, signals).or(Some(strict));
                    }
                    // What it leaves is what rounding of the inputs does.
                    if self.with_corrected_inputs(&strict).is_some() {
                        return Some(strict);
                    }
                    let near = strict.fit.sigma.iter().zip(&signals.sigma).all(|(s, n)| *s <= LARGER * n);
                    along = Some(if near { strict.clone() } else { loose });
                    best = Some(strict);
                } else if best.is_none() {
                    along = Some(loose);
                }
            }
            // Before many terms make up for one that is missing.
            let inside = fresh.take().and_then(|f| self.search_inside(&f, signals));
            if let Some(inside) = inside.filter(|i| best.as_ref().is_none_or(|b| i.score < b.score)) {
                if self.is_settled(&inside) {
                    return Some(inside);
                }
                along = Some(inside.clone());
                best = Some(inside);
            }
            let Some(along) = along else { break };
            proposed = self.propose_near(&along, &|_| usize::MAX);
        }
        best.or_else(|| self.without_choice(signals, stepping))
    }

    /// Equations of the required terms alone: where the data follow none that were proposed, these are what others are compared with.
    fn without_choice(&self, signals: &Signals, stepping: Stepping) -> Option<Hypothesis> {
        let supports: Vec<Vec<usize>> = (0..self.rates.len()).map(|i| self.required(i).to_vec()).collect();
        let xi = vec![0.0; supports.iter().map(Vec::len).sum()];
        let start = Start { xi: &xi, inside: &[], x: &signals.x, sigma: &signals.sigma };
        self.with_reserve(|problem| problem.hypothesis(supports, stepping, start, 0..4))
    }
}
