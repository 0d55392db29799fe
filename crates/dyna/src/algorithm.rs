//! Algorithm 1 of Arora, da Silva and Moss (2022).

use std::sync::Arc;

use sindyna_core::{AgentError, Dataset, Seed, Sensors, Task, TrainedPolicy};

use crate::Schedule;
use crate::gap::Gap;
use crate::predict::Prediction;
use crate::real::Confirmation;
use crate::trust::Trust;

/// Dyna-style learning inside a learned model: warm-up, fit, imagine, improve, and a real rollout now and then.
///
/// # Deviations
/// 1. Imagined rollouts run side by side and are shorter than an episode; some begin anywhere in and around the data
///    ([`Schedule`] says how many). The paper imagines whole episodes from the task's start states.
/// 2. "While π is not optimal" is the rule of [`crate::Optimality`], judged in the model. Where the model is not believed ([`crate::Rollouts`]), the policy
///    that is optimal there has one real episode, which is compared with its prediction; if they differ, the model is fitted again, with that episode
///    among the data, and training starts again.
/// 3. Where a learner gives a posterior, every imagined system follows a model of its own, drawn from it.
///
/// # References
/// Arora, da Silva, Moss (2022), *Model-Based Reinforcement Learning with SINDy*, Algorithm 1.
pub struct Dyna<'a, L: ?Sized> {
    /// What is to be achieved.
    pub task: &'a dyn Task,
    /// What the agent sees of an imagined state.
    pub sensors: &'a Sensors,
    /// Who makes a model of the real data.
    pub learner: &'a L,
    /// How much of what is done.
    pub schedule: &'a Schedule,
    /// Where all randomness comes from.
    pub seed: Seed,
}

/// What a run leaves.
#[derive(Clone)]
pub struct Learned<M> {
    /// All real data, every step and reset.
    pub data: Dataset,
    /// The model fitted last; none for learners that make none.
    pub model: Option<Arc<M>>,
    /// Where the model is believed.
    pub trust: Option<Arc<Trust>>,
    /// The policy that was best in the model; of those with a confirmation episode the one that was confirmed, or the one with the highest return if none
    /// was; none if training ended before a trial.
    pub policy: Option<Arc<dyn TrainedPolicy>>,
    /// What that policy scored in the model.
    pub model_return: Option<f64>,
    /// What it will earn on the system.
    pub prediction: Option<Prediction>,
    /// What to collect next, where the interval of the prediction is wide.
    pub gap: Option<Gap>,
    /// What each planner earned in the model, by name; none where the agent learns.
    pub planned: Vec<(&'static str, f64)>,
    /// Its real episode, where there was one.
    pub confirmation: Option<Confirmation>,
    /// Whether training ended because trials in the model gained no more; how far the policy is from the best there is, it does not tell.
    pub converged: bool,
    /// Updates made.
    pub updates: u64,
    /// Steps imagined.
    pub model_steps: u64,
    /// Imagined rollouts that were ended, for whatever reason.
    pub model_rollouts: u64,
    /// Imagined rollouts cut because the model diverged.
    pub diverged: u64,
    /// Imagined rollouts ended because they went beyond all that the model is followed to.
    pub left_region: u64,
    /// Why no model could be fitted to all real data, if so: the model is one of fewer, in doubt.
    pub refit_failure: Option<String>,
    /// Why training stopped short, if it did; what was learned before is all here.
    pub failure: Option<AgentError>,
    /// Whether somebody stopped it before it was done.
    pub interrupted: bool,
}
