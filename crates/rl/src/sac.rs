//! Soft actor-critic: the order of an update.

use ndarray::{ArrayView2, ArrayViewMut2};
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Agent, AgentError, Batch, Losses, Mode, Policy, Rng};

use crate::{
    GaussianPolicy, SacConfig, SacError, Scaling, adam::Adam, critic::Critic, gaussian::Squashed,
    interface::ActionRange, mlp::Mlp, pass::Pass, temperature::Temperature,
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
    config: SacConfig,
    pub(crate) policy: GaussianPolicy,
    pub(crate) actor_adam: Adam,
    pub(crate) actor_gradients: Vec<f32>,
    pub(crate) critics: [Critic; 2],
    pub(crate) temperature: Temperature,
    pub(crate) work: Workspace,
    updates: u64,
}

/// Memory of an update, kept so that none is allocated anew.
#[derive(Debug, Clone, Default)]
pub(crate) struct Workspace {
    /// Scaled observations (2B, m): those before the steps, then those after.
    observations: Vec<f32>,
    /// Critics' inputs (B, m + k).
    inputs: Vec<f32>,
    noise: Vec<f64>,
    pass: Pass,
    pub(crate) drawn: Squashed,
    pub(crate) targets: Vec<f32>,
    /// Rows in which each critic has the lesser value.
    lesser_rows: [Vec<usize>; 2],
    d_actions: Vec<f32>,
    d_head: Vec<f32>,
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
        config.check()?;
        scaling.check()?;
        let range = ActionRange::new(action_low, action_high)?;
        let (m, k) = (scaling.width(), range.width());
        let sizes = |first, last| [&[first], config.hidden.as_slice(), &[last]].concat();
        let net = Mlp::random(&sizes(m, 2 * k), rng);
        let critic_sizes = sizes(m + k, 1);
        let critics = [(); 2].map(|()| Critic::new(&critic_sizes, config.learning_rate, rng));
        let target_entropy = config.target_entropy.unwrap_or(-(k as f64));
        Ok(Self {
            actor_adam: Adam::new(net.params.len(), config.learning_rate),
            actor_gradients: vec![0.0; net.params.len()],
            temperature: Temperature::new(config.initial_temperature, target_entropy, config.learning_rate),
            policy: GaussianPolicy { net, scaling, range },
            critics,
            config,
            work: Workspace::default(),
            updates: 0,
        })
    }

    /// Updates made so far.
    #[must_use]
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// The settings the agent was made with.
    #[must_use]
    pub fn config(&self) -> &SacConfig {
        &self.config
    }

    /// The entropy weight α.
    #[must_use]
    pub fn temperature(&self) -> f64 {
        self.temperature.value()
    }

    /// [`Agent::update`] with given standard normal numbers: (2B, k) values, those of ã first, then those of a'.
    ///
    /// # Errors
    /// As [`Agent::update`]; [`AgentError::Shape`] also if `noise` has not 2Bk values.
    pub fn update_with_noise(&mut self, batch: &Batch, noise: &[f64]) -> Result<Losses, AgentError> {
        self.check(batch)?;
        let (rows, k) = (batch.len(), self.policy.action_dim());
        shape("noise values", 2 * rows * k, noise.len())?;
        self.scale_observations(batch);

        // The actor does not change before step 3, so both of its passes are one.
        let heads = self.work.pass.forward(&self.policy.net, &self.work.observations, 2 * rows);
        self.work.drawn.draw(heads, noise, k);

        let temperature = self.temperature.value();
        let mean_log_prob = mean(&self.work.drawn.log_probs[..rows]);
        self.finite("the entropy", mean_log_prob)?;
        self.temperature.step(mean_log_prob);

        self.compute_targets(batch, temperature);
        let critic = self.improve_critics(batch)?;
        let actor = self.improve_actor(rows, temperature, mean_log_prob)?;
        self.updates += 1;
        Ok(Losses { critic, actor, temperature: self.temperature.value(), entropy: -mean_log_prob })
    }

    fn check(&self, batch: &Batch) -> Result<(), AgentError> {
        let (rows, m, k) = (batch.len(), self.policy.observation_dim(), self.policy.action_dim());
        if rows == 0 {
            return shape("transitions", self.config.batch_size, 0);
        }
        shape("rows of observations", rows, batch.observations.nrows())?;
        shape("observed values", m, batch.observations.ncols())?;
        shape("rows of actions", rows, batch.actions.nrows())?;
        shape("action values", k, batch.actions.ncols())?;
        shape("rows of next observations", rows, batch.next_observations.nrows())?;
        shape("values observed next", m, batch.next_observations.ncols())?;
        shape("termination flags", rows, batch.terminated.len())
    }

    fn scale_observations(&mut self, batch: &Batch) {
        let observations = &mut self.work.observations;
        observations.clear();
        for o in batch.observations.rows().into_iter().chain(batch.next_observations.rows()) {
            observations.extend(self.policy.scaling.apply(o.iter()));
        }
    }

    /// The soft Bellman targets y (B) of step 2.
    fn compute_targets(&mut self, batch: &Batch, temperature: f64) {
        let (rows, m, k) = (batch.len(), self.policy.observation_dim(), self.policy.action_dim());
        let work = &mut self.work;
        let next = &work.observations[rows * m..];
        join_columns(next, m, work.drawn.actions[rows * k..].chunks_exact(k), &mut work.inputs);
        let [first, second] = &mut self.critics;
        let values = first.target_values(&work.inputs, rows).iter().zip(second.target_values(&work.inputs, rows));
        let outcomes = batch.rewards.iter().zip(&batch.terminated).zip(&work.drawn.log_probs[rows..]);
        work.targets.clear();
        work.targets.extend(values.zip(outcomes).map(|((q1, q2), ((reward, terminated), log_prob))| {
            let value = f64::from(lesser(*q1, *q2)) - temperature * log_prob;
            soft_target(self.config.reward_scale * reward, *terminated, self.config.discount, value) as f32
        }));
    }

    /// Steps 2 and 4; returns the critics' loss.
    fn improve_critics(&mut self, batch: &Batch) -> Result<f64, AgentError> {
        let (rows, m) = (batch.len(), self.policy.observation_dim());
        let work = &mut self.work;
        let range = &self.policy.range;
        work.inputs.clear();
        for (o, a) in work.observations[..rows * m].chunks_exact(m).zip(batch.actions.rows()) {
            work.inputs.extend_from_slice(o);
            work.inputs.extend(range.to_network(a.iter()));
        }
        let mut loss = 0.0;
        for critic in &mut self.critics {
            loss += critic.regress(&work.inputs, &work.targets);
        }
        self.finite("the critics' loss", loss)?;
        for critic in &mut self.critics {
            critic.step(self.config.polyak);
        }
        Ok(loss)
    }

    /// Step 3; returns the actor's loss.
    fn improve_actor(&mut self, rows: usize, temperature: f64, mean_log_prob: f64) -> Result<f64, AgentError> {
        let (m, k) = (self.policy.observation_dim(), self.policy.action_dim());
        let work = &mut self.work;
        let observations = &work.observations[..rows * m];
        join_columns(observations, m, work.drawn.actions[..rows * k].chunks_exact(k), &mut work.inputs);
        let [first, second] = &mut self.critics;
        let (q1, q2) = (first.values(&work.inputs, rows), second.values(&work.inputs, rows));

        let mut sum = 0.0;
        work.lesser_rows.iter_mut().for_each(Vec::clear);
        for (row, (q1, q2)) in q1.iter().zip(q2).enumerate() {
            sum += f64::from(lesser(*q1, *q2));
            work.lesser_rows[usize::from(q1 > q2)].push(row);
        }
        let loss = temperature * mean_log_prob - sum / rows as f64;
        self.finite("the actor's loss", loss)?;

        // Of the twins only the one with the lesser value passes a gradient, so each goes back over its own rows.
        let work = &mut self.work;
        work.d_actions.resize(rows * k, 0.0);
        for (critic, rows_of) in self.critics.iter_mut().zip(&work.lesser_rows) {
            let gradients = critic.input_gradients(rows_of, -1.0 / rows as f32, m);
            for (row, d) in rows_of.iter().zip(gradients.chunks_exact(k)) {
                work.d_actions[row * k..(row + 1) * k].copy_from_slice(d);
            }
        }
        work.drawn.backward(&work.d_actions, temperature / rows as f64, k, &mut work.d_head);
        work.pass.backward_params(&self.policy.net, &work.observations, &work.d_head, &mut self.actor_gradients);
        self.actor_adam.step(&mut self.policy.net.params, &self.actor_gradients);
        Ok(loss)
    }

    fn finite(&self, what: &'static str, value: f64) -> Result<(), AgentError> {
        if value.is_finite() { Ok(()) } else { Err(AgentError::NotFinite { what, value, updates: self.updates }) }
    }
}

