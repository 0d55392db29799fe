//! One run of one method on one task.

use std::sync::Arc;

use sindyna_control::{ByHand, Costs, Lqr};
use sindyna_core::{Dataset, Dynamics, DynamicsLearner, FitError, Knowledge, NoModel, Observer, Policy, Rng, Seed};
use sindyna_dyna::{Dyna, Learned, Online, Practised, Uniform, evaluate};
use sindyna_envs::System;
use sindyna_rl::{EnsembleConfig, EnsembleLearner, Isa, SacConfig, SavedPolicy};
use sindyna_sindy::{Identifier, Model, NoiseChoice};

use super::method::Method;
use super::outcome::{Outcome, Point, mean};
use super::presets::{ENOUGH, Preset, mbpo, sac};
use crate::config::{AnyAgent, TrainConfig, agent};
use crate::failure::Failure;
use crate::registry;

/// Episodes of the last evaluation.
const EPISODES: usize = 100;

/// What has to be done.
#[derive(Clone)]
pub(crate) struct Job {
    pub(crate) system: System,
    pub(crate) method: Method,
    pub(crate) seed: u64,
    /// Real steps at most for those who learn on the real system, if they are not the task's.
    pub(crate) budget: Option<usize>,
    /// Whether they go on after they have solved the task.
    pub(crate) whole_budget: bool,
}

impl Job {
    /// Does it. What goes wrong is part of the outcome; `None` if it was interrupted.
    pub(crate) fn run(&self, interrupted: &dyn Fn() -> bool) -> Option<Outcome> {
        let mut outcome = Outcome::new(self.system.name(), self.method.name(), self.seed);
        match self.attempt(&mut outcome, interrupted) {
            Ok(Ended::Whole) => Some(outcome),
            Ok(Ended::Interrupted) => None,
            Err(failure) => {
                let text = failure.to_string();
                outcome.failure = Some(text.strip_prefix("error: ").unwrap_or(&text).to_owned());
                Some(outcome)
            }
        }
    }

