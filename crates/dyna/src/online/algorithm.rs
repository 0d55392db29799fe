//! What learning while acting is made of, and what it leaves.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sindyna_core::{AgentError, Seed, Sensors, Task, TrainedPolicy};

use super::schedule::OnlineSchedule;

/// Acts, learns and fits in turn, one real step at a time.
///
/// With [`NoModel`](sindyna_core::NoModel) this is off-policy learning from real data alone; with a learner and
/// [`Branches`](crate::Branches) it is MBPO, whatever the model is made of.
///
/// # Deviations
/// Janner et al. predict rewards with the model; here the task pays, as everywhere in this program. Their rollouts may grow
/// longer with time; here the length is fixed.
///
/// # References
/// Janner, Fu, Zhang, Levine (2019), *When to Trust Your Model: Model-Based Policy Optimization*, Algorithm 2.
pub struct Online<'a, L: ?Sized> {
    /// What is to be achieved.
    pub task: &'a dyn Task,
    /// What is seen of a state, and what state is seen.
    pub sensors: &'a Sensors,
    /// Who makes a model of the real data.
    pub learner: &'a L,
    /// How much of what is done.
    pub schedule: &'a OnlineSchedule,
    /// Where all randomness comes from.
    pub seed: Seed,
}

/// How good the policy was after so many real steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Real steps so far.
    pub real_steps: usize,
    /// Updates so far.
    pub updates: u64,
    /// Return of every episode.
    pub returns: Vec<f64>,
}

impl Check {
    /// Mean return.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.returns.iter().sum::<f64>() / self.returns.len().max(1) as f64
    }
}

/// What a run leaves.
#[derive(Clone)]
pub struct Practised<M> {
    /// The policy after the last real step.
    pub policy: Arc<dyn TrainedPolicy>,
    /// The model fitted last.
    pub model: Option<Arc<M>>,
    /// Real steps made.
    pub real_steps: usize,
    /// Resets of the system.
    pub real_episodes: usize,
    /// Updates made.
    pub updates: u64,
    /// Steps imagined.
    pub model_steps: u64,
    /// Imagined rollouts cut because the model diverged.
    pub diverged: u64,
    /// The learning curve.
    pub checks: Vec<Check>,
    /// Whether a check reached what the run was to go on until.
    pub reached: bool,
    /// Why learning stopped short, if it did.
    pub failure: Option<AgentError>,
    /// Whether somebody stopped it before it was done.
    pub interrupted: bool,
}
