//! What the agents for real and for numbered actions have in common.

use sindyna_core::{AgentError, Batch, Rng};

use crate::{
    Isa, SacConfig, SacError, Scaling,
    adam::Adam,
    critic::Critic,
    mlp::Mlp,
    pass::{Deltas, Pass},
    scaled_net::ScaledNet,
    temperature::Temperature,
};

/// What one update reports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Losses {
    /// Loss of the critics.
    pub critic: f64,
    /// Loss of the actor.
    pub actor: f64,
    /// Entropy weight after the update.
    pub temperature: f64,
    /// Mean entropy estimate −E\[log π\] over the batch \[nat\].
    pub entropy: f64,
}

impl Losses {
    /// The same by name.
    pub(crate) fn named(self) -> Vec<(&'static str, f64)> {
        let Self { critic, actor, temperature, entropy } = self;
        vec![("critic_loss", critic), ("actor_loss", actor), ("temperature", temperature), ("entropy", entropy)]
    }
}

/// Optimisers, twin critics, temperature and the memory of an update: all of an agent but its policy.
#[derive(Debug, Clone)]
pub(crate) struct Learner {
    pub(crate) config: SacConfig,
    pub(crate) actor_adam: Adam,
    pub(crate) actor_gradients: Vec<f32>,
    /// Weights of the actor, averaged over updates.
    pub(crate) average: Vec<f32>,
    pub(crate) critics: [Critic; 2],
    pub(crate) temperature: Temperature,
    /// Soft Bellman targets (B).
    pub(crate) targets: Vec<f32>,
    pub(crate) pass: Pass,
    pub(crate) deltas: Deltas,
    pub(crate) d_heads: Vec<f32>,
    pub(crate) updates: u64,
    /// What the last update reported.
    pub(crate) losses: Option<Losses>,
}

/// Widths of the networks at both ends; those between are the configuration's.
pub(crate) struct Widths {
    pub(crate) head: usize,
    pub(crate) critic_input: usize,
    pub(crate) critic_output: usize,
}

impl Learner {
    /// A random actor, and what is needed to improve it.
    pub(crate) fn new(
        config: SacConfig,
        scaling: Scaling,
        widths: &Widths,
        temperature: Temperature,
        rng: &mut Rng,
    ) -> Result<(ScaledNet, Self), SacError> {
        config.check()?;
        scaling.check()?;
        let sizes = |first, last| [&[first], config.hidden.as_slice(), &[last]].concat();
        let net = Mlp::random(&sizes(scaling.width(), widths.head), rng);
        let critic_sizes = sizes(widths.critic_input, widths.critic_output);
        let critics = [(); 2].map(|()| Critic::new(&critic_sizes, config.learning_rate, rng));
        let learner = Self {
            actor_adam: Adam::new(net.params.len(), config.learning_rate),
            actor_gradients: vec![0.0; net.params.len()],
            average: net.params.clone(),
            critics,
            temperature,
            config,
            targets: Vec::new(),
            pass: Pass::new(Isa::widest()),
            deltas: Deltas::default(),
            d_heads: Vec::new(),
            updates: 0,
            losses: None,
        };
        Ok((ScaledNet { net, scaling }, learner))
    }

    /// Runs the matrix products with the instructions `isa` from now on.
    pub(crate) fn set_isa(&mut self, isa: Isa) {
        self.pass.isa = isa;
        self.critics.iter_mut().for_each(|c| c.pass.isa = isa);
    }

    /// Refuses batches of other shapes than `m` observed values and `action_dim` of an action.
    pub(crate) fn check(&self, batch: &Batch, m: usize, action_dim: usize) -> Result<(), AgentError> {
        let rows = batch.len();
        if rows == 0 {
            return shape("transitions", self.config.batch_size, 0);
        }
        shape("rows of observations", rows, batch.observations.nrows())?;
        shape("observed values", m, batch.observations.ncols())?;
        shape("rows of actions", rows, batch.actions.nrows())?;
        shape("action values", action_dim, batch.actions.ncols())?;
        shape("rows of next observations", rows, batch.next_observations.nrows())?;
        shape("values observed next", m, batch.next_observations.ncols())?;
        shape("termination flags", rows, batch.terminated.len())
    }

