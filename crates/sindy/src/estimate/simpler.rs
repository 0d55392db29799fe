//! Simpler terms in place of those of an equation.
//!
//! Where states move little, many terms explain nearly the same, and the best subsets of a size do not come to all of them.

use super::regression::{Proposal, Regression};
use super::rest::{Rest, dot};
use crate::solve::Subset;

impl Regression {
    /// At most `most` proposals of the terms `support` with one or two of them exchanged for simpler ones, whose scores are within `gap` of that of
    /// `support`, best first; also the operations that this took. `complexity` is that of a term.
    pub(super) fn simpler(
        &self,
        support: &[usize],
        (gap, most): (f64, usize),
        penalty: impl Fn(&[usize]) -> f64,
        complexity: impl Fn(usize) -> u32,
    ) -> (Vec<Proposal>, u64) {
        let column = |j: &usize| self.choice.iter().position(|k| k == j);
        let Some(own) = support.iter().map(column).collect::<Option<Vec<_>>>() else { return (Vec::new(), 0) };
        let target = self.choice.len();
        let complexity: Vec<u32> = self.choice.iter().map(|&j| complexity(j)).collect();
        let complexity_of = |columns: &[usize]| columns.iter().map(|&c| complexity[c]).sum::<u32>();
        let free: Vec<usize> = own.iter().copied().filter(|&c| c >= self.n_required).collect();
        let Some(left) = Rest::without(&self.triangle, own.iter().copied()).of(target) else { return (Vec::new(), 0) };
        let price = penalty(support);
        let limit = self.likelihood(free.len(), dot(&left, &left)) + price + gap;
        let ones = free.iter().map(|&c| vec![c]);
        let twos = free.iter().enumerate().flat_map(|(at, &c)| free[at + 1..].iter().map(move |&d| vec![c, d]));
        let (mut scored, mut work): (Vec<(f64, Subset)>, u64) = (Vec::new(), 0);
        for out in ones.chain(twos) {
            let rest = Rest::without(&self.triangle, own.iter().copied().filter(|c| !out.contains(c)));
            let plainest = out.iter().map(|&c| complexity[c]).min().unwrap_or(0);
            let others = (self.n_required..target).filter(|c| !own.contains(c) && complexity[*c] <= plainest);
            let (exchanges, spent) = rest.with(others, out.len(), |with| complexity_of(with) < complexity_of(&out));
            work += spent;
            // No term costs less than nothing.
            let hopeful = |rss: f64| self.likelihood(free.len(), rss) + price - f64::from(complexity_of(&out)) < limit;
            for (with, rss) in exchanges.into_iter().filter(|(_, rss)| hopeful(*rss)) {
                let kept = free.iter().filter(|c| !out.contains(c));
                let mut support: Vec<usize> = kept.chain(&with).map(|c| c - self.n_required).collect();
                support.sort_unstable();
                let subset = Subset { support, rss };
                let score = self.score(1.0, &subset, &penalty);
                if score < limit && self.has_signs(&subset) {
                    scored.push((score, subset));
                }
            }
        }
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        (scored.iter().take(most).map(|(score, subset)| self.proposal(*score, subset)).collect(), work)
    }

    /// At most `most` proposals of the terms `support` with any two in place of the only one that has a parameter inside, whose scores are within `gap` of the best of them,
    /// best first: two coefficients say as much. Also the operations that this took. `is_inside` tells which terms have parameters inside.
    pub(super) fn in_place_of_one(
        &self,
        support: &[usize],
        (gap, most): (f64, usize),
        penalty: impl Fn(&[usize]) -> f64,
        is_inside: impl Fn(usize) -> bool,
    ) -> (Vec<Proposal>, u64) {
        let own: Vec<usize> = support.iter().copied().filter(|&j| !is_inside(j)).collect();
        let place = |j: &usize| self.choice.iter().position(|k| k == j);
        let Some(own) = own.iter().map(place).collect::<Option<Vec<_>>>() else { return (Vec::new(), 0) };
        if own.len() + 1 != support.len() {
            return (Vec::new(), 0);
        }
        let rest = Rest::without(&self.triangle, own.iter().copied());
        let others = (self.n_required..self.choice.len()).filter(|c| !own.contains(c) && !is_inside(self.choice[*c]));
        let (pairs, work) = rest.with(others, 2, |_| true);
        let kept: Vec<usize> = own.iter().filter_map(|c| c.checked_sub(self.n_required)).collect();
        let subset = |(with, rss): (Vec<usize>, f64)| {
            let mut support: Vec<usize> =
                kept.iter().copied().chain(with.iter().map(|c| c - self.n_required)).collect();
            support.sort_unstable();
            Subset { support, rss }
        };
        let scored = pairs.into_iter().map(subset).map(|subset| (self.score(1.0, &subset, &penalty), subset));
        let mut scored: Vec<(f64, Subset)> = scored.filter(|(_, subset)| self.has_signs(subset)).collect();
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = scored.first().map_or(0.0, |(score, _)| *score);
        let near = scored.iter().take(most).filter(|(score, _)| *score <= least + gap);
        (near.map(|(score, subset)| self.proposal(*score, subset)).collect(), work)
    }
}
