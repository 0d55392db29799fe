//! `config.toml`: everything that is needed to run a run again.

use serde::{Deserialize, Serialize};
use sindyna_core::{Agent, Channel, Dataset, Precision, Rng, Space, Spec, Task};
use sindyna_dyna::{Optimality, Refit, Rollouts, Schedule};
use sindyna_rl::{Isa, Sac, SacConfig, SacDiscrete, Scaling};
use sindyna_sindy::{Identifier, NoiseChoice};

use super::{
    ControllerName, ExplorerName, IdentificationConfig, ImaginedRollouts, IsaName, PrecisionName, SimulatorName,
    overrides,
};
use crate::Error;
use crate::shown::shown;

/// Name of the log in a run directory, and in that of an identification.
pub const RECORDED_LOG: &str = "data.csv";

/// Name of what was identified in it, in a run directory and in that of an identification.
pub const RECORDED_MODELS: &str = "posterior.bin";

/// The settings of `sindyna train`, defaults filled in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainConfig {
    /// Version of sindyna that wrote this.
    pub version: String,
    /// Commit it was built from.
    pub commit: String,
    /// Name of the task.
    pub task: String,
    /// The task file, relative to this one; none for the tasks that need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task_file: Option<String>,
    /// The log that takes the place of a system; none where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<DataConfig>,
    /// Where the system lives: `native`, `mujoco`, `pipe` for a program, or `none` for a log.
    pub simulator: SimulatorName,
    /// Standard deviation of the sensors' noise, as a fraction of every observation channel's scale.
    #[serde(default)]
    pub noise: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Where the controller comes from; not written while it is trained.
    #[serde(default, skip_serializing_if = "ControllerName::trains")]
    pub controller: ControllerName,
    /// Instructions of the updates, `portable`, `avx2` or `avx512`; none for the widest of whatever machine runs it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub isa: Option<IsaName>,
    /// Real data before anything is learned.
    pub warmup: Warmup,
    /// How equations are found.
    pub identification: IdentificationConfig,
    /// Rollouts in the learned model.
    pub imagination: ImaginationConfig,
    /// When training stops.
    pub optimality: OptimalityConfig,
    /// The agent.
    pub sac: SacConfig,
    /// Episodes of the evaluation.
    pub evaluation_episodes: usize,
}

/// A log in the place of a system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataConfig {
    /// The log, relative to this file.
    pub log: String,
    /// What was identified in it, relative to this file; earlier records have no such file.
    #[serde(default = "recorded_models")]
    pub models: String,
    /// Sampling interval \[s\].
    pub dt: f64,
    /// Time after which inputs begin to act \[s\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub delay: f64,
    /// Time constant of the lag through which they act \[s\]; 0 for none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lag: f64,
    /// How finely the states were recorded.
    pub precision: PrecisionName,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

fn recorded_models() -> String {
    RECORDED_MODELS.into()
}

/// Real data before anything is learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Warmup {
    /// Episodes at first.
    pub rollouts: usize,
    /// Steps of each.
    pub rollout_len: usize,
    /// Who chooses their actions.
    pub explorer: ExplorerName,
}

/// How rollouts are imagined.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImaginationConfig {
    /// N of Algorithm 1; `"auto"`, `"inf"` or a number.
    pub rollouts_per_real: ImaginedRollouts,
    /// Whether the model is fitted anew after every real rollout.
    pub refit: bool,
    /// Real steps at most in all, warm-up included; none for as many as it takes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_real_steps: Option<usize>,
    /// Rollouts in the learned model that go on side by side.
    #[serde(alias = "worlds")]
    pub systems: usize,
    /// Steps of one, at most.
    pub rollout_len: usize,
    /// Share of them that begin anywhere in the support of the data instead of at the task's start states.
    pub scattered_starts: f64,
    /// Steps of random actions before the policy acts.
    pub random_steps: usize,
    /// Updates after each step of all of them.
    pub updates_per_turn: usize,
    /// Transitions that are kept.
    pub replay_capacity: usize,
}

/// When training stops.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OptimalityConfig {
    /// Updates between two trials of the policy in the model.
    pub trial_every: u64,
    /// Episodes of a trial.
    pub trial_episodes: usize,
    /// Trials in a row within `tolerance` of the best; never in older files, which waited for `patience`.
    #[serde(default = "never")]
    pub settled: usize,
    /// Trials without a gain until training stops.
    pub patience: usize,
    /// Share of the spread of returns that counts as a gain.
    #[serde(default = "one_percent")]
    pub gain: f64,
    /// Of older files, without a meaning: training does not know what return counts as solved.
    #[serde(default, rename = "patience_when_sure", skip_serializing)]
    pub _patience_when_sure: Option<usize>,
    /// Within which of the best a trial counts as settled.
    pub tolerance: f64,
    /// Updates at most.
    pub max_updates: u64,
}

