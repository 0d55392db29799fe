//! When to stop improving: the rule behind "while π is not optimal" of Algorithm 1.

/// A policy is optimal in the model when `patience` trials in a row gained less than `tolerance` over the best so
/// far, and that best reaches `target` where one is declared. A best that reaches it in every episode of its trial, not only on
/// average, needs no more than `patience_when_sure`. After `max_updates` training ends in any case.
///
/// A trial runs the deterministic policy in the model from `trial_episodes` fixed start states.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimality {
    /// Updates between two trials.
    pub trial_every: u64,
    /// Start states of a trial.
    pub trial_episodes: usize,
    /// Trials without gain that end training.
    pub patience: usize,
    /// The same once the best reached `target` in every episode of its trial.
    pub patience_when_sure: usize,
    /// What counts as a gain, as a share of the best return's magnitude.
    pub tolerance: f64,
    /// Mean return below which the best is not good enough to stop, whatever the patience.
    pub target: Option<f64>,
    /// Updates after which training ends.
    pub max_updates: u64,
}

/// The trials so far and what they say.
#[derive(Debug, Clone)]
pub(crate) struct Trials<'a> {
    rule: &'a Optimality,
    best: Option<f64>,
    /// Whether the best reached the target in every episode.
    sure: bool,
    /// The best when patience last began anew.
    reference: Option<f64>,
    without_gain: usize,
}

impl<'a> Trials<'a> {
    pub(crate) fn new(rule: &'a Optimality) -> Self {
        Self { rule, best: None, sure: false, reference: None, without_gain: 0 }
    }

    /// Notes a trial's returns; `true` if no mean so far was better. Of equal ones the later counts: it has learned longer.
    pub(crate) fn note(&mut self, returns: &[f64]) -> bool {
        let mean_return = returns.iter().sum::<f64>() / returns.len() as f64;
        // A return that is no number is no gain.
        let mean_return = if mean_return.is_nan() { f64::NEG_INFINITY } else { mean_return };
        let is_best = self.best.is_none_or(|best| mean_return >= best);
        if is_best {
            self.best = Some(mean_return);
            self.sure = self.rule.target.is_some_and(|target| returns.iter().all(|r| *r >= target));
        }
        let gains = self.reference.is_none_or(|r| mean_return - r > self.rule.tolerance * r.abs());
        if gains {
            self.reference = Some(mean_return);
            self.without_gain = 0;
        } else {
            self.without_gain += 1;
        }
        is_best
    }

    /// The rule the trials are judged by.
    pub(crate) fn rule(&self) -> &'a Optimality {
        self.rule
    }

    /// Grants the full patience again: what was optimal did not hold.
    pub(crate) fn renew(&mut self) {
        self.without_gain = 0;
    }

    /// The best mean return so far.
    pub(crate) fn best(&self) -> Option<f64> {
        self.best
    }

    /// Whether the rule calls the best policy optimal.
    pub(crate) fn optimal(&self) -> bool {
        let good_enough = match (self.best, self.rule.target) {
            (Some(best), Some(target)) => best >= target,
            (best, _) => best.is_some(),
        };
        let Optimality { patience, patience_when_sure, .. } = *self.rule;
        good_enough && self.without_gain >= if self.sure { patience.min(patience_when_sure) } else { patience }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(target: Option<f64>) -> Optimality {
        Optimality {
            trial_every: 1,
            trial_episodes: 1,
            patience: 2,
            patience_when_sure: 1,
            tolerance: 0.01,
            target,
            max_updates: 100,
        }
    }

    #[test]
    fn small_gains_are_kept_but_do_not_renew_patience() {
        let rule = rule(None);
        let mut trials = Trials::new(&rule);
        assert!(trials.note(&[-200.0]) && !trials.optimal());
        assert!(trials.note(&[-199.5]), "better, so it is kept");
        assert!(!trials.optimal());
        assert!(!trials.note(&[-300.0]));
        assert!(trials.optimal(), "two trials without a gain of 1 %");
        assert_eq!(trials.best(), Some(-199.5));
        assert!(trials.note(&[-150.0]));
        assert!(!trials.optimal(), "a real gain renews patience");
    }

    #[test]
    fn of_equal_trials_the_later_is_kept() {
        let rule = rule(Some(90.0));
        let mut trials = Trials::new(&rule);
        assert!(trials.note(&[100.0]) && trials.note(&[100.0]) && !trials.note(&[99.0]));
    }

    #[test]
    fn below_the_target_nothing_is_optimal() {
        let rule = rule(Some(90.0));
        let mut trials = Trials::new(&rule);
        for _ in 0..10 {
            trials.note(&[0.0]);
        }
        assert!(!trials.optimal());
        trials.note(&[85.0, 105.0]);
        trials.note(&[85.0, 105.0]);
        assert!(!trials.optimal(), "one trial without gain is enough only for a best that never fails");
        trials.note(&[85.0, 105.0]);
        assert!(trials.optimal());
    }

    #[test]
    fn a_best_that_reaches_the_target_in_every_episode_needs_less_patience() {
        let rule = rule(Some(90.0));
        let mut trials = Trials::new(&rule);
        trials.note(&[91.0, 105.0]);
        assert!(!trials.optimal());
        trials.note(&[80.0, 80.0]);
        assert!(trials.optimal());
    }
}
