//! Terms with parameters inside in several equations at once, along the measured path: where one of them is wrong, no other can be judged by trajectories.

use super::inside::SIMPLE;
use super::problem::{Problem, Separate};
use super::regression::{Inside, Proposal, Regression};
use super::search::TIMES;
use crate::data::Signals;
use crate::motion::Stepping;

/// Part of all that may be spent, for these.
const SHARE: f64 = 0.2;

/// Terms of all equations: their numbers, their coefficients one equation after the other, and where parameters inside them begin.
pub(super) type Trial = (Vec<Vec<usize>>, Vec<f64>, Vec<Inside>);

impl Problem<'_> {
    /// The best terms of every equation if each costs so many times what it does, one for each of [`TIMES`], where equations for which `proposed` has many
    /// may have one with parameters inside instead. Empty if none has.
    pub(super) fn jointly(&self, signals: &Signals, proposed: &[Regression], stepping: Stepping) -> Vec<Trial> {
        if self.n_plain == self.terms.len() {
            return Vec::new();
        }
        let many = |i: usize| {
            let best = proposed[i].best(1.0, |support| self.penalty(support));
            self.rates[i].is_none() && best.support.len() > SIMPLE && self.alone.get(i).is_none_or(Option::is_none)
        };
        let nothing = vec![Vec::new(); self.rates.len()];
        let of = |problem: &Problem<'_>, i: usize| match many(i) && problem.may_spend() {
            true => problem.measured_inside((&nothing, &[], stepping), signals, i, false),
            false => Vec::new(),
        };
        let inside: Vec<Vec<Proposal>> =
            self.with_share(SHARE, |problem| (0..self.rates.len()).map(|i| of(problem, i)).collect());
        let mut trials: Vec<Trial> = Vec::new();
        for times in TIMES {
            let dear = |p: &Proposal| p.score + (times - 1.0) * self.penalty(&p.support);
            let best = |i: usize| {
                let mut plain = proposed[i].best(times, |support| self.penalty(support));
                if let Some(Some(Separate { support, coefficients, .. })) = self.alone.get(i) {
                    plain = Proposal { support: support.clone(), coefficients: coefficients.clone(), ..plain };
                }
                let other = inside[i].iter().min_by(|a, b| dear(a).total_cmp(&dear(b)));
                other.filter(|other| dear(other) < plain.score).cloned().unwrap_or(plain)
            };
            let trial = self.shared((0..self.rates.len()).map(best).collect());
            if !trial.2.is_empty() && trials.iter().all(|other| other.0 != trial.0) {
                trials.push(trial);
            }
        }
        trials
    }

    /// The proposals as one, in which terms that are the same but for where parameters begin are the same term.
    fn shared(&self, proposals: Vec<Proposal>) -> Trial {
        let mut trial: Trial = (Vec::new(), Vec::new(), Vec::new());
        for Proposal { support, coefficients, inside, .. } in proposals {
            let mut told: Vec<(usize, f64)> = Vec::with_capacity(support.len());
            for (j, c) in support.into_iter().zip(coefficients) {
                let known = trial.2.iter().map(|(k, _)| *k).find(|&k| j >= self.n_plain && self.are_alike(&[j], &[k]));
                if known.is_none() {
                    trial.2.extend(inside.iter().filter(|(k, _)| *k == j).cloned());
                }
                told.push((known.unwrap_or(j), c));
            }
            told.sort_by_key(|(j, _)| *j);
            trial.1.extend(told.iter().map(|(_, c)| *c));
            trial.0.push(told.into_iter().map(|(j, _)| j).collect());
        }
        trial
    }
}
