//! Real data, every step and reset of it counted.

use serde::{Deserialize, Serialize};
use sindyna_core::{
    Acting, CheckpointError, Dataset, End, EnvError, Environment, Explorer, Memory as _, Mode, Policy, Rng, Spec,
};

/// Something that chooses the next real action.
pub(crate) enum Actor<'a> {
    Explorer(&'a mut dyn Explorer),
    Policy(&'a dyn Policy, Acting<'a>, Mode),
}

impl<'a> Actor<'a> {
    pub(crate) fn policy(policy: &'a dyn Policy, mode: Mode) -> Self {
        Self::Policy(policy, Acting::begin(policy), mode)
    }

    /// Told that an episode begins.
    fn begin(&mut self) {
        if let Self::Policy(policy, acting, _) = self {
            *acting = Acting::begin(*policy);
        }
    }

    fn act(&mut self, observation: &[f64], so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        match self {
            Self::Explorer(explorer) => explorer.next(so_far, rng, action),
            Self::Policy(_, acting, mode) => acting.act(observation, *mode, rng, action),
        }
    }
}

/// How much real data is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Amount {
    /// So many steps, over as many episodes as it takes.
    Steps(usize),
    /// One episode, of at most so many steps.
    Episode(usize),
}

/// The system in use. Its `data` count steps as [`Dataset::n_steps`], resets as [`Dataset::n_rollouts`].
#[derive(Serialize, Deserialize)]
pub(crate) struct Collector {
    pub(crate) data: Dataset,
    pub(crate) rng: Rng,
    action: Vec<f64>,
    control: Vec<f64>,
    /// Steps for which the action is still held.
    held: usize,
    /// Whether an episode can go on.
    pub(crate) running: bool,
}

impl Collector {
    /// Nothing yet, of the system that `spec` describes.
    pub(crate) fn new(spec: &Spec, rng: Rng) -> Self {
        let (m, k, values) = (spec.observation_dim(), spec.control_dim(), spec.action_space.action_dim());
        Self {
            data: Dataset::new(m, k, values, spec.dt),
            rng,
            action: vec![0.0; values],
            control: vec![0.0; k],
            held: 0,
            running: false,
        }
    }

    /// Refuses to stand for `other` unless it is of such a system.
    pub(crate) fn check(&self, other: &Self) -> Result<(), CheckpointError> {
        self.data.check(&other.data)?;
        CheckpointError::expect_len("action values", other.action.len(), self.action.len())?;
        CheckpointError::expect_len("controls", other.control.len(), self.control.len())
    }

    /// One real step, after a reset where no episode is running; an action is held for `held_steps`.
    pub(crate) fn step(
        &mut self,
        env: &mut dyn Environment,
        actor: &mut Actor<'_>,
        held_steps: usize,
    ) -> Result<(), CollectError> {
        if !self.running {
            env.reset(&mut self.rng)?;
            self.data.begin(env.observation())?;
            self.held = 0;
            actor.begin();
        }
        if self.held > 0 {
            self.held -= 1;
        } else {
            actor.act(env.observation(), &self.data, &mut self.rng, &mut self.action);
            self.held = held_steps.saturating_sub(1);
        }
        let outcome = env.step(&self.action, &mut self.rng)?;
        // The environment accepted the action, so it is one of the space's.
        env.spec().action_space.control_into(&self.action, &mut self.control);
        self.data.push(&self.action, &self.control, outcome.reward, env.observation())?;
        self.running = !(outcome.terminated || outcome.truncated);
        if !self.running {
            self.data.finish(if outcome.terminated { End::Terminated } else { End::Truncated });
        }
        Ok(())
    }

    /// Begins anew and adds real steps. Where an episode ends before the steps are made, another reset follows. Stops early once `interrupted` says so.
    pub(crate) fn collect(
        &mut self,
        env: &mut dyn Environment,
        mut actor: Actor<'_>,
        amount: Amount,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<(), CollectError> {
        let steps = match amount {
            Amount::Steps(steps) | Amount::Episode(steps) => steps,
        };
        self.running = false;
        for step in 0..steps {
            let ended = step > 0 && matches!(amount, Amount::Episode(_)) && !self.running;
            if ended || interrupted() {
                break;
            }
            self.step(env, &mut actor, 1)?;
        }
        Ok(())
    }
}

/// Why real data could not be collected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CollectError {
    /// The environment failed.
    #[error(transparent)]
    Environment(#[from] EnvError),
    /// The environment returned something that is no observation.
    #[error(transparent)]
    Data(#[from] sindyna_core::DatasetError),
}
