//! Rollouts inside the learned model.

use std::sync::Arc;

use ndarray::{Array2, ArrayView1};
use rand::RngExt as _;
use serde::{Deserialize, Serialize};
use sindyna_core::{
    Bounded, Checkpoint, CheckpointError, Dynamics, EnvError, Environment, Mode, Outcome, Policy, Replay, Rng, Seed,
    Sensors, Simulated, Spec, Task, Transition, decode, encode,
};

use crate::Schedule;
use crate::base::Counts;
use crate::belief::{Belief, Possible};
use crate::explore::uniform_action;

/// A learned model as an environment in which it does not pay to leave the data for nothing.
///
/// A step that ends outside of the support of the data is charged p e / (1 + e), where e is how far, in half widths of the data, and p
/// a tenth of the spread of the rewards. So a policy goes there if the task pays for it, and stays where the model was compared
/// with the system where the task does not care. A rollout that goes beyond all that a model is followed to ends there, charged with what
/// the worst reward, paid for ever, would be worth.
pub(crate) struct Imagined<'a> {
    inner: Simulated<Bounded<Arc<dyn Dynamics>>, &'a dyn Task, Arc<Sensors>>,
    belief: Belief<'a>,
    left: bool,
    /// What was charged since the last reset, and the sum of e / (1 + e) over the steps.
    charged: f64,
    away: f64,
    steps: f64,
    before: Vec<f64>,
}

impl<'a> Imagined<'a> {
    /// Imagined system `i` of those that go by `belief`.
    pub(crate) fn new(belief: &Belief<'a>, i: usize) -> Self {
        let spec = belief.task.spec();
        let Possible { model, sensors } = belief.system(i).clone();
        let bounded = Bounded::new(model, &spec.state);
        let before = vec![0.0; spec.state_dim()];
        let inner = Simulated::new(bounded, belief.task, sensors);
        Self { inner, belief: belief.clone(), left: false, charged: 0.0, away: 0.0, steps: 0.0, before }
    }

    /// Whether the last step went beyond all that a model is followed to.
    fn left_region(&self) -> bool {
        self.left
    }

    fn forget(&mut self) {
        self.left = false;
        (self.charged, self.away, self.steps) = (0.0, 0.0, 0.0);
    }

    /// Begins an episode in state `x` (n).
    pub(crate) fn reset_to(&mut self, x: &[f64], rng: &mut Rng) {
        self.forget();
        self.inner.reset_to(x, rng);
    }

    /// Begins a rollout anywhere in and around the data that is not already an end.
    fn scatter(&mut self, rng: &mut Rng) {
        const TRIES: usize = 100;
        let mut x = vec![0.0; self.inner.spec().state_dim()];
        for _ in 0..TRIES {
            self.belief.support.draw(rng, &mut x);
            if !self.inner.task().terminated(&x) {
                return self.reset_to(&x, rng);
            }
        }
        // Nearly every state there ends the task: begin where the task does.
        self.inner.task().initial(rng, &mut x);
        self.reset_to(&x, rng);
    }
}

impl Checkpoint for Imagined<'_> {
    fn save(&self) -> Vec<u8> {
        encode(&(self.inner.save(), self.left, self.charged, self.away, self.steps))
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        let (inner, left, charged, away, steps): (Vec<u8>, bool, f64, f64, f64) = decode(saved)?;
        self.inner.restore(&inner)?;
        (self.left, self.charged, self.away, self.steps) = (left, charged, away, steps);
        Ok(())
    }
}

impl Environment for Imagined<'_> {
    fn spec(&self) -> &Spec {
        self.inner.spec()
    }

    fn observation(&self) -> &[f64] {
        self.inner.observation()
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        self.forget();
        self.inner.reset(rng)
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        self.left = false;
        self.before.copy_from_slice(self.inner.state());
        let outcome = self.inner.step(action, rng)?;
        let (support, stakes) = (&self.belief.support, self.belief.stakes);
        if support.contains(self.inner.state()) {
            let excess = support.excess(self.inner.state());
            let away = excess / (1.0 + excess);
            let charge = stakes.penalty * away;
            self.charged += charge;
            self.away += away;
            self.steps += 1.0;
            return Ok(Outcome { reward: outcome.reward - charge, ..outcome });
        }
        let mut border = self.inner.state().to_vec();
        support.clamp(&mut border);
        let reward = self.inner.task().reward(&self.before, action, self.inner.control(), &border);
        self.inner.reset_to(&border, rng);
        // Where the task itself ends, the task says what that costs.
        self.left = !self.inner.task().terminated(&border);
        let reward = if self.left { reward + stakes.worst_value } else { reward };
        Ok(Outcome { reward, terminated: true, truncated: false })
    }
}