    fn attempt(&self, outcome: &mut Outcome, interrupted: &dyn Fn() -> bool) -> Result<Ended, Failure> {
        let spec = self.system.spec();
        match self.method {
            Method::Sindy => self.inside(
                &Identifier::new(spec).with_noise(NoiseChoice::Estimated),
                outcome,
                interrupted,
                |model: &Model, outcome| {
                    outcome.model_parameters = Some(model.nonzero());
                    outcome.equations = model.equations();
                    outcome.model = serde_json::from_str(&model.to_json()).ok();
                },
            ),
            Method::Truth => self.inside(&Known(self.system.dynamics()), outcome, interrupted, |_, _| {}),
            Method::Sac | Method::Sac20 | Method::Mbpo | Method::MbpoPaper => {
                let preset = self.preset().ok_or_else(|| Failure::new("this method has no settings"))?;
                self.outside(&preset, outcome, interrupted)
            }
            Method::Lqr => self.regulate(outcome),
            Method::Hand => {
                let law = ByHand::new(self.system.name());
                let law = law.ok_or_else(|| Failure::new("nobody has written a controller for this task"))?;
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
    pub(crate) fn settings(&self) -> Result<Option<String>, Failure> {
        Ok(match self.method {
            Method::Sindy | Method::Truth | Method::Lqr => {
                Some(TrainConfig { seed: 0, ..self.inner_settings() }.to_toml()?)
            }
            _ => self.preset().as_ref().map(toml::to_string).transpose()?,
        })
    }

    /// Real steps before which no run of those who learn on the real system can count as solved.
    pub(crate) fn steps_to_be_solved(&self) -> Option<usize> {
        Some(Self { budget: None, ..self.clone() }.preset()?.schedule.checks.every * ENOUGH)
    }

    /// What those learn with who learn on the real system.
    fn preset(&self) -> Option<Preset> {
        let spec = self.system.spec();
        let mut preset = match self.method {
            Method::Sac => sac(spec, 1),
            Method::Sac20 => sac(spec, 20),
            Method::Mbpo => mbpo(spec, EnsembleConfig::janner()),
            Method::MbpoPaper => mbpo(spec, EnsembleConfig::paper()),
            _ => return None,
        };
        if let Some(budget) = self.budget {
            preset.schedule.real_steps = budget;
            // Who may not go so far is looked at where the steps end.
            preset.schedule.checks.every = preset.schedule.checks.every.min(budget);
        }
        if self.whole_budget {
            preset.schedule.checks.enough = 0;
        }
        Some(preset)
    }

    /// The settings of `sindyna train`.
    fn inner_settings(&self) -> TrainConfig {
        TrainConfig { seed: self.seed, ..TrainConfig::defaults(self.system.spec()) }
    }

    /// Algorithm 1 with the models of `learner`.
    fn inside<L: DynamicsLearner>(
        &self,
        learner: &L,
        outcome: &mut Outcome,
        interrupted: &dyn Fn() -> bool,
        tell: fn(&L::Model, &mut Outcome),
    ) -> Result<Ended, Failure> {
        let (spec, seed) = (self.system.spec(), Seed::new(self.seed));
        let config = self.inner_settings();
        let (task, sensors, schedule) = (self.system.task(), self.system.sensors(), config.schedule()?);
        let dyna = Dyna { task: &*task, sensors: &sensors, learner, schedule: &schedule, seed };
        let mut env = self.system.environment();
        let mut explorer = registry::explorer(&config.warmup.explorer, spec)?;
        let learned = match self.agent(config.sac.clone())? {
            AnyAgent::Sac(sac) => dyna
                .run(&mut env, &mut *explorer, sac, &mut Silent, interrupted)
                .map(|l| l.map_policy(SavedPolicy::from)),
            AnyAgent::SacDiscrete(sac) => dyna
                .run(&mut env, &mut *explorer, sac, &mut Silent, interrupted)
                .map(|l| l.map_policy(SavedPolicy::from)),
        };
        let learned: Learned<L::Model, SavedPolicy> = learned?;
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
            self.judge(policy, outcome)?;
            // The paper's protocol looks at ten episodes; they are of the same start states as the checks of the others.
            let returns = self.returns(policy, 10, "check")?;
            outcome.curve.push(Point { real_steps: outcome.real_steps, updates: outcome.updates, returns });
        }
        Ok(Ended::Whole)
    }

    /// Learning on the real system, with what the ensemble of `preset` makes of its data, if it has one.
    fn outside(
        &self,
        preset: &Preset,
        outcome: &mut Outcome,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Ended, Failure> {
        let Some(ensemble) = preset.ensemble.clone() else {
            return self.online(&NoModel, preset, outcome, interrupted);
        };
        let learner = EnsembleLearner::new(ensemble, self.system.spec())?;
        outcome.model_parameters = Some(learner.n_parameters());
        self.online(&learner, preset, outcome, interrupted)
    }

    fn online<L: DynamicsLearner>(
        &self,
        learner: &L,
        preset: &Preset,
        outcome: &mut Outcome,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Ended, Failure> {
        let (spec, seed) = (self.system.spec(), Seed::new(self.seed));
        let (task, sensors) = (self.system.task(), self.system.sensors());
        let online = Online { task: &*task, sensors: &sensors, learner, schedule: &preset.schedule, seed };
        let mut env = self.system.environment();
        let mut judges: Vec<_> = (0..preset.schedule.checks.episodes).map(|_| self.system.environment()).collect();
        let mut explorer = Uniform::new(spec);
        match self.agent(preset.sac.clone())? {
            AnyAgent::Sac(sac) => {
                let left = online.run(&mut env, &mut judges, &mut explorer, sac, interrupted)?;
                self.account(left, outcome)
            }
            AnyAgent::SacDiscrete(sac) => {
                let left = online.run(&mut env, &mut judges, &mut explorer, sac, interrupted)?;
                self.account(left, outcome)
            }
        }
    }

    fn account<M, P: Policy>(&self, left: Practised<M, P>, outcome: &mut Outcome) -> Result<Ended, Failure> {
        if left.interrupted {
            return Ok(Ended::Interrupted);
        }
        (outcome.real_steps, outcome.real_episodes) = (left.real_steps, left.real_episodes);
        (outcome.updates, outcome.model_steps) = (left.updates, left.model_steps);
        outcome.failure = left.failure.as_ref().map(ToString::to_string);
        let points = left.checks.into_iter();
        outcome.curve =
            points.map(|c| Point { real_steps: c.real_steps, updates: c.updates, returns: c.returns }).collect();
        self.judge(&left.policy, outcome)?;
        // A task is solved where the first of so many checks in a row began that all reach the mark.
        let reaches = |point: &Point| self.system.spec().solved_at.is_some_and(|mark| mean(&point.returns) >= mark);
        let solved = outcome.curve.windows(ENOUGH).find(|checks| checks.iter().all(reaches));
        outcome.solved_after = solved.map(|checks| checks[0].real_steps);
        Ok(Ended::Whole)
    }

    /// A regulator of a linear model of the warm-up's data.
    fn regulate(&self, outcome: &mut Outcome) -> Result<Ended, Failure> {
        let spec = self.system.spec();
        let data = self.warm_up()?;
        (outcome.real_steps, outcome.real_episodes) = (data.n_steps(), data.n_rollouts());
        let model = Identifier::linear(spec)?.identify(&data)?.model;
        outcome.model_parameters = Some(model.nonzero());
        let (x, u) = (vec![0.0; spec.state_dim()], vec![0.0; spec.control_dim()]);
        let mut rng = Seed::new(self.seed).stream("differences", 0);
        let lqr = Lqr::around(&model, spec, (&x, &u), &Costs::of_scales(spec), &mut rng)?;
        self.judge(&lqr, outcome)?;
        Ok(Ended::Whole)
    }

    /// The real data that `sindyna train` begins with, for the same seed.
    fn warm_up(&self) -> Result<Dataset, Failure> {
        let spec = self.system.spec();
        let config = self.inner_settings();
        let (task, sensors, schedule) = (self.system.task(), self.system.sensors(), config.schedule()?);
        let seed = Seed::new(self.seed);
        // A learner that makes no model ends after the warm-up.
        let dyna = Dyna { task: &*task, sensors: &sensors, learner: &NoModel, schedule: &schedule, seed };
        let mut explorer = registry::explorer(&config.warmup.explorer, spec)?;
        let mut env = self.system.environment();
        let none = || false;
        Ok(match self.agent(config.sac)? {
            AnyAgent::Sac(sac) => dyna.run(&mut env, &mut *explorer, sac, &mut Silent, &none)?.data,
            AnyAgent::SacDiscrete(sac) => dyna.run(&mut env, &mut *explorer, sac, &mut Silent, &none)?.data,
        })
    }

    fn agent(&self, settings: SacConfig) -> Result<AnyAgent, Failure> {
        let mut weights = Seed::new(self.seed).stream("initial weights", 0);
        agent(settings, self.system.spec(), Isa::widest(), &mut weights)
    }

    /// The last evaluation; a policy that reaches the mark there has solved the task with the real steps so far.
    fn judge(&self, policy: &dyn Policy, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.returns = self.returns(policy, EPISODES, "evaluation")?;
        let solved = self.system.spec().solved_at.is_some_and(|mark| mean(&outcome.returns) >= mark);
        outcome.solved_after = solved.then_some(outcome.real_steps);
        Ok(())
    }

    fn returns(&self, policy: &dyn Policy, episodes: usize, stream: &str) -> Result<Vec<f64>, Failure> {
        let mut envs: Vec<_> = (0..episodes).map(|_| self.system.environment()).collect();
        Ok(evaluate(&mut envs, policy, episodes, Seed::new(self.seed), stream)?)
    }
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
