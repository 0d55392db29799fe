//! Simpler terms in place of those of an equation.
//!
//! Where states move little, many terms explain nearly the same, and the best subsets of a size do not come to all of them.

use super::regression::{Proposal, Regression};
use crate::solve::Subset;

/// Part of a column's length that others must leave of it, lest it be taken for a sum of these.
const LEFT: f64 = 1e-9;

/// Columns as long as the triangle has rows, without what others explain of them.
struct Rest<'a> {
    regression: &'a Regression,
    /// Orthonormal columns that span these others.
    basis: Vec<Vec<f64>>,
}

impl<'a> Rest<'a> {
    /// What `columns` leave of others.
    fn without(regression: &'a Regression, columns: impl Iterator<Item = usize>) -> Self {
        let mut rest = Self { regression, basis: Vec::new() };
        for c in columns {
            let left = rest.of(c);
            rest.basis.extend(left.map(unit));
        }
        rest
    }

    /// What is left of column `c`; `None` if that is nothing.
    fn of(&self, c: usize) -> Option<Vec<f64>> {
        let triangle = &self.regression.triangle;
        let column = triangle.column(c);
        let mut rest = vec![0.0; triangle.n_columns()];
        rest[..column.len()].copy_from_slice(column);
        // Twice is enough (Kahan).
        for q in self.basis.iter().chain(&self.basis) {
            take(&mut rest, q);
        }
        (length(&rest) > LEFT * triangle.norm(c)).then_some(rest)
    }

    /// Each one of `columns`, or each two of them if `count` is two, of which `may` holds, with the sum of squares that is left of the target then; also
    /// the operations that this took.
    fn with(
        &self,
        columns: impl Iterator<Item = usize>,
        count: usize,
        may: impl Fn(&[usize]) -> bool,
    ) -> (Vec<(Vec<usize>, f64)>, u64) {
        let Some(y) = self.of(self.regression.choice.len()) else { return (Vec::new(), 0) };
        let columns: Vec<(usize, Vec<f64>)> = columns.filter_map(|c| Some((c, unit(self.of(c)?)))).collect();
        let mut work = (2 * self.basis.len() + 1) * columns.len() * y.len();
        let mut found = Vec::new();
        for (at, (c, u)) in columns.iter().enumerate() {
            let left = dot(&y, &y) - dot(u, &y).powi(2);
            if count == 1 {
                found.extend(may(&[*c]).then(|| (vec![*c], left.max(0.0))));
                continue;
            }
            for (d, v) in columns[at + 1..].iter().filter(|(d, _)| may(&[*c, *d])) {
                let mut v = v.clone();
                take(&mut v, u);
                let square = dot(&v, &v);
                if square > LEFT * LEFT {
                    found.push((vec![*c, *d], (left - dot(&v, &y).powi(2) / square).max(0.0)));
                }
                work += 4 * y.len();
            }
        }
        (found, work as u64)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Takes from `a` its part along the unit vector `q`.
fn take(a: &mut [f64], q: &[f64]) {
    let along = dot(a, q);
    a.iter_mut().zip(q).for_each(|(a, q)| *a -= along * q);
}

fn unit(mut a: Vec<f64>) -> Vec<f64> {
    let length = length(&a);
    a.iter_mut().for_each(|a| *a /= length);
    a
}

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
        let Some(left) = Rest::without(self, own.iter().copied()).of(target) else { return (Vec::new(), 0) };
        let price = penalty(support);
        let limit = self.likelihood(free.len(), dot(&left, &left)) + price + gap;
        let ones = free.iter().map(|&c| vec![c]);
        let twos = free.iter().enumerate().flat_map(|(at, &c)| free[at + 1..].iter().map(move |&d| vec![c, d]));
        let (mut scored, mut work): (Vec<(f64, Subset)>, u64) = (Vec::new(), 0);
        for out in ones.chain(twos) {
            let rest = Rest::without(self, own.iter().copied().filter(|c| !out.contains(c)));
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
        let rest = Rest::without(self, own.iter().copied());
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
