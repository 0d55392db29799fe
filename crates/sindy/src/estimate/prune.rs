//! Terms that the score does not pay for.

use super::hypothesis::{Hypothesis, Start};
use super::problem::Problem;

impl Problem<'_> {
    /// Drops terms that the score does not pay for: all at once that look so, then the least significant first. For that there is a budget beyond that
    /// of the search.
    pub(super) fn prune(&self, best: &mut Hypothesis) {
        self.with_reserve(|problem| problem.prune_within(best));
    }

    fn prune_within(&self, best: &mut Hypothesis) {
        self.prune_at_once(best);
        loop {
            let z = |p: usize| (best.fit.xi[p] / best.fit.errors[p]).abs();
            let places: Vec<(usize, usize)> =
                best.supports.iter().enumerate().flat_map(|(i, s)| (0..s.len()).map(move |at| (i, at))).collect();
            let free = |p: &usize| !self.required(places[*p].0).contains(&best.supports[places[*p].0][places[*p].1]);
            let Some(least) = (0..places.len()).filter(free).min_by(|&a, &b| z(a).total_cmp(&z(b))) else { break };
            let (row, at) = places[least];
            let mut supports = best.supports.clone();
            let before = self.penalty(&supports[row]);
            supports[row].remove(at);
            // To first order the sum of squares grows by z².
            if z(least).powi(2) > 4.0 * (before - self.penalty(&supports[row])) {
                break;
            }
            let mut xi = best.coefficients().to_vec();
            xi.remove(least);
            let start = Start { xi: &xi, ..best.start() };
            match self.hypothesis(supports, best.flow.stepping(), start, 2..4) {
                Some(fewer) if fewer.score < best.score => *best = fewer,
                _ => break,
            }
        }
    }

    /// Drops all terms whose loss, to first order and each by itself, the score would make up for; if it does for all of them.
    fn prune_at_once(&self, best: &mut Hypothesis) {
        let (mut supports, mut xi) = (Vec::new(), Vec::new());
        let mut parameter = 0;
        for (i, support) in best.supports.iter().enumerate() {
            let price = self.penalty(support) / support.len().max(1) as f64;
            let kept = support.iter().filter(|j| {
                let z = best.fit.xi[parameter] / best.fit.errors[parameter];
                parameter += 1;
                let kept = z * z > price || self.required(i).contains(j);
                if kept {
                    xi.push(best.fit.xi[parameter - 1]);
                }
                kept
            });
            supports.push(kept.copied().collect::<Vec<_>>());
        }
        if best.coefficients().len() < xi.len() + 2 {
            return;
        }
        let start = Start { xi: &xi, ..best.start() };
        if let Some(fewer) = self.hypothesis(supports, best.flow.stepping(), start, 2..4)
            && fewer.score < best.score
        {
            *best = fewer;
        }
    }
}
