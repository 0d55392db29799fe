//! Rollouts inside the learned model.

use ndarray::{Array2, ArrayView1};
use rand::RngExt as _;
use sindyna_core::{
    Bounded, Dynamics, EnvError, Environment, Mode, Observe, Outcome, Policy, Region, Replay, Rng, Seed, Simulated,
    Spec, Task, Transition,
};

use crate::Schedule;
use crate::explore::uniform_action;

/// The learned model as an environment that does not let a policy live where the model knows nothing.
///
/// A rollout that leaves the trusted [`Region`] ends at its border, charged with `worst_value`: what the worst reward
/// known, paid for ever, would be worth. So a policy gains nothing by going where the model was never compared with
/// reality, and nobody ever sees how far beyond the border a wild model went.
pub struct Imagined<'a, M> {
    inner: Simulated<Bounded<&'a M>, &'a dyn Task, &'a dyn Observe>,
    region: &'a Region,
    worst_value: f64,
    left: bool,
    before: Vec<f64>,
}

impl<'a, M: Dynamics> Imagined<'a, M> {
    /// `model` under `task`, seen through `sensors`, trusted in `region`.
    pub fn new(
        model: &'a M,
        task: &'a dyn Task,
        sensors: &'a dyn Observe,
        region: &'a Region,
        worst_value: f64,
    ) -> Self {
        let bounded = Bounded::new(model, &task.spec().state);
        let before = vec![0.0; task.spec().state_dim()];
        Self { inner: Simulated::new(bounded, task, sensors), region, worst_value, left: false, before }
    }

    /// Whether the last step left the trusted region.
    pub fn left_region(&self) -> bool {
        self.left
    }

    /// Another system like this one, sharing the model.
    fn twin(&self) -> Self {
        let Self { inner, region, worst_value, before, .. } = self;
        Self { inner: inner.clone(), region, worst_value: *worst_value, left: false, before: before.clone() }
    }

    /// Begins a rollout anywhere in the trusted region that is not already an end.
    fn scatter(&mut self, rng: &mut Rng) {
        const TRIES: usize = 100;
        let mut x = vec![0.0; self.inner.spec().state_dim()];
        for _ in 0..TRIES {
            self.region.sample(rng, &mut x);
            if !self.inner.task().terminated(&x) {
                return self.inner.reset_to(&x, rng);
            }
        }
        // Nearly every state of the region ends the task: begin where the task does.
        self.inner.task().initial(rng, &mut x);
        self.inner.reset_to(&x, rng);
    }
}

impl<M: Dynamics> Environment for Imagined<'_, M> {
    fn spec(&self) -> &Spec {
        self.inner.spec()
    }

    fn observation(&self) -> &[f64] {
        self.inner.observation()
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        self.left = false;
        self.inner.reset(rng)
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        self.left = false;
        self.before.copy_from_slice(self.inner.state());
        let outcome = self.inner.step(action, rng)?;
        if self.region.contains(self.inner.state()) {
            return Ok(outcome);
        }
        let mut border = self.inner.state().to_vec();
        self.region.clamp(&mut border);
        let reward = self.inner.task().reward(&self.before, action, self.inner.control(), &border);
        self.inner.reset_to(&border, rng);
        // Where the task itself ends, the task says what that costs.
        self.left = !outcome.terminated;
        let reward = if self.left { reward + self.worst_value } else { reward };
        Ok(Outcome { reward, terminated: true, truncated: false })
    }
}

/// An imagined system for trials, where a diverging model is a bad outcome instead of an error.
pub(crate) struct Trial<'a, M>(Imagined<'a, M>);

impl<'a, M: Dynamics> Trial<'a, M> {
    pub(crate) fn like(prototype: &Imagined<'a, M>) -> Self {
        Self(prototype.twin())
    }
}

impl<M: Dynamics> Environment for Trial<'_, M> {
    fn spec(&self) -> &Spec {
        self.0.spec()
    }

    fn observation(&self) -> &[f64] {
        self.0.observation()
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        self.0.reset(rng)
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        match self.0.step(action, rng) {
            Err(EnvError::Diverged(_)) => {
                Ok(Outcome { reward: self.0.worst_value, terminated: true, truncated: false })
            }
            other => other,
        }
    }
}