impl Policy for Sac {
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        self.policy.act_batch(observations, mode, rng, actions);
    }
}

impl Agent for Sac {
    type Frozen = GaussianPolicy;

    /// One update; batches of any size fit.
    ///
    /// # Errors
    /// [`AgentError::Shape`] if the batch is empty or of other widths than the agent's, [`AgentError::NotFinite`]
    /// before a network takes a step on a loss that is no number.
    fn update(&mut self, batch: &Batch, rng: &mut Rng) -> Result<Losses, AgentError> {
        let mut noise = std::mem::take(&mut self.work.noise);
        noise.clear();
        let count = 2 * batch.len() * self.policy.action_dim();
        noise.extend((0..count).map(|_| -> f64 { StandardNormal.sample(rng) }));
        let losses = self.update_with_noise(batch, &noise);
        self.work.noise = noise;
        losses
    }

    fn frozen(&self) -> GaussianPolicy {
        self.policy.clone()
    }
}

/// Soft Bellman target; a step that did not terminate bootstraps, also one that was truncated.
fn soft_target(reward: f64, terminated: f64, discount: f64, next_value: f64) -> f64 {
    reward + discount * (1.0 - terminated) * next_value
}

/// The lesser of two values; a number that is none is never hidden by the other.
fn lesser(a: f32, b: f32) -> f32 {
    if a <= b || a.is_nan() { a } else { b }
}

/// Overwrites `joined` with rows of `left` (`width` values) followed by those of `right`.
fn join_columns<'a>(left: &[f32], width: usize, right: impl Iterator<Item = &'a [f32]>, joined: &mut Vec<f32>) {
    joined.clear();
    for (l, r) in left.chunks_exact(width).zip(right) {
        joined.extend_from_slice(l);
        joined.extend_from_slice(r);
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn shape(what: &'static str, expected: usize, got: usize) -> Result<(), AgentError> {
    if expected == got { Ok(()) } else { Err(AgentError::Shape { what, expected, got }) }
}
