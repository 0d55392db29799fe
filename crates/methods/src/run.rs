//! One run of one method on one task.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;
use sindyna_control::{ByHand, Costs, Lqr};
use sindyna_core::{
    Agent, Dataset, Dynamics, DynamicsLearner, Environment, Explorer, FitError, Knowledge, NoModel, Observer, Policy,
    Rng, Seed,
};
use sindyna_dyna::{Dyna, Gentle, Online, Practised, Schedule, Uniform, evaluate};
use sindyna_record::comparison::{Outcome, Point, Request, Seeds, mean, noisy};
use sindyna_rl::{EnsembleConfig, EnsembleLearner, Isa, SacConfig};
use sindyna_sindy::{Identifier, Model};
use sindyna_training::problem::Problem;
use sindyna_training::settings::{TrainConfig, agent};
use sindyna_training::{Fitted, Learner};

use super::error::chain;
use super::method::Method;
use super::presets::{self, EPISODES, Preset};
use super::{Contender, MethodError};

/// The real data that a regulator's linear model is fitted to: short episodes and small actions, so that states stay near the equilibrium.
const PUSHES: Pushes = Pushes { episodes: 6, steps: 5, share: 0.1 };

#[derive(Serialize)]
struct Pushes {
    episodes: usize,
    /// Real steps of each.
    steps: usize,
    /// Part of the range of the actions.
    share: f64,
}

/// What the regulators minimise, and where.
const COSTS: &str = "Around zero, with a cost of 1/scale² for every state and control (Bryson's rule)";

/// What has to be done.
#[derive(Clone)]
pub struct Job {
    /// The system with its task.
    pub system: Arc<dyn Problem>,
    /// Standard deviation of the sensors' noise, which `system` has, as a fraction of their scales.
    pub noise: f64,
    /// Who has to do it.
    pub contender: Contender,
    /// Seed of everything random.
    pub seed: u64,
    /// Real steps at most for those who learn on the system, if they are not the task's.
    pub budget: Option<usize>,
    /// Whether they go on after they have solved the task.
    pub whole_budget: bool,
}

impl fmt::Display for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} seed {}", self.task(), self.contender.name(), self.seed)
    }
}

impl Job {
    /// What it asks for.
    pub fn request(&self) -> Request {
        Request { task: self.task(), method: self.contender.name(), seeds: Seeds::one(self.seed) }
    }

    /// What the comparison calls its task.
    pub fn task(&self) -> String {
        noisy(&self.system.spec().name, self.noise)
    }

    fn environments(&self, count: usize) -> Result<Vec<Box<dyn Environment>>, MethodError> {
        Ok((0..count).map(|_| self.system.environment()).collect::<Result<_, _>>()?)
    }

    /// The method, without its variant.
    pub fn method(&self) -> Method {
        self.contender.method
    }

    /// Does it until `stop` is set. What goes wrong is part of the outcome; `None` if it was interrupted.
    pub fn run(&self, stop: &Arc<AtomicBool>) -> Option<Outcome> {
        let mut outcome = Outcome::new(&self.task(), &self.contender.name(), self.seed);
        match self.attempt(&mut outcome, stop) {
            Ok(Ended::Whole) => Some(outcome),
            Ok(Ended::Interrupted) => None,
            Err(error) => {
                outcome.failure = Some(chain(&error));
                Some(outcome)
            }
        }
    }

