//! Learning while acting on the real system: model-free, or with a model that adds to the data.

mod branch;
mod schedule;

use std::sync::Arc;

use sindyna_core::{
    Agent, AgentError, Batch, Dataset, DynamicsLearner, End, Environment, Explorer, FitError, Inverse, Mode, Replay,
    Rng, Seed, Sensors, Task, TrainedPolicy, Transition,
};

use crate::algorithm::DynaError;
use crate::collect::{Actor, CollectError};
use crate::evaluate::evaluate;
use branch::Stage;
pub use schedule::{Branches, Checks, OnlineSchedule};

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
#[derive(Debug, Clone, PartialEq)]
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
    /// Resets of the real system.
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
    /// Learns on the real system `env`; checks are on `judges`, systems of the same kind.
    ///
    /// # Errors
    /// [`DynaError`] if no run can have the schedule, a system fails or a model cannot be fitted.
    pub fn run<E: Environment>(
        &self,
        env: &mut dyn Environment,
        judges: &mut [E],
        explorer: &mut dyn Explorer,
        agent: &mut dyn Agent,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Practised<L::Model>, DynaError> {
        self.schedule.check()?;
        let spec = self.task.spec();
        let schedule = self.schedule;
        let inverse = schedule.branches.as_ref().map(|_| Inverse::of(spec)).transpose()?;
        let (m, k) = (spec.observation_dim(), spec.action_space.action_dim());
        let mut practice = Practice {
            data: Dataset::new(m, spec.control_dim(), k, spec.dt),
            replay: Replay::new(schedule.replay_capacity, m, k),
            action: vec![0.0; k],
            control: vec![0.0; spec.control_dim()],
            held: 0,
            running: false,
        };
        let imagined_steps = schedule.branches.as_ref().map_or(1, |b| b.every * b.per_step * b.length * b.rounds_kept);
        let mut imagined = Replay::new(imagined_steps, m, k);
        let mut batch = Batch::zeros(schedule.batch_size, m, k);
        let mut real_rng = self.seed.stream("real system", 0);
        let mut fit_rng = self.seed.stream("identification", 0);
        let mut update_rng = self.seed.stream("updates", 0);
        let mut left = Practised {
            policy: agent.policy(),
            model: None,
            real_steps: 0,
            real_episodes: 0,
            updates: 0,
            model_steps: 0,
            diverged: 0,
            checks: Vec::new(),
            reached: false,
            failure: None,
            interrupted: false,
        };
        for step in 0..schedule.real_steps {
            if interrupted() {
                left.interrupted = true;
                break;
            }
            let acting = step >= schedule.first_steps;
            let actor = match acting {
                true => Actor::Policy(agent, Mode::Explore),
                false => Actor::Explorer(&mut *explorer),
            };
            practice.step(env, actor, schedule.held_steps, &mut real_rng)?;
            left.real_steps = step + 1;
            if acting {
                if let (Some(branches), Some(inverse)) = (&schedule.branches, &inverse)
                    && (step - schedule.first_steps).is_multiple_of(branches.every)
                {
                    match self.learner.fit(&practice.data, left.model.as_deref(), &mut fit_rng) {
                        Ok(fitted) => left.model = fitted.map(|k| k.model).or(left.model),
                        Err(FitError::Interrupted) => {
                            left.interrupted = true;
                            break;
                        }
                        Err(error) => return Err(error.into()),
                    }
                    if let Some(model) = &left.model {
                        let stage = Stage { model: &**model, task: self.task, sensors: self.sensors, inverse };
                        let count = branches.every * branches.per_step;
                        let round = (self.seed, step as u64);
                        let done = stage.branch(count, branches, agent, &practice.replay, &mut imagined, round);
                        left.model_steps += done.steps;
                        left.diverged += done.diverged;
                    }
                }
                for _ in 0..schedule.updates_per_step {
                    self.mix(&practice.replay, &imagined, &mut batch, &mut update_rng);
                    if let Err(error) = agent.learn(&batch, &mut update_rng) {
                        left.failure = Some(error);
                        break;
                    }
                    left.updates += 1;
                }
            }
            if left.failure.is_some() {
                break;
            }
            if left.real_steps.is_multiple_of(schedule.checks.every) {
                left.policy = agent.policy();
                self.check(judges, &mut left)?;
                if left.reached {
                    break;
                }
            }
        }
        left.policy = agent.policy();
        left.real_episodes = practice.data.n_rollouts();
        Ok(left)
    }

    /// Fills `batch` from both memories.
    fn mix(&self, real: &Replay, imagined: &Replay, batch: &mut Batch, rng: &mut Rng) {
        let share = self.schedule.branches.as_ref().map_or(1.0, |b| b.real_share);
        let n_real = if imagined.is_empty() { batch.len() } else { (share * batch.len() as f64).round() as usize };
        let (n_real, n) = (n_real.min(batch.len()), batch.len());
        real.sample_rows_into(batch, 0..n_real, rng);
        imagined.sample_rows_into(batch, n_real..n, rng);
    }

    fn check<M, E: Environment>(&self, judges: &mut [E], left: &mut Practised<M>) -> Result<(), DynaError> {
        let checks = &self.schedule.checks;
        let stream = format!("check {}", left.checks.len());
        let returns =
            evaluate(judges, &*left.policy, checks.episodes, self.seed, &stream).map_err(CollectError::from)?;
        let check = Check { real_steps: left.real_steps, updates: left.updates, returns };
        left.reached = checks.until.is_some_and(|wanted| check.mean() >= wanted);
        left.checks.push(check);
        Ok(())
    }
}

/// The real system in use.
struct Practice {
    data: Dataset,
    replay: Replay,
    action: Vec<f64>,
    control: Vec<f64>,
    /// Steps for which the action is still held.
    held: usize,
    running: bool,
}

impl Practice {
    /// One real step; an action is held for `held_steps`.
    fn step(
        &mut self,
        env: &mut dyn Environment,
        mut actor: Actor<'_>,
        held_steps: usize,
        rng: &mut Rng,
    ) -> Result<(), CollectError> {
        if !self.running {
            env.reset(rng)?;
            self.data.begin(env.observation())?;
            self.held = 0;
        }
        let before = env.observation().to_vec();
        if self.held > 0 {
            self.held -= 1;
        } else {
            actor.act(&before, &self.data, rng, &mut self.action);
            self.held = held_steps.saturating_sub(1);
        }
        let outcome = env.step(&self.action, rng)?;
        // The environment accepted the action, so it is one of the space's.
        env.spec().action_space.control_into(&self.action, &mut self.control);
        self.data.push(&self.action, &self.control, outcome.reward, env.observation())?;
        self.replay.push(Transition {
            observation: &before,
            action: &self.action,
            reward: outcome.reward,
            next_observation: env.observation(),
            terminated: outcome.terminated,
        });
        self.running = !(outcome.terminated || outcome.truncated);
        if !self.running {
            self.data.finish(if outcome.terminated { End::Terminated } else { End::Truncated });
        }
        Ok(())
    }
}
