//! Training a controller in identified equations.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sindyna_core::{Dataset, Environment, Event, Explorer, Mode, Observer, Policy, Seed, TrainedPolicy};
use sindyna_dyna::{Dyna, DynaError};
use sindyna_record::run::Summary;
use sindyna_sindy::{Identified, Model};

use crate::Error;
use crate::evaluation::evaluation;
use crate::in_model::in_model;
use crate::plan::Plan;
use crate::predicting::Predicting;
use crate::problem::{Late, Played, Problem, Replayed, named};
use crate::settings::TrainConfig;
use crate::summary;

/// A training with its settings. The same settings and seed give the same bits.
///
/// The loop is that of the command `sindyna train`: a few steps on the system, equations from them, soft actor-critic
/// in the equations, and an evaluation on the system.
#[derive(Clone)]
pub struct Training {
    problem: Arc<dyn Problem>,
    config: TrainConfig,
    /// Recorded data, instead of a warm-up.
    recorded: Option<Arc<Dataset>>,
    evaluated: bool,
}

/// The result of a [`Training`].
#[derive(Clone)]
pub struct Trained {
    /// The figures of the run, as in `summary.json`.
    pub summary: Summary,
    /// All data from the system.
    pub data: Dataset,
    /// The equations that the policy was trained in.
    pub model: Option<Model>,
    /// The same with their standard errors and doubts.
    pub identified: Option<Identified>,
    /// The policy; `None` if training produced none. Where inputs act late it predicts the state in which they will, and has a memory of those that have not acted yet ([`Policy::begin`]).
    pub policy: Option<Arc<dyn TrainedPolicy>>,
    action_dim: usize,
}

/// Whether a policy does what the task asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Verdict {
    /// The mean return reaches the threshold of the task.
    Solved,
    /// It does not.
    NotSolved,
    /// The task has no threshold.
    NoThreshold,
    /// Training produced no policy.
    NoPolicy,
}

