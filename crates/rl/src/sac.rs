//! Soft actor-critic: the order of an update.

use std::sync::Arc;

use ndarray::{ArrayView2, ArrayViewMut2};
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Agent, AgentError, Batch, Checkpoint, CheckpointError, Mode, Policy, Rng, TrainedPolicy};

use crate::{
    GaussianPolicy, Isa, IsaError, SacConfig, SacError, Scaling, checkpoint,
    columns::Columns,
    gaussian::Squashed,
    interface::ActionRange,
    learner::{Learner, Losses, Widths, lesser, shape},
    temperature::Temperature,
};

/// Soft actor-critic with twin critics and an automatic temperature, for continuous actions.
///
/// One update on B transitions (o, a, r, o', terminated), a' ~ π(o'), ã ~ π(o), both with fresh noise:
///
/// 1. temperature: descend -log α · mean(log π(ã|o) + H̄); α below is the value before this step;
/// 2. critics: y = r + γ (1 - terminated)(min Q̄(o', a') - α log π(a'|o')), descend ½ Σᵢ mean (Qᵢ(o, a) - y)²;
/// 3. actor: descend mean(α log π(ã|o) - min Q(o, ã));
/// 4. targets: Q̄ ← Q̄ + τ (Q - Q̄).
///
/// Only a terminated step ends the sum of rewards; one that was truncated bootstraps. Actions are in the units of the
/// action space, and count as the nearest end where they lie beyond it; densities are those of the action in -1..1.
///
/// # Deviations
/// 1. Observations are scaled inside the agent; rewards are multiplied by `reward_scale`.
/// 2. Step 4 is taken together with step 2, which gives the same numbers, since step 3 uses no target.
/// 3. The order of the steps is Stable-Baselines3's (2.9), not the paper's.
///
/// # References
/// Haarnoja et al. (2018), *Soft Actor-Critic Algorithms and Applications*, arXiv:1812.05905, Algorithm 1.
#[derive(Debug, Clone)]
pub struct Sac {
    pub(crate) policy: GaussianPolicy,
    pub(crate) learner: Learner,
    pub(crate) work: Workspace,
}

/// Memory of an update, kept so that none is allocated anew.
#[derive(Debug, Clone, Default)]
pub(crate) struct Workspace {
    /// Scaled observations (2B, m): those before the steps, then those after.
    observations: Vec<f32>,
    /// Critics' inputs (B, m + k): observations before the steps, and any actions.
    inputs: Vec<f32>,
    /// The same with observations after the steps.
    next_inputs: Vec<f32>,
    noise: Vec<f64>,
    pub(crate) drawn: Squashed,
    values: Vec<f64>,
    /// Rows in which each critic has the lesser value.
    lesser_rows: [Vec<usize>; 2],
    d_actions: Vec<f32>,
}