    fn attempt(&self, outcome: &mut Outcome, stop: &Arc<AtomicBool>) -> Result<Ended, MethodError> {
        let spec = self.system.spec();
        match self.method() {
            Method::Sindy => self.inside(&self.learner(stop)?, outcome, stop, |Fitted(found), outcome| {
                tell(&found.model, outcome);
            }),
            Method::LeastSquares => self.inside(&Identifier::linear(spec)?, outcome, stop, |model, outcome| {
                outcome.model_parameters = Some(model.nonzero());
            }),
            Method::Ensemble => {
                let learner =
                    EnsembleLearner::new(presets::ensemble(EnsembleConfig::janner()), spec)?.until(stop.clone());
                outcome.model_parameters = Some(learner.n_parameters());
                self.inside(&learner, outcome, stop, |_, _| {})
            }
            Method::Oracle => {
                let truth = self.system.dynamics().ok_or_else(|| MethodError::NoTruth { task: self.task() })?;
                self.inside(&Known(truth), outcome, stop, |_, _| {})
            }
            Method::Sac | Method::Sac20 | Method::Mbpo | Method::MbpoPaper | Method::SindyMbpo => {
                let preset = self.preset().ok_or(MethodError::NoPreset { method: self.method().name() })?;
                self.outside(&preset, outcome, stop)
            }
            Method::Lqr => self.regulate_linear(outcome),
            Method::SindyLqr => self.regulate_identified(outcome),
            Method::Expert => {
                let law = ByHand::new(&self.system.spec().name);
                let law = law.ok_or_else(|| MethodError::NoExpert { task: self.task() })?;
                self.judge(&law, outcome)?;
                Ok(Ended::Whole)
            }
            Method::Random => {
                self.judge(&Uniform::new(spec), outcome)?;
                Ok(Ended::Whole)
            }
        }
    }

    /// The settings of the method on this task, as TOML, with seed 0 where a seed is one of them; none for those that have none.
    pub fn settings(&self) -> Result<Option<String>, MethodError> {
        Ok(match self.method() {
            Method::Sindy | Method::LeastSquares | Method::Ensemble | Method::Oracle => {
                let model = match self.method() {
                    Method::LeastSquares => {
                        "# The model is linear, fitted by least squares, instead of what [identification] says.\n"
                    }
                    Method::Ensemble => "# The model is the ensemble of mbpo, instead of what [identification] says.\n",
                    Method::Oracle => "# The model is the true one, instead of what [identification] says.\n",
                    _ => "",
                };
                Some(
                    model.to_owned()
                        + &TrainConfig { seed: 0, noise: self.noise, ..self.inner_settings()? }.to_toml()?,
                )
            }
            Method::SindyLqr => Some(format!("# {COSTS}; warm-up and identification are those of sindy.\n")),
            Method::Lqr => Some(format!("# {COSTS}.\n{}", toml::to_string(&PUSHES)?)),
            _ => self.preset().as_ref().map(toml::to_string).transpose()?,
        })
    }

    /// What those learn with who learn on the system.
    fn preset(&self) -> Option<Preset> {
        let mut preset = presets::of(self.method(), self.system.spec())?;
        if let Some(budget) = self.budget {
            preset.schedule.real_steps = budget;
            // Who may not go so far is looked at where the steps end.
            preset.schedule.checks.every = preset.schedule.checks.every.min(budget);
        }
        if !self.whole_budget {
            preset.schedule.checks.until = self.system.protocol().solved_at;
        }
        Some(preset)
    }

    /// The settings of `sindyna train`, with those of the variant.
    fn inner_settings(&self) -> Result<TrainConfig, MethodError> {
        let defaults = TrainConfig { seed: self.seed, ..TrainConfig::defaults(&*self.system.task()) };
        Ok(self.contender.settle(defaults)?)
    }

    /// Algorithm 1 with the models of `learner`.
    fn inside<L: DynamicsLearner>(
        &self,
        learner: &L,
        outcome: &mut Outcome,
        stop: &AtomicBool,
        tell: fn(&L::Model, &mut Outcome),
    ) -> Result<Ended, MethodError> {
        let (spec, seed) = (self.system.spec(), Seed::new(self.seed));
        let config = self.inner_settings()?;
        // How noisy the sensors are is told to nobody.
        let (task, sensors, schedule) = (self.system.task(), self.system.sensors().with_noise(&[]), config.schedule());
        let dyna = Dyna { task: &*task, sensors: &sensors, learner, schedule: &schedule, seed };
        let mut env = self.system.environment()?;
        let mut explorer = config.warmup.explorer.explorer(spec);
        let learned = dyna.run(&mut env, &mut *explorer, self.agent(config.sac)?, &mut Silent, &|| is_set(stop))?;
        if learned.interrupted {
            return Ok(Ended::Interrupted);
        }
        (outcome.real_steps, outcome.real_episodes) = (learned.data.n_steps(), learned.data.n_rollouts());
        (outcome.updates, outcome.model_steps) = (learned.updates, learned.model_steps);
        if let Some(model) = &learned.model {
            tell(model, outcome);
        }
        outcome.failure = learned.failure.as_ref().map(ToString::to_string);
        if let Some(policy) = &learned.policy {
            self.judge(&**policy, outcome)?;
            let (real_steps, updates, returns) = (outcome.real_steps, outcome.updates, outcome.returns.clone());
            outcome.curve.push(Point { real_steps, updates, returns });
        }
        Ok(Ended::Whole)
    }

