//! Learning while acting on the system: model-free, or with a model that adds to the data.

mod branch;
mod schedule;
mod turns;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sindyna_core::{Agent, AgentError, DynamicsLearner, Environment, Explorer, Seed, Sensors, Task, TrainedPolicy};

use crate::algorithm::DynaError;
pub use schedule::{Branches, Checks, OnlineSchedule};
pub use turns::{OnlineLoop, OnlinePhase};

/// Acts, learns and fits in turn, one real step at a time.
///
/// With [`NoModel`](sindyna_core::NoModel) this is off-policy learning from real data alone; with a learner and
/// [`Branches`] it is MBPO, whatever the model is made of.
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

impl<L: DynamicsLearner + ?Sized> Online<'_, L> {
    /// Learning with `agent`, to be advanced step by step.
    ///
    /// # Errors
    /// [`DynaError`] if no run can have the schedule, or if rollouts are to branch off from states that are not seen.
    pub fn begin(&self, agent: Box<dyn Agent>) -> Result<OnlineLoop<'_, L>, DynaError> {
        self.schedule.check()?;
        OnlineLoop::new(self, agent)
    }

    /// The loop that was `saved` by [`OnlineLoop::save`], with a system, an explorer and an agent made as those were. It goes on with the same bits, if task,
    /// sensors, learner, schedule and seed are the same; models that the learner does not write down are fitted again.
    ///
    /// # Errors
    /// [`DynaError::Checkpoint`] if the bytes are of something else, [`DynaError::Fit`] if a fit was told to stop.
    pub fn resume(
        &self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        agent: Box<dyn Agent>,
        saved: &[u8],
    ) -> Result<OnlineLoop<'_, L>, DynaError> {
        let mut begun = self.begin(agent)?;
        begun.restore(env, explorer, saved)?;
        Ok(begun)
    }

    /// Learns on the system `env`; checks are on `judges`, systems of the same kind. `interrupted` is asked often whether to stop.
    ///
    /// # Errors
    /// [`DynaError`] if no run can have the schedule, a system fails or a model cannot be fitted.
    pub fn run<E: Environment>(
        &self,
        env: &mut dyn Environment,
        judges: &mut [E],
        explorer: &mut dyn Explorer,
        agent: Box<dyn Agent>,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Practised<L::Model>, DynaError> {
        let mut begun = self.begin(agent)?;
        while !begun.has_ended() && !interrupted() {
            begun.advance(env, judges, explorer)?;
        }
        Ok(begun.finish())
    }
}
