//! Who chooses actions, and who learns to.

use std::sync::Arc;

use ndarray::{ArrayView2, ArrayViewMut2};

use crate::{Batch, Checkpoint, CheckpointError, Dataset, Dynamics, Rng};

/// Whether to look for something new or to do what is best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Draw from the policy's distribution.
    Explore,
    /// The policy's best action; draws no random number.
    Exploit,
}

/// A map from observations to actions, or a way to begin one: see [`Self::begin`].
pub trait Policy: Send + Sync {
    /// Writes the actions (B, action values) for `observations` (B, m), in the units of the action space. A policy with a memory takes each of them for
    /// the first of an episode.
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>);

    /// [`Self::act_batch`] for a single observation.
    fn act(&self, observation: &[f64], mode: Mode, rng: &mut Rng, action: &mut [f64]) {
        let observations = ArrayView2::from_shape((1, observation.len()), observation).expect("a slice is one row");
        let width = action.len();
        let actions = ArrayViewMut2::from_shape((1, width), action).expect("a slice is one row");
        self.act_batch(observations, mode, rng, actions);
    }

    /// What acts in an episode that begins now; `None` for a policy without a memory, which is [`Self::act_batch`] and no more.
    fn begin(&self) -> Option<Box<dyn Memory + '_>> {
        None
    }
}

/// A shared policy is the same policy.
impl<P: Policy + ?Sized> Policy for Arc<P> {
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        (**self).act_batch(observations, mode, rng, actions);
    }

    fn act(&self, observation: &[f64], mode: Mode, rng: &mut Rng, action: &mut [f64]) {
        (**self).act(observation, mode, rng, action);
    }

    fn begin(&self) -> Option<Box<dyn Memory + '_>> {
        (**self).begin()
    }
}

/// A borrowed policy is the same policy.
impl<P: Policy + ?Sized> Policy for &P {
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        (**self).act_batch(observations, mode, rng, actions);
    }

    fn act(&self, observation: &[f64], mode: Mode, rng: &mut Rng, action: &mut [f64]) {
        (**self).act(observation, mode, rng, action);
    }

    fn begin(&self) -> Option<Box<dyn Memory + '_>> {
        (**self).begin()
    }
}

/// A policy in the middle of an episode, with what it keeps in mind: a plan, say.
pub trait Memory: Send {
    /// Writes the next action for the next `observation` (m) of the episode.
    fn act(&mut self, observation: &[f64], mode: Mode, rng: &mut Rng, action: &mut [f64]);
}

/// Any policy for the length of an episode.
pub struct Acting<'a> {
    policy: &'a dyn Policy,
    memory: Option<Box<dyn Memory + 'a>>,
}

impl<'a> Acting<'a> {
    /// `policy` at the start of an episode.
    #[must_use]
    pub fn begin(policy: &'a dyn Policy) -> Self {
        Self { policy, memory: policy.begin() }
    }
}

impl Memory for Acting<'_> {
    fn act(&mut self, observation: &[f64], mode: Mode, rng: &mut Rng, action: &mut [f64]) {
        match &mut self.memory {
            Some(memory) => memory.act(observation, mode, rng, action),
            None => self.policy.act(observation, mode, rng, action),
        }
    }
}

/// A policy that was learned, and can be kept.
pub trait TrainedPolicy: Policy {
    /// The policy as a file in the format of its kind, with all that is needed to act.
    fn to_bytes(&self) -> Vec<u8>;
}

/// Why an update was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AgentError {
    /// The batch does not fit the agent.
    #[error("batch has {got} {what}, expected {expected}")]
    Shape {
        /// What is counted.
        what: &'static str,
        /// Number wanted.
        expected: usize,
        /// Number found.
        got: usize,
    },
    /// A loss is no longer finite; the parameters are not to be used.
    #[error("{what} is {value} after {updates} updates: training diverged")]
    NotFinite {
        /// Which loss.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Updates made so far.
        updates: u64,
    },
}

/// A policy that improves from batches of transitions. Its [`Checkpoint`] holds all that it has learned and learns with.
pub trait Agent: Policy + Checkpoint {
    /// Name of the algorithm.
    fn name(&self) -> &'static str;

    /// Told once, before the first update: mean and standard deviation of each observation (m) to be expected. Agents that do not scale what they
    /// see may ignore it.
    fn expect(&mut self, _observations: &[(f64, f64)]) {}

    /// One update on `batch`.
    ///
    /// # Errors
    /// [`AgentError`] if the batch does not fit, or a loss is not finite.
    fn learn(&mut self, batch: &Batch, rng: &mut Rng) -> Result<(), AgentError>;

    /// What the last update has to tell, by name: losses, say.
    fn metrics(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// Whether its policies are planned in a model, by [`Self::plan`], instead of learned.
    fn plans(&self) -> bool {
        false
    }

    /// Policies in `model` that need no update, with their names, the quickest first: those of planners, for measurements of the states with errors of the
    /// standard deviations `noise` (n; none for exact ones). None for agents that learn.
    fn plan(&self, _model: &Arc<dyn Dynamics>, _noise: &[f64]) -> Vec<(&'static str, Arc<dyn TrainedPolicy>)> {
        Vec::new()
    }

    /// A copy of the policy as it is now, without what only learning needs.
    fn policy(&self) -> Arc<dyn TrainedPolicy>;

    /// The policy of such an agent, from [`TrainedPolicy::to_bytes`].
    ///
    /// # Errors
    /// [`CheckpointError`] if the bytes are no such policy.
    fn read_policy(&self, bytes: &[u8]) -> Result<Arc<dyn TrainedPolicy>, CheckpointError>;
}

/// Chooses the actions of the warm-up rollouts, before any policy is worth following.
pub trait Explorer: Checkpoint + Send {
    /// Writes the next action, given all that was recorded so far.
    fn next(&mut self, so_far: &Dataset, rng: &mut Rng, action: &mut [f64]);
}