impl Training {
    /// Training for the built-in task `task`, such as `pendulum`; [`problem::names`](crate::problem::names) lists them.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn named(task: &str) -> Result<Self, Error> {
        named(task).map(Self::shared)
    }

    /// Training for your own problem.
    #[must_use]
    pub fn of(problem: impl Problem + 'static) -> Self {
        Self::shared(Arc::new(problem))
    }

    /// Training for a shared problem.
    #[must_use]
    pub fn shared(problem: Arc<dyn Problem>) -> Self {
        let mut config = TrainConfig::defaults(&*problem.task());
        if let Some((log, dt)) = problem.log().zip(problem.sampling_interval()) {
            config.on_log(log, (dt, problem.delay(), problem.lag()), problem.spec().precision);
        }
        Self { problem, config, recorded: None, evaluated: true }
    }

    /// The same with another seed of the random numbers; the default is 0.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.config.seed = seed;
        self
    }

    /// The same with one setting changed by a `KEY=VALUE` such as `warmup.rollout_len=20`; [`Self::settings`] has all of them.
    ///
    /// # Errors
    /// [`Error::UnknownName`], [`Error::Override`].
    pub fn with(mut self, setting: &str) -> Result<Self, Error> {
        self.config = self.config.with(setting)?;
        Ok(self)
    }

    /// The same with recorded `data` of the system instead of the warm-up. The system is used only for further steps and for the evaluation.
    #[must_use]
    pub fn with_data(mut self, data: Dataset) -> Self {
        (self.config.warmup.rollouts, self.config.warmup.rollout_len) = (1, data.n_steps());
        self.recorded = Some(Arc::new(data));
        self
    }

    /// The same with at most `steps` on the system before the evaluation, recorded ones included; the default is no limit.
    #[must_use]
    pub fn with_max_real_steps(mut self, steps: usize) -> Self {
        self.config.imagination.max_real_steps = Some(steps);
        self
    }

    /// The same without the evaluation.
    #[must_use]
    pub fn without_evaluation(self) -> Self {
        Self { evaluated: false, ..self }
    }

    /// The same without the evaluation, and without further steps on the system after the recorded ones or the warm-up: for a system that is not available.
    #[must_use]
    pub fn without_system(self) -> Self {
        let steps = self.config.warmup.rollouts * self.config.warmup.rollout_len;
        self.with_max_real_steps(steps).without_evaluation()
    }

    /// All settings, as the TOML of `config.toml`.
    ///
    /// # Errors
    /// [`Error::Configuration`] for numbers that TOML cannot represent.
    pub fn settings(&self) -> Result<String, Error> {
        self.config.to_toml()
    }

    /// Trains and evaluates.
    ///
    /// # Errors
    /// [`Error::Setting`] for invalid settings, [`Error::Train`] if no equations are found or the system fails.
    pub fn run(&self) -> Result<Trained, Error> {
        self.run_watched(&mut |_| {}, &Arc::new(AtomicBool::new(false)))
    }

    /// The same with a callback `watch` for events; ends soon after `stop` is set, then without an evaluation.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub fn run_watched(&self, watch: &mut dyn FnMut(&Event<'_>), stop: &Arc<AtomicBool>) -> Result<Trained, Error> {
        let (config, problem) = (&self.config, &*self.problem);
        config.check()?;
        let mut plan = Plan::new(config, problem, stop.clone())?;
        // What was recorded cannot be chosen.
        plan.schedule.curious &= self.recorded.is_none();
        let (task, sensors) = (problem.task(), problem.sensors().with_noise(&[]));
        let seed = Seed::new(config.seed);
        let dyna = Dyna { task: &*task, sensors: &sensors, learner: &plan.learner, schedule: &plan.schedule, seed };
        let (mut env, mut explorer): (Box<dyn Environment>, Box<dyn Explorer>) = match &self.recorded {
            None => (problem.environment()?, plan.explorer),
            Some(data) => {
                let played = Played::new(problem.spec().clone(), data.clone(), Some(self.problem.clone()));
                (Box::new(played), Box::new(Replayed::new(data.clone(), Some(plan.explorer))))
            }
        };
        let made_by = (plan.agent.name(), plan.isa);
        let stopped = || stop.load(Ordering::SeqCst) || problem.check().is_err();
        let learned = dyna.run(&mut *env, &mut *explorer, plan.agent, &mut Told(watch), &stopped);
        problem.check()?;
        let mut learned = learned?;
        // A system of which there is one is free again.
        drop(env);
        let mut evaluated = None;
        let evaluated_too = self.evaluated && !learned.interrupted && problem.log().is_none();
        if let (Some(policy), true) = (&learned.policy, evaluated_too) {
            evaluated = Some(evaluation(problem, &**policy, config.evaluation_episodes, seed)?);
        }
        let policy = learned.policy.as_ref().map(|policy| &**policy as &dyn Policy);
        let in_model = in_model(problem, &learned, policy, (&|_, _| {}, &stopped));
        learned.interrupted |= in_model.is_none();
        let model = learned.model.as_ref().map(|fitted| fitted.0.model.clone());
        let late = Late::of((problem.delay(), problem.lag()), problem.spec().dt);
        let policy = match (learned.policy.clone(), &model) {
            (Some(policy), Some(model)) if !late.is_now() => {
                let predicting = Predicting::new(policy, problem, model.clone(), late)?;
                Some(Arc::new(predicting) as Arc<dyn TrainedPolicy>)
            }
            (policy, _) => policy,
        };
        Ok(Trained {
            summary: summary::of(config, made_by, problem, &learned, evaluated, in_model),
            model,
            identified: learned.model.as_ref().map(|fitted| fitted.0.clone()),
            policy,
            data: learned.data,
            action_dim: problem.spec().action_space.action_dim(),
        })
    }
}

impl Trained {
    /// Whether the policy does what the task asks for.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match (&self.summary.evaluation, self.summary.solved) {
            (None, _) => Verdict::NoPolicy,
            (_, None) => Verdict::NoThreshold,
            (_, Some(true)) => Verdict::Solved,
            (_, Some(false)) => Verdict::NotSolved,
        }
    }

    /// Return of each episode of the evaluation; none without a policy.
    #[must_use]
    pub fn returns(&self) -> &[f64] {
        self.summary.evaluation.as_ref().map_or(&[], |evaluation| &evaluation.returns)
    }

    /// The equations as text, one per state.
    #[must_use]
    pub fn equations(&self) -> &[String] {
        self.summary.identification.as_ref().map_or(&[], |identification| &identification.equations)
    }

    /// The best action of the policy for an observation, the first of an episode where it has a memory; `None` without a policy.
    #[must_use]
    pub fn act(&self, observation: &[f64]) -> Option<Vec<f64>> {
        let mut action = vec![0.0; self.action_dim];
        // The best action draws no random number.
        let mut rng = Seed::new(0).stream("best action", 0);
        self.policy.as_ref()?.act(observation, Mode::Exploit, &mut rng, &mut action);
        Some(action)
    }
}

/// A callback for events.
struct Told<'a>(&'a mut dyn FnMut(&Event<'_>));

impl Observer for Told<'_> {
    fn on(&mut self, event: &Event<'_>) -> io::Result<()> {
        (self.0)(event);
        Ok(())
    }
}

impl From<sindyna_dyna::ScheduleError> for Error {
    fn from(error: sindyna_dyna::ScheduleError) -> Self {
        Self::Train(DynaError::Schedule(error))
    }
}