/// What imagination has done so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) steps: u64,
    pub(crate) rollouts: u64,
    pub(crate) diverged: u64,
    pub(crate) left_region: u64,
}

impl Counts {
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            rollouts: self.rollouts + other.rollouts,
            diverged: self.diverged + other.diverged,
            left_region: self.left_region + other.left_region,
        }
    }
}

/// Who acts in imagination.
pub(crate) enum Dreamer<'a> {
    Random,
    Policy(&'a dyn Policy),
}

struct World<'a, M> {
    env: Imagined<'a, M>,
    rng: Rng,
    age: usize,
    before: Vec<f64>,
}

/// Many imagined systems side by side.
pub(crate) struct Imagination<'a, M> {
    worlds: Vec<World<'a, M>>,
    horizon: usize,
    scattered: f64,
    observations: Array2<f64>,
    actions: Array2<f64>,
    rng: Rng,
    pub(crate) counts: Counts,
}

impl<'a, M: Dynamics> Imagination<'a, M> {
    pub(crate) fn new(prototype: &Imagined<'a, M>, schedule: &Schedule, seed: Seed, turn: u64) -> Self {
        let spec = prototype.spec();
        let n = schedule.worlds;
        let worlds = (0..n).map(|i| World {
            env: prototype.twin(),
            rng: seed.stream("imagined world", turn << 32 | i as u64),
            // Staggered, so that the worlds do not all begin anew in the same turn.
            age: i * schedule.imagined_len / n.max(1),
            before: vec![0.0; spec.observation_dim()],
        });
        let mut all = Self {
            worlds: worlds.collect(),
            horizon: schedule.imagined_len,
            scattered: schedule.scattered_starts,
            observations: Array2::zeros((n, spec.observation_dim())),
            actions: Array2::zeros((n, spec.action_space.action_dim())),
            rng: seed.stream("imagined actions", turn),
            counts: Counts::default(),
        };
        for world in &mut all.worlds {
            let age = world.age;
            world.begin(all.scattered);
            world.age = age;
        }
        all
    }

    /// Steps every world once and remembers what happened.
    pub(crate) fn turn(&mut self, dreamer: &Dreamer<'_>, replay: &mut Replay) {
        for (world, mut row) in self.worlds.iter_mut().zip(self.observations.rows_mut()) {
            row.assign(&ArrayView1::from(world.env.observation()));
        }
        match dreamer {
            Dreamer::Policy(policy) => {
                policy.act_batch(self.observations.view(), Mode::Explore, &mut self.rng, self.actions.view_mut());
            }
            Dreamer::Random => {
                for (world, mut action) in self.worlds.iter().zip(self.actions.rows_mut()) {
                    let action = action.as_slice_mut().expect("rows are contiguous");
                    uniform_action(&world.env.spec().action_space, &mut self.rng, action);
                }
            }
        }
        for (world, action) in self.worlds.iter_mut().zip(self.actions.rows()) {
            let action = action.to_slice().expect("rows are contiguous");
            world.step(action, replay, &mut self.counts);
            if world.age >= self.horizon {
                self.counts.rollouts += 1;
                world.begin(self.scattered);
            }
        }
    }
}

impl<M: Dynamics> World<'_, M> {
    fn begin(&mut self, scattered: f64) {
        self.age = 0;
        if self.rng.random_bool(scattered) {
            self.env.scatter(&mut self.rng);
        } else {
            self.env.reset(&mut self.rng).expect("a simulation always resets");
        }
    }

    /// One step; a rollout that ends is made old, so that it begins anew.
    fn step(&mut self, action: &[f64], replay: &mut Replay, counts: &mut Counts) {
        self.before.copy_from_slice(self.env.observation());
        counts.steps += 1;
        self.age += 1;
        match self.env.step(action, &mut self.rng) {
            Ok(outcome) => {
                replay.push(Transition {
                    observation: &self.before,
                    action,
                    reward: outcome.reward,
                    next_observation: self.env.observation(),
                    terminated: outcome.terminated,
                });
                counts.left_region += u64::from(self.env.left_region());
                if outcome.terminated || outcome.truncated {
                    self.age = usize::MAX;
                }
            }
            // A model that diverged has nothing to teach: the rollout is cut and the step forgotten.
            Err(_) => {
                counts.diverged += 1;
                self.age = usize::MAX;
            }
        }
    }
}
