//! Soft actor-critic for numbered actions: the order of an update.

use std::sync::Arc;

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{Agent, AgentError, Batch, Checkpoint, CheckpointError, Mode, Policy, Rng, TrainedPolicy};

use crate::{
    CategoricalPolicy, Isa, IsaError, SacConfig, SacError, Scaling,
    categorical::Categorical,
    checkpoint,
    learner::{Learner, Losses, Widths, shape},
    temperature::Temperature,
};

/// Target entropy in parts of log n, the entropy of a fair draw, where the configuration names none.
const ENTROPY_RATIO: f64 = 0.7;

/// The temperature never rises above so many times its first value.
const HEADROOM: f64 = 10.0;

/// Soft actor-critic for actions 0, 1, …, n - 1, with twin critics and an automatic temperature.
///
/// Critics give a value per action, and expectations over actions are sums, so nothing is drawn. One update on B
/// transitions (o, a, r, o', terminated), with V(o) = Σ π(a|o)(min Q(o, a) - α log π(a|o)):
///
/// 1. temperature: descend log α · (H - H̄), H = mean -Σ π log π; α below is the value before this step;
/// 2. critics: y = r + γ (1 - terminated) V̄(o') with Q̄ in V̄, descend ½ Σᵢ mean (Qᵢ(o, a) - y)²;
/// 3. actor: descend -mean V(o), the critics held;
/// 4. targets: Q̄ ← Q̄ + τ (Q - Q̄).
///
/// Only a terminated step ends the sum of rewards; one that was truncated bootstraps. An action is its number, as an
/// f64.
///
/// # Deviations
/// 1. Deviations of [`Sac`](crate::Sac), all of them.
/// 2. The target entropy H̄ is 0.7 log n where none is set, not 0.98 log n: of two actions the better one could then have
///    a probability of 0.58 on average, too little to achieve much, and the temperature would rise for ever. With 0.7 it
///    is 0.81; with 0.4 cart-pole is learned less steadily.
/// 3. Whatever the target, the temperature never rises above ten times its first value. Entropy counts for the critics
///    too: a higher temperature makes long lives worth more, and that can keep an entropy out of reach which the target
///    seems to allow.
///
/// # References
/// Christodoulou (2019), *Soft Actor-Critic for Discrete Action Settings*, arXiv:1910.07207, Algorithm 1.
#[derive(Debug, Clone)]
pub struct SacDiscrete {
    pub(crate) policy: CategoricalPolicy,
    pub(crate) learner: Learner,
    pub(crate) work: Workspace,
}

/// Memory of an update, kept so that none is allocated anew.
#[derive(Debug, Clone, Default)]
pub(crate) struct Workspace {
    /// Scaled observations (2B, m): those before the steps, then those after.
    observations: Vec<f32>,
    /// π at the observations (2B): those before the steps, then those after.
    choices: Categorical,
    /// Numbers of the actions taken (B).
    taken: Vec<usize>,
    /// Lesser values of the twins (B, n).
    values: Vec<f64>,
}

impl SacDiscrete {
    /// An agent with random networks for observations of `scaling`'s width and `n_actions` actions.
    ///
    /// # Errors
    /// [`SacError`] if a setting, the scaling or the number of actions is unusable.
    pub fn new(config: SacConfig, scaling: Scaling, n_actions: usize, rng: &mut Rng) -> Result<Self, SacError> {
        if n_actions < 2 {
            return Err(SacError::Setting { name: "n_actions", value: n_actions as f64, wanted: "at least 2" });
        }
        let widths = Widths { head: n_actions, critic_input: scaling.width(), critic_output: n_actions };
        let temperature = Temperature::new(&config, ENTROPY_RATIO * (n_actions as f64).ln())
            .at_most(HEADROOM * config.initial_temperature);
        let (net, learner) = Learner::new(config, scaling, &widths, temperature, rng)?;
        Ok(Self { policy: CategoricalPolicy { net }, learner, work: Workspace::default() })
    }

    /// The same agent, its updates pinned to the instructions `isa` instead of the widest the machine has.
    ///
    /// # Errors
    /// [`IsaError::Missing`] if the machine lacks them.
    pub fn with_isa(mut self, isa: Isa) -> Result<Self, IsaError> {
        self.learner.set_isa(isa.checked()?);
        Ok(self)
    }

    /// The instructions updates run with: what to record beside a seed.
    #[must_use]
    pub fn isa(&self) -> Isa {
        self.learner.pass.isa
    }

    /// Updates made so far.
    #[must_use]
    pub fn updates(&self) -> u64 {
        self.learner.updates
    }

    /// The settings the agent was made with.
    #[must_use]
    pub fn config(&self) -> &SacConfig {
        &self.learner.config
    }

    /// The entropy weight α.
    #[must_use]
    pub fn temperature(&self) -> f64 {
        self.learner.temperature.value()
    }

