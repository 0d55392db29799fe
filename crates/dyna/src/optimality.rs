//! When to stop improving: the rule behind "while π is not optimal" of Algorithm 1.

use serde::{Deserialize, Serialize};

use crate::trust::Trust;

/// A policy is optimal in the model when
/// - `settled` trials in a row came within `tolerance` of the best so far, the last of them was not the best of all, and the best is better than what one
///   action held all the time earns: the policy has learned something, learns no more, and stays where the model was compared with the system; or
/// - `patience` trials in a row gained less than `gain` over the best so far; or
/// - every episode of a trial came within `gain` of the highest return there can be, where that is known.
///
/// After `max_updates` training ends in any case.
///
/// The best policy was chosen by the start states of the trials, which it may suit by luck: before training ends it has to earn as much from others, within
/// `tolerance` and what chance explains; else training goes on, with trials from twice as many start states.
///
/// One agent may end where no small change of its policy gains anything. So where the model is not exact, a policy that is optimal by these rules has to hold against a
/// second agent, which begins with nothing, and whose rollouts begin where the task does and nowhere else. As many trials without gain over the first as the first had in all
/// end training (`patience` at most); else the second takes its place.
///
/// A trial runs the deterministic policy in the model from `trial_episodes` fixed start states. What return would be good enough is no part of the rule:
/// that is for the evaluation, which the learner does not see.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimality {
    /// Updates between two trials.
    pub trial_every: u64,
    /// Start states of a trial.
    pub trial_episodes: usize,
    /// Trials in a row near the best that end training.
    pub settled: usize,
    /// What counts as near, as a share of the best return's magnitude, or of what it is above that of one action held all the time.
    pub tolerance: f64,
    /// Trials without gain that end training, whatever they return.
    pub patience: usize,
    /// What counts as a gain, as a share of the same.
    pub gain: f64,
    /// Updates after which training ends.
    pub max_updates: u64,
}

impl Default for Optimality {
    fn default() -> Self {
        Self {
            trial_every: 250,
            trial_episodes: 32,
            settled: 5,
            tolerance: 0.02,
            patience: 20,
            gain: 0.01,
            max_updates: 60_000,
        }
    }
}

/// Standard errors by which means may differ by chance.
const CHANCE: f64 = 2.0;

/// Times that the start states of trials are doubled, at most.
const MOST_DOUBLINGS: u32 = 5;

/// Mean of `values` and its standard error.
fn mean_of(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt() / n)
}

/// The trials so far and what they say.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Trials {
    best: Option<f64>,
    /// Its standard error over the start states.
    error: f64,
    /// Whether the best can hardly be exceeded.
    perfect: bool,
    /// How far from the data the best goes: 0 for nowhere, 1 for infinitely far all the time.
    far: f64,
    /// The best when patience last began anew.
    reference: Option<f64>,
    without_gain: usize,
    /// Mean return of every trial.
    means: Vec<f64>,
    /// The best return of one action held all the time.
    held: Option<f64>,
    /// Times that the start states were doubled.
    doublings: u32,
    /// Trials that the agent before had, which is as many as this one has to come near.
    before: Option<usize>,
}

impl Trials {
    /// The trials of a policy, where one action held all the time earns at best `held`.
    pub(crate) fn beside(held: Option<f64>) -> Self {
        Self { held, ..Self::default() }
    }

    /// Notes a trial's returns, and how `far` from the data it went; `true` if no mean so far was better. Of equal ones the later counts: it has learned longer. No return can
    /// be above `ceiling`, where that is known.
    pub(crate) fn note(&mut self, rule: &Optimality, (returns, far): (&[f64], f64), ceiling: Option<f64>) -> bool {
        let (mean_return, error) = mean_of(returns);
        // A return that is NaN is no gain.
        let mean_return = if mean_return.is_nan() { f64::NEG_INFINITY } else { mean_return };
        self.means.push(mean_return);
        let is_best = self.best.is_none_or(|best| mean_return >= best);
        if is_best {
            (self.best, self.error, self.far) = (Some(mean_return), error, far);
            let enough = |ceiling: f64| returns.iter().all(|r| *r >= ceiling - rule.gain * ceiling.abs());
            self.perfect = ceiling.is_some_and(enough);
        }
        let gains = self.reference.is_none_or(|r| mean_return - r > rule.gain * self.unit(r));
        if gains {
            self.reference = Some(mean_return);
            self.without_gain = 0;
        } else {
            self.without_gain += 1;
        }
        is_best
    }

