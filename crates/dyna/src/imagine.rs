//! Rollouts inside the learned model.

use std::convert::Infallible;
use std::sync::Arc;

use rand::RngExt as _;
use serde::{Deserialize, Serialize};
use sindyna_core::{
    Bounded, Checkpoint, CheckpointError, Dynamics, EnvError, Environment, Mode, Outcome, Policy, Rng, Seed, Sensors,
    Simulated, Spec, Task, decode, encode,
};

use crate::Schedule;
use crate::base::Progress;
use crate::belief::{Belief, Possible};
use crate::lockstep::{Lane, Lockstep};
use crate::trust::Judged;

/// A learned model with a task.
type Inner<'a> = Simulated<Bounded<Arc<dyn Dynamics>>, Arc<dyn Task + 'a>, Arc<Sensors>>;

/// A learned model as an environment in which it does not pay to leave the data for nothing.
///
/// A step that ends outside of the support of the data is charged p e / (1 + e), where e is how far, in half widths of the data, and p
/// a tenth of the spread of the rewards. So a policy goes there if the task pays for it, and stays where the model was compared
/// with the system where the task does not care. A rollout that goes beyond all that a model is followed to ends there, charged with what
/// the worst reward, paid for ever, would be worth.
pub(crate) struct Imagined<'a> {
    inner: Inner<'a>,
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
        let Possible { model, sensors, task } = belief.system(i).clone();
        let bounded = Bounded::new(model, &spec.state);
        let before = vec![0.0; spec.state_dim()];
        let inner = Simulated::new(bounded, task, sensors);
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
            self.belief.trust.draw(rng, &mut x);
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
        let stepped = self.inner.step(action, rng);
        if !matches!(stepped, Ok(_) | Err(EnvError::Reward { .. })) {
            return stepped;
        }
        if let Judged::Followed { away, charge } = self.belief.trust.judge(self.inner.state()) {
            let outcome = stepped?;
            self.charged += charge;
            self.away += away;
            self.steps += 1.0;
            return Ok(Outcome { reward: outcome.reward - charge, ..outcome });
        }
        let mut border = self.inner.state().to_vec();
        self.belief.trust.clamp(&mut border);
        let reward = self.inner.task().reward(&self.before, action, self.inner.control(), &border);
        EnvError::unless_finite(self.spec(), reward, (&self.before, self.inner.control(), &border))?;
        self.inner.reset_to(&border, rng);
        // Where the task itself ends, the task says what that costs.
        self.left = !self.inner.task().terminated(&border);
        let reward = if self.left { reward + self.belief.stakes.worst_value } else { reward };
        Ok(Outcome { reward, terminated: true, truncated: false })
    }
}

/// An imagined system for trials, where a model that diverges, or goes where the task pays no finite number, is a bad outcome instead of an error.
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

    /// The state that it is in (n).
    pub(crate) fn state(&self) -> &[f64] {
        self.0.inner.state()
    }

    /// The control of the last step (k).
    pub(crate) fn control(&self) -> &[f64] {
        self.0.inner.control()
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
            Err(EnvError::Diverged { .. } | EnvError::Reward { .. }) => {
                Ok(Outcome { reward: self.0.belief.stakes.worst_value, terminated: true, truncated: false })
            }
            other => other,
        }
    }
}

/// An imagined system in the middle of a rollout.
struct System<'a> {
    env: Imagined<'a>,
    rng: Rng,
    age: usize,
}

impl<'a> Lane for System<'a> {
    type System = Imagined<'a>;

    fn system(&self) -> &Imagined<'a> {
        &self.env
    }

    fn with_rng<'b>(&'b mut self, _common: &'b mut Rng) -> (&'b mut Imagined<'a>, &'b mut Rng) {
        (&mut self.env, &mut self.rng)
    }
}

