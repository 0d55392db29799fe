//! How much of what is done, and in which order: an algorithm as a value.

use crate::Optimality;

/// N of Algorithm 1: how long a policy is improved in the model before the real system is asked again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rollouts {
    /// So many imagined rollouts. A policy that is optimal in the model has one real episode to keep what the model promises.
    Count(u64),
    /// As many as it takes: the model is trusted until the policy is optimal in it, and the real system is not asked again.
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
    /// N_e: rollouts on the real system before anything is learned.
    pub warmup_rollouts: usize,
    /// R: real steps of each of them.
    pub rollout_len: usize,
    /// N: imagined rollouts per real one.
    pub imagined_rollouts: Rollouts,
    /// Whether the model is fitted anew after every real rollout.
    pub refit: Refit,
    /// Imagined systems stepped side by side.
    pub worlds: usize,
    /// Steps after which an imagined rollout is cut and begun anew elsewhere.
    pub imagined_len: usize,
    /// Share of imagined rollouts that begin anywhere in and around the data instead of where the task begins, 0 to 1.
    pub scattered_starts: f64,
    /// Imagined steps with uniformly random actions before the first update.
    pub random_steps: usize,
    /// Updates for every imagined step of all worlds together.
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