    /// Learning on the system, with what the ensemble of `preset` or identified equations make of its data, if it has them.
    fn outside(&self, preset: &Preset, outcome: &mut Outcome, stop: &Arc<AtomicBool>) -> Result<Ended, MethodError> {
        let Some(ensemble) = preset.ensemble.clone() else {
            return match preset.schedule.branches {
                Some(_) => self.online(&self.learner(stop)?, preset, outcome, stop),
                None => self.online(&NoModel, preset, outcome, stop),
            };
        };
        let learner = EnsembleLearner::new(ensemble, self.system.spec())?.until(stop.clone());
        outcome.model_parameters = Some(learner.n_parameters());
        self.online(&learner, preset, outcome, stop)
    }

    fn online<L: DynamicsLearner>(
        &self,
        learner: &L,
        preset: &Preset,
        outcome: &mut Outcome,
        stop: &AtomicBool,
    ) -> Result<Ended, MethodError> {
        let (spec, seed) = (self.system.spec(), Seed::new(self.seed));
        let (task, sensors) = (self.system.task(), self.system.sensors().with_noise(&[]));
        let online = Online { task: &*task, sensors: &sensors, learner, schedule: &preset.schedule, seed };
        let mut env = self.system.environment()?;
        let mut judges = self.environments(preset.schedule.checks.episodes)?;
        let mut explorer = Uniform::new(spec);
        let agent = self.agent(preset.sac.clone())?;
        let left = online.run(&mut env, &mut judges, &mut explorer, agent, &|| is_set(stop))?;
        self.account(left, outcome)
    }

    fn account<M>(&self, left: Practised<M>, outcome: &mut Outcome) -> Result<Ended, MethodError> {
        if left.interrupted {
            return Ok(Ended::Interrupted);
        }
        (outcome.real_steps, outcome.real_episodes) = (left.real_steps, left.real_episodes);
        (outcome.updates, outcome.model_steps) = (left.updates, left.model_steps);
        outcome.failure = left.failure.as_ref().map(ToString::to_string);
        let points = left.checks.into_iter();
        outcome.curve =
            points.map(|c| Point { real_steps: c.real_steps, updates: c.updates, returns: c.returns }).collect();
        self.judge(&*left.policy, outcome)?;
        // The last evaluation is for what a run ends with; what counts as solved is the first check that reaches the mark.
        let reaches = |point: &&Point| {
            self.system.protocol().solved_at.zip(mean(&point.returns)).is_some_and(|(mark, reached)| reached >= mark)
        };
        outcome.solved_after = outcome.curve.iter().find(reaches).map(|check| check.real_steps);
        Ok(Ended::Whole)
    }

    /// A regulator of a linear model, fitted to small random pushes of its own.
    fn regulate_linear(&self, outcome: &mut Outcome) -> Result<Ended, MethodError> {
        let spec = self.system.spec();
        let data = self.warm_up(&mut Gentle::new(spec, PUSHES.share), (PUSHES.episodes, PUSHES.steps))?;
        let model = Identifier::linear(spec)?.identify(&data)?.model;
        self.regulate(&model, &data, outcome)
    }

    /// A regulator of the equations identified from the data that `sindy` begins with.
    fn regulate_identified(&self, outcome: &mut Outcome) -> Result<Ended, MethodError> {
        let (spec, config) = (self.system.spec(), self.inner_settings()?);
        let mut explorer = config.warmup.explorer.explorer(spec);
        let data = self.warm_up(&mut *explorer, (1, config.schedule().rollout_len))?;
        let model = self.identifier()?.identify(&data)?.model;
        tell(&model, outcome);
        self.regulate(&model, &data, outcome)
    }