/// What changes in imagination from step to step.
#[derive(Serialize, Deserialize)]
struct Saved {
    systems: Vec<(Vec<u8>, Rng, usize)>,
    rng: Rng,
    rollouts: u64,
    diverged: u64,
}

/// Many imagined systems side by side, seen without the sensors' noise: what is learned is the value of states. How much of it stands
/// under noise is for trials to tell.
pub(crate) struct Imagination<'a> {
    pub(crate) belief: Belief<'a>,
    systems: Lockstep<System<'a>>,
    horizon: usize,
    scattered: f64,
    rng: Rng,
    /// Rollouts ended here.
    pub(crate) rollouts: u64,
    /// Rollouts cut here because the model diverged.
    pub(crate) diverged: u64,
}

impl<'a> Imagination<'a> {
    /// Goes by `belief`; the share `scattered` of its rollouts begins anywhere in the support of the data.
    pub(crate) fn new(belief: Belief<'a>, (schedule, scattered): (&Schedule, f64), seed: Seed, turn: u64) -> Self {
        let n = schedule.systems;
        let quiet = belief.without_noise();
        let systems = (0..n).map(|i| {
            let rng = seed.stream("imagined world", turn << 32 | i as u64);
            let mut system = System { env: Imagined::new(&quiet, i), rng, age: 0 };
            system.begin(scattered);
            // Staggered, so that the systems do not all begin anew in the same turn.
            system.age = i * schedule.imagined_len / n.max(1);
            system
        });
        Self {
            systems: Lockstep::new(belief.task.spec(), systems.collect()),
            horizon: schedule.imagined_len,
            scattered,
            rng: seed.stream("imagined actions", turn),
            belief,
            rollouts: 0,
            diverged: 0,
        }
    }

    /// The systems as they are, and what was counted.
    pub(crate) fn save(&self) -> Vec<u8> {
        let systems = self.systems.lanes.iter().map(|w| (w.env.save(), w.rng.clone(), w.age)).collect();
        let Self { rng, rollouts, diverged, .. } = self;
        encode(&Saved { systems, rng: rng.clone(), rollouts: *rollouts, diverged: *diverged })
    }

    /// Makes one that has just begun the one that was saved.
    pub(crate) fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        let Saved { systems, rng, rollouts, diverged } = decode(saved)?;
        CheckpointError::expect_len("imagined systems", self.systems.lanes.len(), systems.len())?;
        for (system, (env, rng, age)) in self.systems.lanes.iter_mut().zip(systems) {
            system.env.restore(&env)?;
            (system.rng, system.age) = (rng, age);
        }
        (self.rng, self.rollouts, self.diverged) = (rng, rollouts, diverged);
        Ok(())
    }

    /// Steps every system once by `policy`, remembers what happened, and counts it.
    pub(crate) fn turn(&mut self, policy: &dyn Policy, Progress { replay, counts, model, .. }: &mut Progress) {
        let Self { systems, horizon, scattered, rng, rollouts, diverged, .. } = self;
        let Ok::<_, Infallible>(()) = systems.step((policy, Mode::Explore), rng, |system, step| {
            counts.steps += 1;
            system.age += 1;
            let ended = match step.transition(&system.env) {
                Some((transition, ended)) => {
                    replay.push_imagined(*model, transition);
                    counts.left_region += u64::from(system.env.left_region());
                    ended
                }
                // A model that diverged has nothing to teach: the rollout is cut and the step forgotten.
                None => {
                    counts.diverged += 1;
                    *diverged += 1;
                    true
                }
            };
            if ended || system.age >= *horizon {
                counts.rollouts += 1;
                *rollouts += 1;
                system.begin(*scattered);
            }
            Ok(true)
        });
    }
}

impl System<'_> {
    fn begin(&mut self, scattered: f64) {
        self.age = 0;
        if self.rng.random_bool(scattered) {
            self.env.scatter(&mut self.rng);
        } else {
            self.env.reset(&mut self.rng).expect("a simulation always resets");
        }
    }
}