/// An imagined system for trials, where a diverging model is a bad outcome instead of an error.
pub(crate) struct Trial<'a>(Imagined<'a>);

impl<'a> Trial<'a> {
    /// Imagined system `i` of those that go by `belief`.
    pub(crate) fn new(belief: &Belief<'a>, i: usize) -> Self {
        Self(Imagined::new(belief, i))
    }

    /// Begins an episode in state `x` (n).
    pub(crate) fn reset_to(&mut self, x: &[f64], rng: &mut Rng) {
        self.0.reset_to(x, rng);
    }

    /// Mean of e / (1 + e) over the steps since the last reset.
    pub(crate) fn far(&self) -> f64 {
        self.0.away / self.0.steps.max(1.0)
    }

    /// What was charged for going far from the data since the last reset.
    pub(crate) fn charged(&self) -> f64 {
        self.0.charged
    }
}

impl Environment for Trial<'_> {
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
                Ok(Outcome { reward: self.0.belief.stakes.worst_value, terminated: true, truncated: false })
            }
            other => other,
        }
    }
}

/// Who acts in imagination.
pub(crate) enum Dreamer<'a> {
    Random,
    Policy(&'a dyn Policy),
}

struct World<'a> {
    env: Imagined<'a>,
    rng: Rng,
    age: usize,
    before: Vec<f64>,
}

/// What changes in imagination from step to step.
#[derive(Serialize, Deserialize)]
struct Saved {
    worlds: Vec<(Vec<u8>, Rng, usize)>,
    rng: Rng,
    rollouts: u64,
    diverged: u64,
}

/// Many imagined systems side by side, seen without the sensors' noise: what is learned is the value of states. How much of it stands
/// under noise is for trials to tell.
pub(crate) struct Imagination<'a> {
    pub(crate) belief: Belief<'a>,
    worlds: Vec<World<'a>>,
    horizon: usize,
    scattered: f64,
    observations: Array2<f64>,
    actions: Array2<f64>,
    rng: Rng,
    /// Rollouts ended here.
    pub(crate) rollouts: u64,
    /// Rollouts cut here because the model diverged.
    pub(crate) diverged: u64,
}

impl<'a> Imagination<'a> {
    pub(crate) fn new(belief: Belief<'a>, schedule: &Schedule, seed: Seed, turn: u64) -> Self {
        let spec = belief.task.spec();
        let n = schedule.worlds;
        let quiet = belief.without_noise();
        let worlds = (0..n).map(|i| World {
            env: Imagined::new(&quiet, i),
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
            belief,
            rollouts: 0,
            diverged: 0,
        };
        for world in &mut all.worlds {
            let age = world.age;
            world.begin(all.scattered);
            world.age = age;
        }
        all
    }

    /// The worlds as they are, and what was counted.
    pub(crate) fn save(&self) -> Vec<u8> {
        let worlds = self.worlds.iter().map(|w| (w.env.save(), w.rng.clone(), w.age)).collect();
        let Self { rng, rollouts, diverged, .. } = self;
        encode(&Saved { worlds, rng: rng.clone(), rollouts: *rollouts, diverged: *diverged })
    }

    /// Makes one that has just begun the one that was saved.
    pub(crate) fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        let Saved { worlds, rng, rollouts, diverged } = decode(saved)?;
        CheckpointError::expect_len("imagined systems", self.worlds.len(), worlds.len())?;
        for (world, (env, rng, age)) in self.worlds.iter_mut().zip(worlds) {
            world.env.restore(&env)?;
            (world.rng, world.age) = (rng, age);
        }
        (self.rng, self.rollouts, self.diverged) = (rng, rollouts, diverged);
        Ok(())
    }

    /// Steps every world once, remembers what happened, and counts it.
    pub(crate) fn turn(&mut self, dreamer: &Dreamer<'_>, replay: &mut Replay, counts: &mut Counts) {
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
        let before = *counts;
        for (world, action) in self.worlds.iter_mut().zip(self.actions.rows()) {
            let action = action.to_slice().expect("rows are contiguous");
            world.step(action, replay, counts);
            if world.age >= self.horizon {
                counts.rollouts += 1;
                world.begin(self.scattered);
            }
        }
        self.rollouts += counts.rollouts - before.rollouts;
        self.diverged += counts.diverged - before.diverged;
    }
}

impl World<'_> {
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
