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

impl Rest<'_> {
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
        let free: Vec<usize> = own.iter().copied().filter(|&c| c >= self.n_required).collect();
        let price = penalty(support);
        let mut scored: Vec<(f64, Subset)> = Vec::new();
        let (mut limit, mut work) = (f64::INFINITY, 0);
        let mut outs: Vec<Vec<usize>> = free.iter().map(|&c| vec![c]).collect();
        outs.extend(free.iter().enumerate().flat_map(|(at, &c)| free[at + 1..].iter().map(move |&d| vec![c, d])));
        // With nothing exchanged the score is that of `support`.
        for out in std::iter::once(Vec::new()).chain(outs) {
            let kept: Vec<usize> = own.iter().copied().filter(|c| !out.contains(c)).collect();
            let mut rest = Rest { regression: self, basis: Vec::new() };
            for &c in &kept {
                let left = rest.of(c);
                rest.basis.extend(left.map(unit));
            }
            let Some(y) = rest.of(target) else { continue };
            let kept: Vec<usize> = kept.into_iter().filter(|&c| c >= self.n_required).collect();
            let total: u32 = out.iter().map(|&c| complexity[c]).sum();
            let mut offer = |with: &[usize], rss: f64, limit: f64| {
                // No term costs less than nothing.
                if self.likelihood(free.len(), rss) + price - f64::from(total) > limit {
                    return limit;
                }
                let mut support: Vec<usize> = kept.iter().chain(with).map(|c| c - self.n_required).collect();
                support.sort_unstable();
                let subset = Subset { support, rss };
                let score = self.score(1.0, &subset, &penalty);
                if score < limit && !with.is_empty() && self.has_signs(&subset) {
                    scored.push((score, subset));
                }
                score
            };
            let least = out.iter().map(|&c| complexity[c]).min().unwrap_or(0);
            let square = dot(&y, &y);
            let Some(&_) = out.first() else {
                limit = offer(&[], square, f64::INFINITY) + gap;
                continue;
            };
            let others = (self.n_required..target).filter(|c| !own.contains(c) && complexity[*c] <= least);
            let others: Vec<(usize, Vec<f64>)> = others.filter_map(|c| Some((c, unit(rest.of(c)?)))).collect();
            work += ((2 * rest.basis.len() + 1) * others.len() * y.len()) as u64;
            for (at, (c, u)) in others.iter().enumerate() {
                let explained = dot(u, &y).powi(2);
                if out.len() == 1 {
                    if complexity[*c] < total {
                        offer(&[*c], (square - explained).max(0.0), limit);
                    }
                    continue;
                }
                for (d, v) in others[at + 1..].iter().filter(|(d, _)| complexity[*c] + complexity[*d] < total) {
                    let mut v = v.clone();
                    take(&mut v, u);
                    let left = dot(&v, &v);
                    if left > LEFT * LEFT {
                        offer(&[*c, *d], (square - explained - dot(&v, &y).powi(2) / left).max(0.0), limit);
                    }
                    work += 4 * y.len() as u64;
                }
            }
        }
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        (scored.iter().take(most).map(|(score, subset)| self.proposal(*score, subset)).collect(), work)
    }
}