fn never() -> usize {
    usize::MAX
}

fn one_percent() -> f64 {
    0.01
}

impl TrainConfig {
    /// The ground-truth simulator, where it is one that comes along.
    pub fn system(&self) -> Option<sindyna_envs::System> {
        if self.task_file.is_none() { sindyna_envs::find(&self.task) } else { None }
    }

    /// The defaults for `task`: one rule for all, no knowledge of any single one.
    pub fn defaults(task: &dyn Task) -> Self {
        let schedule = Schedule::new(task.max_steps());
        let rule = &schedule.optimality;
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: crate::COMMIT.into(),
            task: task.spec().name.clone(),
            task_file: None,
            data: None,
            simulator: SimulatorName::Native,
            noise: 0.0,
            seed: 0,
            controller: ControllerName::Sac,
            isa: None,
            warmup: Warmup {
                rollouts: schedule.warmup_rollouts,
                rollout_len: schedule.rollout_len,
                explorer: ExplorerName::Swings,
            },
            identification: IdentificationConfig::default(),
            imagination: ImaginationConfig {
                rollouts_per_real: ImaginedRollouts(Rollouts::Auto),
                refit: schedule.refit == Refit::AfterRollouts,
                max_real_steps: schedule.max_real_steps,
                systems: schedule.systems,
                rollout_len: schedule.imagined_len,
                scattered_starts: schedule.scattered_starts,
                random_steps: schedule.random_steps,
                updates_per_turn: schedule.updates_per_turn,
                replay_capacity: schedule.replay_capacity,
            },
            optimality: OptimalityConfig {
                trial_every: rule.trial_every,
                trial_episodes: rule.trial_episodes,
                settled: rule.settled,
                patience: rule.patience,
                _patience_when_sure: None,
                tolerance: rule.tolerance,
                gain: rule.gain,
                max_updates: rule.max_updates,
            },
            sac: SacConfig { discount: schedule.discount, ..SacConfig::in_model() },
            evaluation_episodes: 100,
        }
    }

    /// Makes these the settings of a run on `log`, made of samples every `dt` \[s\], whose inputs act after `delay` \[s\] and through a lag with the time constant `lag` \[s\]: all of it at once, and no system to ask again.
    pub fn on_log(&mut self, log: &Dataset, (dt, delay, lag): (f64, f64, f64), precision: Precision) {
        self.data = Some(DataConfig {
            log: RECORDED_LOG.into(),
            models: RECORDED_MODELS.into(),
            dt,
            delay,
            lag,
            precision: precision.into(),
        });
        (self.warmup.rollouts, self.warmup.rollout_len) = (1, log.n_steps());
        self.imagination.rollouts_per_real = ImaginedRollouts(Rollouts::Unlimited);
        self.imagination.refit = false;
    }

    /// Reads a `config.toml`.
    pub fn parse(text: &str) -> Result<Self, Error> {
        toml::from_str(text).map_err(|e| Error::Configuration { why: e.to_string() })
    }

    /// Notes the version and commit that run these settings.
    pub fn stamp(&mut self) {
        self.version = env!("CARGO_PKG_VERSION").into();
        self.commit = crate::COMMIT.into();
    }

    /// Writes a `config.toml`.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|e| Error::Configuration { why: e.to_string() })
    }

    /// The same with one setting changed by `text`, a `KEY=VALUE` such as `sac.reward_scale=1`.
    pub fn with(self, text: &str) -> Result<Self, Error> {
        let refused = |why: &str| Error::Override { text: text.to_owned(), why: why.to_owned() };
        if text.trim_start().starts_with("data.") {
            return Err(refused(
                "what was identified in the log is no setting; --delay and --lag with --data change how it is read",
            ));
        }
        let mut document = toml::from_str(&self.to_toml()?).map_err(|e| refused(e.message()))?;
        overrides::change(&mut document, text)?;
        let document = toml::to_string(&document).map_err(|e| refused(&e.to_string()))?;
        toml::from_str(&document).map_err(|e: toml::de::Error| refused(e.message()))
    }

    /// The identification these settings describe. How noisy the sensors are is not told: it is estimated.
    pub fn identifier(&self, spec: &Spec) -> Result<Identifier, Error> {
        let identifier = self.identification.identifier(&shown(spec))?.with_noise(NoiseChoice::Estimated);
        let (steps, needed) = (self.warmup.rollouts * self.warmup.rollout_len, identifier.needed_rows());
        if steps < needed {
            return Err(Error::TooFewSteps { task: spec.name.clone(), steps, needed });
        }
        Ok(identifier)
    }

    /// The agent these settings describe, with weights drawn from `rng`: of the kind the actions ask for.
    pub fn agent(&self, spec: &Spec, rng: &mut Rng) -> Result<Box<dyn Agent>, Error> {
        agent(self.sac.clone(), spec, self.isa()?, rng)
    }

    /// The instructions asked for, if there are such and this machine has them; else its widest.
    pub fn isa(&self) -> Result<Isa, Error> {
        match self.isa {
            Some(name) => Ok(name.isa().checked()?),
            None => Ok(Isa::widest()),
        }
    }

    /// The schedule these settings describe.
    pub fn schedule(&self) -> Schedule {
        Schedule {
            warmup_rollouts: self.warmup.rollouts,
            rollout_len: self.warmup.rollout_len,
            // Who names an explorer is taken at his word.
            curious: self.warmup.explorer == ExplorerName::Swings,
            imagined_rollouts: self.imagination.rollouts_per_real.0,
            refit: if self.imagination.refit { Refit::AfterRollouts } else { Refit::Never },
            systems: self.imagination.systems,
            imagined_len: self.imagination.rollout_len,
            scattered_starts: self.imagination.scattered_starts,
            random_steps: self.imagination.random_steps,
            updates_per_turn: self.imagination.updates_per_turn,
            batch_size: self.sac.batch_size,
            replay_capacity: self.imagination.replay_capacity,
            max_real_steps: self.imagination.max_real_steps,
            discount: self.sac.discount,
            optimality: Optimality {
                trial_every: self.optimality.trial_every,
                trial_episodes: self.optimality.trial_episodes,
                settled: self.optimality.settled,
                patience: self.optimality.patience,
                gain: self.optimality.gain,
                tolerance: self.optimality.tolerance,
                max_updates: self.optimality.max_updates,
            },
        }
    }
}

