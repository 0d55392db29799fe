//! How much of what is done, and in which order: an algorithm as a value.

use crate::Optimality;

/// N of Algorithm 1: how long a policy is improved in the model before the system is asked again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rollouts {
    /// So many imagined rollouts. A policy that is optimal in the model has one real episode, which is compared with its prediction.
    Count(u64),
    /// As many as it takes: the model is trusted until the policy is optimal in it, and the system is not asked again.
    Unlimited,
    /// Unlimited where the model explains the data down to rounding; elsewhere until the policy is optimal in the model, which one real
    /// episode then has to confirm.
    Auto,
}

/// Whether a model changes when more real data come in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refit {
    /// The model of the warm-up stays (the paper's setting).
    Never,
    /// It is fitted anew to all real data after every real rollout.
    AfterRollouts,
}

/// The hyper-parameters of Algorithm 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// N_e: rollouts on the system before anything is learned.
    pub warmup_rollouts: usize,
    /// R: real steps of each of them.
    pub rollout_len: usize,
    /// Whether a run that asks the system by itself ([`Rollouts::Auto`]) chooses what to collect by what the models that the data allow disagree on: the second half of
    /// the first steps, and all that it collects later. Else the explorer does.
    pub curious: bool,
    /// N: imagined rollouts per real one.
    pub imagined_rollouts: Rollouts,
    /// Whether the model is fitted anew after every real rollout.
    pub refit: Refit,
    /// Imagined systems stepped side by side.
    pub systems: usize,
    /// Steps after which an imagined rollout is cut and begun anew elsewhere.
    pub imagined_len: usize,
    /// Share of imagined rollouts that begin anywhere in and around the data instead of where the task begins, 0 to 1.
    pub scattered_starts: f64,
    /// Imagined steps with uniformly random actions before the first update.
    pub random_steps: usize,
    /// Updates for every imagined step of all systems together.
    pub updates_per_turn: usize,
    /// Transitions in one update.
    pub batch_size: usize,
    /// Transitions remembered.
    pub replay_capacity: usize,
    /// Real steps that may be made in all; an episode that might go beyond is not begun. `None` for as many as it takes.
    pub max_real_steps: Option<usize>,
    /// Discount of the value charged for leaving all that the model is followed to; the agent's own.
    pub discount: f64,
    /// When a policy counts as optimal in the model.
    pub optimality: Optimality,
}

impl Schedule {
    /// What `sindyna train` does by default where episodes have at most `max_steps`: ten real steps, [`Rollouts::Auto`], a new model after every real rollout.
    #[must_use]
    pub fn new(max_steps: usize) -> Self {
        Self {
            warmup_rollouts: 1,
            rollout_len: 10,
            curious: true,
            imagined_rollouts: Rollouts::Auto,
            refit: Refit::AfterRollouts,
            systems: 32,
            imagined_len: max_steps.min(200),
            scattered_starts: 0.5,
            random_steps: 5_000,
            updates_per_turn: 8,
            batch_size: 128,
            replay_capacity: 200_000,
            max_real_steps: None,
            discount: 1.0 - 1.0 / (max_steps as f64).clamp(100.0, 1000.0),
            optimality: Optimality::default(),
        }
    }

    /// Refuses what would hang, panic or give no numbers.
    ///
    /// # Errors
    /// [`ScheduleError`] with the first setting that is out of its range.
    pub fn check(&self) -> Result<(), ScheduleError> {
        let rule = &self.optimality;
        let counts = [
            ("warmup_rollouts", self.warmup_rollouts),
            ("rollout_len", self.rollout_len),
            ("systems", self.systems),
            ("imagined_len", self.imagined_len),
            ("updates_per_turn", self.updates_per_turn),
            ("batch_size", self.batch_size),
            ("replay_capacity", self.replay_capacity),
            ("optimality.trial_every", usize::try_from(rule.trial_every).unwrap_or(usize::MAX)),
            ("optimality.trial_episodes", rule.trial_episodes),
            ("optimality.settled", rule.settled),
            ("optimality.patience", rule.patience),
        ];
        if let Some((name, _)) = counts.iter().find(|(_, count)| *count == 0) {
            return Err(ScheduleError { name, value: 0.0, wanted: "at least 1" });
        }
        if self.imagined_rollouts == Rollouts::Count(0) {
            return Err(ScheduleError { name: "imagined_rollouts", value: 0.0, wanted: "at least 1" });
        }
        let shares = [
            ("scattered_starts", self.scattered_starts, 0.0..=1.0, "in 0..=1"),
            ("discount", self.discount, 0.0..=1.0 - f64::EPSILON, "at least 0 and below 1"),
            ("optimality.tolerance", rule.tolerance, 0.0..=f64::MAX, "finite and at least 0"),
            ("optimality.gain", rule.gain, 0.0..=f64::MAX, "finite and at least 0"),
        ];
        match shares.into_iter().find(|(_, value, range, _)| !range.contains(value)) {
            Some((name, value, _, wanted)) => Err(ScheduleError { name, value, wanted }),
            None => Ok(()),
        }
    }
}

/// A setting that no run can have.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} must be {wanted}, got {value}")]
pub struct ScheduleError {
    /// Name of the setting.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What it must be.
    pub wanted: &'static str,
}