    /// A regulator of `model`, which `data` was needed for, around the origin.
    fn regulate(&self, model: &Model, data: &Dataset, outcome: &mut Outcome) -> Result<Ended, MethodError> {
        let spec = self.system.spec();
        (outcome.real_steps, outcome.real_episodes) = (data.n_steps(), data.n_rollouts());
        outcome.model_parameters = Some(model.nonzero());
        let (x, u) = (vec![0.0; spec.state_dim()], vec![0.0; spec.control_dim()]);
        let mut rng = Seed::new(self.seed).stream("differences", 0);
        let lqr = Lqr::around(model, spec, (&x, &u), &Costs::of_scales(spec), &mut rng)?;
        self.judge(&lqr, outcome)?;
        Ok(Ended::Whole)
    }

    /// Who finds the equations, as `sindyna train` does.
    fn identifier(&self) -> Result<Identifier, MethodError> {
        Ok(self.inner_settings()?.identifier(self.system.spec())?)
    }

    /// The same as a learner, until `stop` is set.
    fn learner(&self, stop: &Arc<AtomicBool>) -> Result<Learner, MethodError> {
        Ok(Learner { identifier: self.identifier()?, given: None, stop: stop.clone() })
    }

    /// The first real steps, so many times so many, by `explorer`.
    fn warm_up(
        &self,
        explorer: &mut dyn Explorer,
        (warmup_rollouts, rollout_len): (usize, usize),
    ) -> Result<Dataset, MethodError> {
        let config = self.inner_settings()?;
        let schedule = Schedule { warmup_rollouts, rollout_len, ..config.schedule() };
        let (task, sensors, seed) = (self.system.task(), self.system.sensors(), Seed::new(self.seed));
        // A learner that makes no model ends after the warm-up.
        let dyna = Dyna { task: &*task, sensors: &sensors, learner: &NoModel, schedule: &schedule, seed };
        let mut env = self.system.environment()?;
        Ok(dyna.run(&mut env, explorer, self.agent(config.sac)?, &mut Silent, &|| false)?.data)
    }

    fn agent(&self, settings: SacConfig) -> Result<Box<dyn Agent>, MethodError> {
        let mut weights = Seed::new(self.seed).stream("initial weights", 0);
        Ok(agent(settings, self.system.spec(), Isa::widest(), &mut weights)?)
    }

    /// The last evaluation; a policy that reaches the mark there has solved the task with the real steps so far.
    fn judge(&self, policy: &dyn Policy, outcome: &mut Outcome) -> Result<(), MethodError> {
        let mut envs = self.environments(EPISODES)?;
        outcome.returns = evaluate(&mut envs, policy, EPISODES, Seed::new(self.seed), "evaluation")?;
        let solved =
            self.system.protocol().solved_at.zip(mean(&outcome.returns)).is_some_and(|(mark, reached)| reached >= mark);
        outcome.solved_after = solved.then_some(outcome.real_steps);
        Ok(())
    }
}

/// What is told of identified equations.
fn is_set(stop: &AtomicBool) -> bool {
    stop.load(Ordering::SeqCst)
}

fn tell(model: &Model, outcome: &mut Outcome) {
    outcome.model_parameters = Some(model.nonzero());
    outcome.equations = model.equations();
    outcome.model = serde_json::from_str(&model.to_json()).ok();
}

/// Whether a run came to its end.
enum Ended {
    Whole,
    Interrupted,
}

/// Who knows the true dynamics.
struct Known(Arc<dyn Dynamics>);

impl DynamicsLearner for Known {
    type Model = Arc<dyn Dynamics>;

    fn fit(
        &self,
        _: &Dataset,
        _: Option<&Self::Model>,
        _: &mut Rng,
    ) -> Result<Option<Knowledge<Self::Model>>, FitError> {
        Ok(Some(Knowledge::certain(self.0.clone())))
    }
}

/// Who does not watch.
struct Silent;

impl Observer for Silent {
    fn on(&mut self, _event: &sindyna_core::Event<'_>) -> std::io::Result<()> {
        Ok(())
    }
}