    fn check(&mut self, batch: &Batch) -> Result<(), AgentError> {
        self.learner.check(batch, self.policy.observation_dim(), 1)?;
        let n = self.policy.n_actions() as f64;
        self.work.taken.clear();
        let numbers = batch.actions.iter().filter(|a| (0.0..n).contains(*a) && a.fract() == 0.0);
        self.work.taken.extend(numbers.map(|a| *a as usize));
        shape("rows that hold the number of an action", batch.len(), self.work.taken.len())
    }

    /// Mean entropy of π at the observations before the steps.
    fn entropy(&self, rows: usize) -> f64 {
        self.work.choices.rows().take(rows).map(|c| c.entropy()).sum::<f64>() / rows as f64
    }

    /// The soft Bellman targets y (B) of step 2.
    fn compute_targets(&mut self, batch: &Batch, temperature: f64) {
        let (rows, m, n) = (batch.len(), self.policy.observation_dim(), self.policy.n_actions());
        let Self { learner, work, .. } = self;
        learner.lesser_target_values(&work.observations[rows * m..], rows, &mut work.values);
        let next = work.choices.rows().skip(rows).zip(work.values.chunks_exact(n));
        learner.set_targets(batch, next.map(|(choice, values)| choice.soft_value(values, temperature)));
    }

    /// Step 3; returns the actor's loss.
    fn improve_actor(&mut self, rows: usize, temperature: f64) -> Result<f64, AgentError> {
        let (m, n) = (self.policy.observation_dim(), self.policy.n_actions());
        let Self { policy, learner, work } = self;
        learner.lesser_values(&work.observations[..rows * m], rows, &mut work.values);
        let mut sum = 0.0;
        learner.d_heads.clear();
        for (choice, values) in work.choices.rows().zip(work.values.chunks_exact(n)) {
            sum += choice.soft_value(values, temperature);
            let slopes = choice.slopes(values, temperature);
            learner.d_heads.extend(slopes.map(|slope| (-slope / rows as f64) as f32));
        }
        let loss = -sum / rows as f64;
        learner.finite("the actor's loss", loss)?;
        learner.improve_actor(&mut policy.net, &work.observations);
        Ok(loss)
    }
}

impl Policy for SacDiscrete {
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        self.policy.act_batch(observations, mode, rng, actions);
    }
}

impl SacDiscrete {
    /// One update; batches of any size fit. Draws no random number.
    ///
    /// # Errors
    /// [`AgentError::Shape`] if the batch is empty, of other widths than the agent's, or holds an action that is none;
    /// [`AgentError::NotFinite`] before a network takes a step on a loss that is no number.
    pub fn update(&mut self, batch: &Batch, _rng: &mut Rng) -> Result<Losses, AgentError> {
        self.check(batch)?;
        let (rows, m, n) = (batch.len(), self.policy.observation_dim(), self.policy.n_actions());
        let heads = self.learner.heads(&self.policy.net, batch, &mut self.work.observations);
        self.work.choices.load(heads, n);

        let temperature = self.temperature();
        let entropy = self.entropy(rows);
        self.learner.finite("the entropy", entropy)?;
        self.learner.temperature.step(-entropy);

        self.compute_targets(batch, temperature);
        let observations = &self.work.observations[..rows * m];
        let critic = self.learner.improve_critics(observations, self.work.taken.iter().copied())?;
        let actor = self.improve_actor(rows, temperature)?;
        let temperature = self.temperature();
        Ok(self.learner.count(Losses { critic, actor, temperature, entropy }))
    }

    /// The policy with its weights averaged over updates, without what only learning needs.
    #[must_use]
    pub fn frozen(&self) -> CategoricalPolicy {
        CategoricalPolicy { net: self.learner.averaged(&self.policy.net) }
    }
}

impl Checkpoint for SacDiscrete {
    fn save(&self) -> Vec<u8> {
        checkpoint::save(&self.learner, &self.policy.net)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        checkpoint::restore(&mut self.learner, &mut self.policy.net, saved)
    }
}

impl Agent for SacDiscrete {
    fn name(&self) -> &'static str {
        "sac-discrete"
    }

    fn expect(&mut self, observations: &[(f64, f64)]) {
        if observations.len() == self.policy.observation_dim() {
            self.policy.net.scaling = Scaling::standard(observations);
        }
    }

    fn learn(&mut self, batch: &Batch, rng: &mut Rng) -> Result<(), AgentError> {
        self.update(batch, rng).map(|_| ())
    }

    fn metrics(&self) -> Vec<(&'static str, f64)> {
        self.learner.losses.map_or_else(Vec::new, Losses::named)
    }

    fn policy(&self) -> Arc<dyn TrainedPolicy> {
        Arc::new(self.frozen())
    }

    fn read_policy(&self, bytes: &[u8]) -> Result<Arc<dyn TrainedPolicy>, CheckpointError> {
        let policy = CategoricalPolicy::from_safetensors(bytes).map_err(|e| CheckpointError::new(e.to_string()))?;
        Ok(Arc::new(policy))
    }
}