    /// The actor's heads (2B, head) for the batch's scaled observations (2B, m), those before the steps first, which are
    /// left in `observations`.
    ///
    /// The actor does not change before its own step at the end of an update, so both of its passes are one.
    pub(crate) fn heads(&mut self, actor: &ScaledNet, batch: &Batch, observations: &mut Vec<f32>) -> &[f32] {
        observations.resize(2 * batch.observations.len(), 0.0);
        let (before, after) = observations.split_at_mut(batch.observations.len());
        actor.scaling.apply(batch.observations.view(), before);
        actor.scaling.apply(batch.next_observations.view(), after);
        self.pass.forward(&actor.net, observations, 2 * batch.len())
    }

    /// The lesser of the twin targets' values, every output of `rows` inputs, into `values`.
    pub(crate) fn lesser_target_values(&mut self, inputs: &[f32], rows: usize, values: &mut Vec<f64>) {
        let [first, second] = &mut self.critics;
        collect_lesser(first.target_values(inputs, rows), second.target_values(inputs, rows), values);
    }

    /// [`Self::lesser_target_values`] of the twins themselves.
    pub(crate) fn lesser_values(&mut self, inputs: &[f32], rows: usize, values: &mut Vec<f64>) {
        let [first, second] = &mut self.critics;
        collect_lesser(first.values(inputs, rows), second.values(inputs, rows), values);
    }

    /// The soft Bellman targets y = r + γ (1 - terminated) V(o'), given every V(o').
    pub(crate) fn set_targets(&mut self, batch: &Batch, next_values: impl Iterator<Item = f64>) {
        let outcomes = batch.rewards.iter().zip(&batch.terminated);
        self.targets.clear();
        self.targets.extend(next_values.zip(outcomes).map(|(value, (reward, terminated))| {
            soft_target(self.config.reward_scale * reward, *terminated, self.config.discount, value) as f32
        }));
    }

    /// Moves the critics towards the targets, and their slow copies after them; returns their loss. The action taken in
    /// each row of `inputs` is the critics' output number `chosen`.
    pub(crate) fn improve_critics(
        &mut self,
        inputs: &[f32],
        chosen: impl Iterator<Item = usize> + Clone,
    ) -> Result<f64, AgentError> {
        let mut loss = 0.0;
        for critic in &mut self.critics {
            loss += critic.regress(inputs, chosen.clone(), &self.targets, &mut self.deltas);
        }
        self.finite("the critics' loss", loss)?;
        for critic in &mut self.critics {
            critic.step(self.config.polyak);
        }
        Ok(loss)
    }

    /// Moves the actor against `d_heads`, the gradient of its loss by the heads of the first of the `observations`.
    pub(crate) fn improve_actor(&mut self, actor: &mut ScaledNet, observations: &[f32]) {
        let Self { pass, d_heads, deltas, actor_gradients, .. } = self;
        pass.backward_params(&actor.net, observations, d_heads, deltas, actor_gradients);
        self.actor_adam.step(&mut actor.net.params, &self.actor_gradients);
        // Of few updates all count alike.
        let share = self.config.averaging.max(1.0 / (self.updates + 1) as f64) as f32;
        for (average, param) in self.average.iter_mut().zip(&actor.net.params) {
            *average += share * (param - *average);
        }
    }

    /// The actor with its weights averaged over updates.
    pub(crate) fn averaged(&self, actor: &ScaledNet) -> ScaledNet {
        let mut averaged = actor.clone();
        if self.config.averaging < 1.0 {
            averaged.net.params.copy_from_slice(&self.average);
        }
        averaged
    }

    /// Counts an update, which has these `losses`.
    pub(crate) fn count(&mut self, losses: Losses) -> Losses {
        self.updates += 1;
        self.losses = Some(losses);
        losses
    }

    pub(crate) fn finite(&self, what: &'static str, value: f64) -> Result<(), AgentError> {
        if value.is_finite() { Ok(()) } else { Err(AgentError::NotFinite { what, value, updates: self.updates }) }
    }
}

/// Soft Bellman target; a step that did not terminate bootstraps, also one that was truncated.
fn soft_target(reward: f64, terminated: f64, discount: f64, next_value: f64) -> f64 {
    reward + discount * (1.0 - terminated) * next_value
}

fn collect_lesser(first: &[f32], second: &[f32], values: &mut Vec<f64>) {
    values.clear();
    values.extend(first.iter().zip(second).map(|(a, b)| f64::from(lesser(*a, *b))));
}

/// The lesser of two values; a number that is none is never hidden by the other.
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a <= b || a.is_nan() { a } else { b }
}

pub(crate) fn shape(what: &'static str, expected: usize, got: usize) -> Result<(), AgentError> {
    if expected == got { Ok(()) } else { Err(AgentError::Shape { what, expected, got }) }
}