    /// Start states of a trial.
    pub(crate) fn episodes(&self, rule: &Optimality) -> usize {
        rule.trial_episodes << self.doublings
    }

    /// Whether the best earned its `return_of_trials` by luck: from other start states it has these `returns`, which are less than chance explains. Then
    /// trials begin anew, from twice as many start states.
    pub(crate) fn was_luck(&mut self, rule: &Optimality, return_of_trials: f64, returns: &[f64]) -> bool {
        let Some(best) = self.best else { return false };
        let (mean, error) = mean_of(returns);
        let less = return_of_trials - mean;
        let luck = self.doublings < MOST_DOUBLINGS
            && less > CHANCE * error.hypot(self.error) + rule.tolerance * self.unit(best);
        if luck {
            *self = Self { doublings: self.doublings + 1, ..self.anew() };
        }
        luck
    }

    /// No trials yet, from as many start states.
    fn anew(&self) -> Self {
        Self { held: self.held, doublings: self.doublings, before: self.before, ..Self::default() }
    }

    /// Those of an agent that is to do better than this one.
    pub(crate) fn of_second(&self) -> Self {
        Self { before: Some(self.means.len()), ..self.anew() }
    }

    /// Whether no policy was tried yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.means.is_empty()
    }

    /// Whether no policy can earn more than the best.
    pub(crate) fn is_perfect(&self) -> bool {
        self.perfect
    }

    /// Grants the full patience again: what was optimal did not hold.
    pub(crate) fn renew(&mut self) {
        self.without_gain = 0;
    }

    /// The difference that the policy made so far: by how much its best return differs from that of one action held all the time.
    pub(crate) fn difference(&self) -> f64 {
        self.best.zip(self.held).map_or(0.0, |(best, held)| (best - held).abs())
    }

    /// What differences of returns are measured by, near the return `at`: its magnitude, or if that is less what it is above that of one action held all the
    /// time. A large constant in the rewards is no measure.
    fn unit(&self, at: f64) -> f64 {
        self.held.map_or(f64::INFINITY, |held| (at - held).abs()).min(at.abs())
    }

    /// Whether the best policy goes far from the data.
    pub(crate) fn is_far(&self) -> bool {
        Trust::is_far(self.far)
    }

    /// Whether `rule` calls the best policy optimal.
    pub(crate) fn optimal(&self, rule: &Optimality) -> bool {
        let Some(best) = self.best else { return false };
        let near = |mean: &f64| *mean >= best - rule.tolerance * self.unit(best);
        // Slow gains too are gains: who was best just now is still learning.
        let gains = self.means.last().is_some_and(|last| *last >= best);
        let settled =
            !gains && self.means.len() >= rule.settled && self.means.iter().rev().take(rule.settled).all(near);
        let learned = self.held.is_none_or(|held| best > held + rule.tolerance * held.abs());
        let patience = self.before.map_or(rule.patience, |before| before.clamp(1, rule.patience.max(1)));
        self.perfect || (settled && learned && !self.is_far()) || self.without_gain >= patience
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule() -> Optimality {
        Optimality {
            trial_every: 1,
            trial_episodes: 1,
            settled: 3,
            tolerance: 0.03,
            patience: 2,
            gain: 0.01,
            max_updates: 100,
        }
    }

    #[test]
    fn small_gains_are_kept_but_do_not_renew_patience() {
        let (rule, mut trials) = (rule(), Trials::default());
        assert!(trials.note(&rule, (&[-200.0], 0.0), None) && !trials.optimal(&rule));
        assert!(trials.note(&rule, (&[-199.5], 0.0), None), "better, so it is kept");
        assert!(!trials.optimal(&rule));
        assert!(!trials.note(&rule, (&[-300.0], 0.0), None));
        assert!(trials.optimal(&rule), "two trials without a gain of 1 %");
        assert!(trials.note(&rule, (&[-150.0], 0.0), None));
        assert!(!trials.optimal(&rule), "a real gain renews patience");
    }

    #[test]
    fn a_second_agent_has_as_many_trials_as_the_first_had_to_gain_something() {
        let (rule, mut first) = (Optimality { patience: 20, ..rule() }, Trials::beside(Some(0.0)));
        for mean in [50.0, 65.0, 64.5, 64.6, 64.4] {
            first.note(&rule, (&[mean], 0.0), None);
        }
        assert!(first.optimal(&rule), "it has settled");
        let mut second = first.of_second();
        assert!(second.note(&rule, (&[65.0], 0.0), None), "the first's policy stands at its beginning");
        for trial in 0..5 {
            assert!(!second.optimal(&rule), "{trial}");
            second.note(&rule, (&[1.0], 0.0), None);
        }
        assert!(second.optimal(&rule), "five trials without a gain are as many as the first had");
        // One that gains goes on as any other.
        second.note(&rule, (&[200.0], 0.0), None);
        assert!(!second.optimal(&rule) && second.best == Some(200.0));
    }

    #[test]
    fn of_equal_trials_the_later_is_kept() {
        let (rule, mut trials) = (rule(), Trials::default());
        assert!(trials.note(&rule, (&[100.0], 0.0), None) && trials.note(&rule, (&[100.0], 0.0), None));
        assert!(!trials.note(&rule, (&[99.0], 0.0), None));
    }

    #[test]
    fn a_policy_that_does_not_change_any_more_needs_less_patience_if_it_has_learned_something() {
        let rule = Optimality { patience: 100, ..rule() };
        let (mut idle, mut trials) = (Trials::beside(Some(99.0)), Trials::beside(Some(20.0)));
        for (mean, settled) in
            [(100.0, false), (40.0, false), (98.0, false), (99.0, false), (98.0, true), (101.0, false)]
        {
            trials.note(&rule, (&[mean], 0.0), None);
            idle.note(&rule, (&[mean], 0.0), None);
            assert_eq!(trials.optimal(&rule), settled, "{mean}");
            assert!(!idle.optimal(&rule), "holding one action earns as much");
        }
    }

    #[test]
    fn what_is_not_earned_from_other_start_states_was_luck() {
        let (rule, mut trials) = (rule(), Trials::default());
        for mean in [97.0, 96.9, 96.8, 96.9] {
            trials.note(&rule, (&[mean + 0.5, mean - 0.5], 0.0), None);
        }
        assert!(trials.optimal(&rule));
        let returns = |failures: usize| -> Vec<f64> {
            (0..100).map(|i| if i < failures { -30.0 } else { 97.0 + f64::from(i as u8 % 2) }).collect()
        };
        assert!(!trials.was_luck(&rule, 97.0, &returns(0)) && trials.optimal(&rule));
        assert!(!trials.was_luck(&rule, 97.0, &returns(1)), "chance explains one of a hundred");
        assert!(trials.was_luck(&rule, 97.0, &returns(10)) && !trials.optimal(&rule), "training goes on");
        assert_eq!(trials.episodes(&rule), 2, "one before");
        assert!(trials.note(&rule, (&[80.0, 90.0], 0.0), None), "what was chosen by luck stands in nobody's way");
    }

    #[test]
    fn the_highest_return_there_can_be_needs_no_patience() {
        let (rule, mut trials) = (rule(), Trials::default());
        trials.note(&rule, (&[100.0, 90.0], 0.0), Some(100.0));
        assert!(!trials.optimal(&rule), "one episode may still gain");
        trials.note(&rule, (&[100.0, 99.5], 0.0), Some(100.0));
        assert!(trials.optimal(&rule));
    }
}
