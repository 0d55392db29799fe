//! Terms that the score does not pay for.

use super::hypothesis::{Hypothesis, Start};
use super::problem::{Problem, Structure};

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
        let Some((supports, xi)) = self.significant(best, usize::MAX) else { return };
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
    /// The terms of `found` and their coefficients without those, at most `most`, that are worth less than they cost, to first order and each by itself: the least
    /// significant ones. `None` if there are none.
    pub(super) fn significant(&self, found: &Hypothesis, most: usize) -> Option<Structure> {
        let places = found.supports.iter().enumerate().flat_map(|(i, support)| support.iter().map(move |j| (i, *j)));
        let z = |p: usize| found.fit.xi[p] / found.fit.errors[p];
        let is_needless = |(p, (i, j)): (usize, (usize, usize))| {
            let price = self.penalty(&found.supports[i]) / found.supports[i].len() as f64;
            let kept = z(p).powi(2) > price || self.required(i).contains(&j);
            (!kept).then_some(p)
        };
        let mut needless: Vec<usize> = places.enumerate().filter_map(is_needless).collect();
        needless.sort_by(|&a, &b| z(a).abs().total_cmp(&z(b).abs()));
        needless.truncate(most);
        let (mut supports, mut xi, mut places) = (Vec::new(), Vec::new(), 0..);
        for support in &found.supports {
            let own = support.iter().zip(places.by_ref()).filter(|(_, p)| !needless.contains(p));
            let (kept, coefficients): (Vec<usize>, Vec<f64>) = own.map(|(j, p)| (*j, found.fit.xi[p])).unzip();
            supports.push(kept);
            xi.extend(coefficients);
        }
        (!needless.is_empty()).then_some((supports, xi))
    }
}