/// An agent of the kind the actions of `spec` ask for.
pub fn agent(settings: SacConfig, spec: &Spec, isa: Isa, rng: &mut Rng) -> Result<Box<dyn Agent>, Error> {
    let scaling = scaling(spec);
    Ok(match &spec.action_space {
        Space::Box { low, high } => Box::new(Sac::new(settings, scaling, low, high, rng)?.with_isa(isa)?),
        Space::Discrete { controls } => {
            Box::new(SacDiscrete::new(settings, scaling, controls.nrows(), rng)?.with_isa(isa)?)
        }
    })
}

/// Observations scaled to about −1..1: by their declared bounds, else by their typical magnitude.
fn scaling(spec: &Spec) -> Scaling {
    let of = |c: &Channel| match c.prior.bounds {
        (low, high) if c.is_bounded() => (0.5 * (low + high), 0.5 * (high - low)),
        _ => (0.0, c.prior.scale),
    };
    let (center, scale) = spec.observation.iter().map(of).unzip();
    Scaling { center, scale }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn defaults() -> TrainConfig {
        TrainConfig::defaults(sindyna_envs::find("pendulum").expect("it is registered").task().as_ref())
    }

    #[test]
    fn a_configuration_survives_its_file() {
        let config = defaults();
        assert_eq!(TrainConfig::parse(&config.to_toml().unwrap()).unwrap(), config);
    }

    #[test]
    fn any_setting_can_be_changed_and_unknown_ones_are_answered() {
        let config = defaults().with("sac.reward_scale=1").unwrap().with("sac.hidden = [32, 32]").unwrap();
        let config = config.with("warmup.explorer=random").unwrap();
        assert_eq!((config.sac.reward_scale, config.sac.hidden.clone()), (1.0, vec![32, 32]));
        assert_eq!(config.warmup.explorer, ExplorerName::Random);
        assert_eq!(config.with("sac.target_entropy=-2").unwrap().sac.target_entropy, Some(-2.0));
        let config = TrainConfig { seed: u64::MAX, ..defaults() }.with("sac.polyak=1").unwrap();
        let config = config.with("identification.terms=['v*abs(v)', \"x\"]").unwrap();
        assert_eq!((config.seed, config.sac.polyak, config.identification.terms.len()), (u64::MAX, 1.0, 2));
        assert_eq!(config.with("seed=9223372036854775808").unwrap().seed, 1 << 63);
        for (text, says) in [
            ("sac.reward_scal=1", "`reward_scale`"),
            ("sac.reward_scale=much", "reward_scale"),
            ("sac.target_entropy=little", "target_entropy"),
            ("seed.x=1", "not a group"),
            ("seed", "KEY=VALUE"),
            ("seed=-1", "seed=-1: "),
            ("seed=18446744073709551616", "seed=18446744073709551616: "),
            ("imagination.systems=1\nseed=3", "imagination.systems=1"),
        ] {
            let refusal = defaults().with(text).unwrap_err().to_string();
            assert!(refusal.contains(says), "{text}: {refusal}");
        }
    }
}