impl Sac {
    /// An agent with random networks for observations of `scaling`'s width and actions in `action_low..=action_high`.
    ///
    /// # Errors
    /// [`SacError`] if a setting, the scaling or the action range is unusable.
    pub fn new(
        config: SacConfig,
        scaling: Scaling,
        action_low: &[f64],
        action_high: &[f64],
        rng: &mut Rng,
    ) -> Result<Self, SacError> {
        let range = ActionRange::new(action_low, action_high)?;
        let k = range.width();
        let widths = Widths { head: 2 * k, critic_input: scaling.width() + k, critic_output: 1 };
        let temperature = Temperature::new(&config, -(k as f64));
        let (net, learner) = Learner::new(config, scaling, &widths, temperature, rng)?;
        Ok(Self { policy: GaussianPolicy { net, range }, learner, work: Workspace::default() })
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

    /// [`Self::update`] with given standard normal numbers: (2B, k) values, those of ã first, then those of a'.
    ///
    /// # Errors
    /// As [`Self::update`]; [`AgentError::Shape`] also if `noise` has not 2Bk values.
    pub fn update_with_noise(&mut self, batch: &Batch, noise: &[f64]) -> Result<Losses, AgentError> {
        let (rows, k) = (batch.len(), self.policy.action_dim());
        self.learner.check(batch, self.policy.observation_dim(), k)?;
        shape("noise values", 2 * rows * k, noise.len())?;
        let heads = self.learner.heads(&self.policy.net, batch, &mut self.work.observations);
        self.work.drawn.draw(heads, noise, k);

        let temperature = self.temperature();
        let mean_log_prob = mean(&self.work.drawn.log_probs[..rows]);
        self.learner.finite("the entropy", mean_log_prob)?;
        self.learner.temperature.step(mean_log_prob);

        self.compute_targets(batch, temperature);
        let critic = self.improve_critics(batch)?;
        let actor = self.improve_actor(rows, temperature, mean_log_prob)?;
        let temperature = self.temperature();
        Ok(self.learner.count(Losses { critic, actor, temperature, entropy: -mean_log_prob }))
    }

    /// The soft Bellman targets y (B) of step 2.
    fn compute_targets(&mut self, batch: &Batch, temperature: f64) {
        let (rows, m, k) = (batch.len(), self.policy.observation_dim(), self.policy.action_dim());
        let Self { learner, work, .. } = self;
        work.next_inputs.resize(rows * (m + k), 0.0);
        let mut columns = Columns { table: &mut work.next_inputs, width: m + k };
        columns.copy(0, &work.observations[rows * m..], m);
        columns.copy(m, &work.drawn.actions[rows * k..], k);
        learner.lesser_target_values(&work.next_inputs, rows, &mut work.values);
        let values = work.values.iter().zip(&work.drawn.log_probs[rows..]);
        learner.set_targets(batch, values.map(|(q, log_prob)| q - temperature * log_prob));
    }

    /// Steps 2 and 4; returns the critics' loss.
    fn improve_critics(&mut self, batch: &Batch) -> Result<f64, AgentError> {
        let (rows, m, k) = (batch.len(), self.policy.observation_dim(), self.policy.action_dim());
        let Self { policy, learner, work } = self;
        work.inputs.resize(rows * (m + k), 0.0);
        let mut columns = Columns { table: &mut work.inputs, width: m + k };
        columns.copy(0, &work.observations[..rows * m], m);
        policy.range.to_network(batch.actions.view(), &mut columns, m);
        learner.improve_critics(&work.inputs, std::iter::repeat(0))
    }

    /// Step 3; returns the actor's loss.
    fn improve_actor(&mut self, rows: usize, temperature: f64, mean_log_prob: f64) -> Result<f64, AgentError> {
        let (m, k) = (self.policy.observation_dim(), self.policy.action_dim());
        let Self { policy, learner, work } = self;
        // The observations are still there.
        Columns { table: &mut work.inputs, width: m + k }.copy(m, &work.drawn.actions[..rows * k], k);
        let [first, second] = &mut learner.critics;
        let (q1, q2) = (first.values(&work.inputs, rows), second.values(&work.inputs, rows));

        let mut sum = 0.0;
        // In any update all rows may be of one critic.
        work.lesser_rows.iter_mut().for_each(|rows_of| rows_of.resize(rows, 0));
        let mut counts = [0; 2];
        for (row, (q1, q2)) in q1.iter().zip(q2).enumerate() {
            sum += f64::from(lesser(*q1, *q2));
            // Which critic it is cannot be guessed, so nothing here branches on it.
            let second = usize::from(q1 > q2);
            for (rows_of, count) in work.lesser_rows.iter_mut().zip(counts) {
                rows_of[count] = row;
            }
            counts[second] += 1;
        }
        for (rows_of, count) in work.lesser_rows.iter_mut().zip(counts) {
            rows_of.truncate(count);
        }
        let loss = temperature * mean_log_prob - sum / rows as f64;
        learner.finite("the actor's loss", loss)?;

        // Of the twins only the one with the lesser value passes a gradient, so each goes back over its own rows.
        work.d_actions.resize(rows * k, 0.0);
        for (critic, rows_of) in learner.critics.iter_mut().zip(&work.lesser_rows) {
            let gradients = critic.input_gradients(rows_of, -1.0 / rows as f32, &mut learner.deltas, m);
            for (row, d) in rows_of.iter().zip(gradients.chunks_exact(k)) {
                work.d_actions[row * k..(row + 1) * k].copy_from_slice(d);
            }
        }
        work.drawn.backward(&work.d_actions, temperature / rows as f64, k, &mut learner.d_heads);
        learner.improve_actor(&mut policy.net, &work.observations);
        Ok(loss)
    }
}

impl Policy for Sac {
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        self.policy.act_batch(observations, mode, rng, actions);
    }
}

impl Sac {
    /// One update; batches of any size fit.
    ///
    /// # Errors
    /// [`AgentError::Shape`] if the batch is empty or of other widths than the agent's, [`AgentError::NotFinite`]
    /// before a network takes a step on a loss that is no number.
    pub fn update(&mut self, batch: &Batch, rng: &mut Rng) -> Result<Losses, AgentError> {
        let mut noise = std::mem::take(&mut self.work.noise);
        noise.clear();
        let count = 2 * batch.len() * self.policy.action_dim();
        noise.extend((0..count).map(|_| -> f64 { StandardNormal.sample(rng) }));
        let losses = self.update_with_noise(batch, &noise);
        self.work.noise = noise;
        losses
    }

    /// The policy with its weights averaged over updates, without what only learning needs.
    #[must_use]
    pub fn frozen(&self) -> GaussianPolicy {
        GaussianPolicy { net: self.learner.averaged(&self.policy.net), range: self.policy.range.clone() }
    }
}

impl Checkpoint for Sac {
    fn save(&self) -> Vec<u8> {
        checkpoint::save(&self.learner, &self.policy.net)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        checkpoint::restore(&mut self.learner, &mut self.policy.net, saved)
    }
}

impl Agent for Sac {
    fn name(&self) -> &'static str {
        "sac"
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
        let policy = GaussianPolicy::from_safetensors(bytes).map_err(|e| CheckpointError::new(e.to_string()))?;
        Ok(Arc::new(policy))
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
