//! The settings of `sindyna train` as options, and how they change the defaults.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use clap::Args;
use sindyna_dyna::Rollouts;
use sindyna_training::RECORDED_TASK;
use sindyna_training::problem::{LogSource, PipeSource, Problem, Source, declared};
use sindyna_training::settings::{
    ControllerName, CoordinatesName, ExplorerName, ImaginedRollouts, IsaName, LibraryName, SimulatorName, TrainConfig,
    key,
};

use super::common::set;
use super::identification::IdentificationOptions;
use crate::cli::failure::Failure;

/// Options that change the defaults of a run, or of the configuration it repeats.
#[derive(Debug, Default, PartialEq, Args)]
pub(crate) struct Settings {
    /// Seed of the random numbers; equal seeds give equal records [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Task file (TOML): a task on a MuJoCo model or on equations, or with --data, --model or --pipe on a log or a program (docs/task-files.md)
    #[arg(long, value_name = "FILE", conflicts_with = "config")]
    task_file: Option<PathBuf>,
    /// Identify this log (CSV with the states and controls of --task-file as columns) and train in its equations, without a simulator
    #[arg(long, value_name = "LOG", requires = "task_file", conflicts_with_all = ["config", "model"])]
    data: Option<PathBuf>,
    /// Train in the equations of this output directory of `sindyna identify`, with coefficients drawn from their joint distribution
    #[arg(long, value_name = "DIR", requires = "task_file", conflicts_with = "config")]
    model: Option<PathBuf>,
    /// Repeat the run of this config.toml; other options change it
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Set any key of config.toml, such as `sac.reward_scale=1`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,

    /// Simulator of the system; `mujoco` for `inverted-pendulum` and task files [default: native]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Real data")]
    simulator: Option<SimulatorName>,
    /// Standard deviation of Gaussian sensor noise, as a fraction of each channel's scale (0 to 1), in training and evaluation; it is
    /// unknown to the learner [default: 0]
    #[arg(long, value_name = "FRACTION", help_heading = "Real data")]
    noise: Option<f64>,
    /// Real steps before the first fit, over all warm-up trajectories; more follow where the equations are not certain
    /// (--imagined-rollouts auto) [default: 10]
    #[arg(long, value_name = "STEPS", help_heading = "Real data", conflicts_with = "rollout_len")]
    real_steps: Option<usize>,
    /// Warm-up trajectories on the system before the first fit (N_e in Algorithm 1) [default: 1]
    #[arg(long, value_name = "N", help_heading = "Real data")]
    warmup_rollouts: Option<usize>,
    /// Steps of each warm-up trajectory (R in Algorithm 1); episodes that terminate early are followed by a new one [default: 10]
    #[arg(long, value_name = "STEPS", help_heading = "Real data")]
    rollout_len: Option<usize>,
    /// Policy of the warm-up [default: swings]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Real data")]
    explorer: Option<ExplorerName>,

    #[command(flatten)]
    identification: IdentificationOptions,
    /// Coordinates of the states [default: recognised; raw for the paper's libraries]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Identification")]
    coordinates: Option<CoordinatesName>,

    /// Controller: a policy trained in the equations, which `sindyna export` writes, or a planner in the equations, which it does not [default: sac]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Training")]
    controller: Option<ControllerName>,
    /// Rollouts in the learned model per real one (N in Algorithm 1). `inf`: no further real episodes. A number: real episodes follow, and each is compared with
    /// its prediction. `auto`: `inf` if the residuals are at the level of rounding, otherwise real episodes until one agrees with its prediction [default: auto]
    #[arg(long, value_name = "N|auto|inf", help_heading = "Training")]
    imagined_rollouts: Option<ImaginedRollouts>,
    /// Fit the model again after every real rollout [default: true]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true, help_heading = "Training")]
    refit: Option<bool>,
    /// Maximum number of real steps, including the warm-up; no episode begins that could exceed it [default: no limit]
    #[arg(long, value_name = "STEPS", help_heading = "Real data")]
    max_real_steps: Option<usize>,
    /// Maximum of updates [default: 60000]
    #[arg(long, value_name = "N", help_heading = "Training")]
    max_updates: Option<u64>,
    /// Learning rate of actor, critics and temperature [default: 0.002]
    #[arg(long, value_name = "X", help_heading = "Training")]
    learning_rate: Option<f64>,
    /// Discount γ [default: 1 − 1/max_steps of the task]
    #[arg(long, value_name = "X", help_heading = "Training")]
    discount: Option<f64>,
    /// Transitions per update [default: 128]
    #[arg(long, value_name = "N", help_heading = "Training")]
    batch_size: Option<usize>,
    /// Vector instructions of the updates [default: the widest this machine has]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Training")]
    isa: Option<IsaName>,

    /// Episodes of the evaluation on the system [default: 100]
    #[arg(long, value_name = "N", help_heading = "Evaluation")]
    episodes: Option<usize>,
}

/// Identifies equations in a log for the task in a file (the first path), as a configuration says.
pub(crate) type Identified<'a> = dyn Fn(&Path, &Path, &TrainConfig) -> Result<LogSource, Failure> + 'a;

impl Settings {
    /// The configuration of the run in `directory`, as it was.
    pub(super) fn of_run(
        directory: &Path,
        pipe: Option<&PipeSource>,
    ) -> Result<(TrainConfig, Arc<dyn Problem>), Failure> {
        let path = directory.join("config.toml");
        let (config, source) = recorded(&path, pipe)?;
        let (task, _) = source.task()?;
        let spec = task.spec();
        if config.task != spec.name {
            let (named, described) = (&config.task, &spec.name);
            let message = format!("{} is for `{named}`, the task beside it is `{described}`", path.display());
            return Err(Failure::new(message).hint("a run is resumed with the files it was started with"));
        }
        settled(config, &source)
    }

    /// The configuration these options ask for, for `task` or the task of `--task-file` or `--config`.
    pub(crate) fn config(
        &self,
        task: Option<&str>,
        pipe: Option<&PipeSource>,
        identified: &Identified<'_>,
    ) -> Result<(TrainConfig, Arc<dyn Problem>), Failure> {
        let source = match (&self.config, &self.task_file, task) {
            (Some(path), _, _) => {
                let (config, source) = recorded(path, pipe)?;
                if matches!(source, Source::Log(..)) && self.identification != IdentificationOptions::default() {
                    return Err(Failure::new(format!("the equations of {} were identified before", path.display()))
                        .hint("start with --task-file and --data to identify again"));
                }
                same_task(task, &config.task, path)?;
                let source = match source {
                    // Another build, or an earlier version, kept what this one cannot read: its log is there.
                    Source::Log(file, log) if !log.is_identified() => {
                        let found = identified(&file, log.path(), &config)?;
                        Source::Log(file, found)
                    }
                    source => source,
                };
                if let (Some(_), false) = (pipe, matches!(source, Source::Pipe(..))) {
                    return Err(Failure::new(format!("{} is for a system that is no program", path.display()))
                        .hint("leave --pipe out, or start with --task-file"));
                }
                (Some(config), source)
            }
            (None, Some(path), _) => (None, self.described(path, pipe, identified)?),
            (None, None, Some(_)) if pipe.is_some() => {
                return Err(Failure::new("--pipe needs a --task-file that declares states, controls and reward")
                    .hint("docs/pipe.md has an example"));
            }
            (None, None, Some(task)) => (None, Source::Named(task.to_owned())),
            (None, None, None) => return Err(Failure::new("neither a task nor --task-file nor --config was given")),
        };
        let (config, source) = source;
        let (declared, simulator) = source.task()?;
        let spec = declared.spec();
        let mut config = match config {
            Some(config) => config,
            None => {
                if let (Some(path), Source::File(_) | Source::Log(..) | Source::Pipe(..)) = (&self.task_file, &source) {
                    same_task(task, &spec.name, path)?;
                }
                let mut config = TrainConfig::defaults(&*declared);
                config.simulator = simulator;
                config.task_file = (!matches!(source, Source::Named(_))).then(|| RECORDED_TASK.into());
                if let Source::Log(..) = &source {
                    let problem = source.problem(simulator, 0.0)?;
                    if let Some((log, dt)) = problem.log().zip(problem.sampling_interval()) {
                        config.on_log(log, (dt, problem.delay(), problem.lag()), spec.precision);
                    }
                }
                config
            }
        };
        config = self.over(config)?;
        if self.refit == Some(true) && config.imagination.rollouts_per_real.0 == Rollouts::Unlimited {
            return Err(Failure::new("--refit has no effect without further real rollouts (--imagined-rollouts inf)")
                .hint("give --imagined-rollouts a number, or leave --refit out"));
        }
        if config.task != spec.name {
            return Err(Failure::new("`task` cannot be set; name the task itself"));
        }
        // Whatever file the task came from, the record of this run has one of its own.
        config.task_file = config.task_file.map(|_| RECORDED_TASK.into());
        // Whatever wrote the file, this version runs it.
        config.stamp();
        settled(config, &source)
    }

    /// `config` with these options over it.
    fn over(&self, mut config: TrainConfig) -> Result<TrainConfig, Failure> {
        self.apply(&mut config)?;
        for text in &self.overrides {
            config = config.with(text)?;
        }
        self.identification.check(&config.identification)?;
        self.settle_coordinates(&mut config);
        Ok(config)
    }

    /// Whether there is a log to identify.
    pub(crate) fn has_log(&self) -> bool {
        self.data.is_some()
    }

    /// What the task file at `path` is about: its own simulator, or the log or the program that was given.
    fn described(
        &self,
        path: &Path,
        pipe: Option<&PipeSource>,
        identified: &Identified<'_>,
    ) -> Result<Source, Failure> {
        let is_log = self.data.is_some() || self.model.is_some();
        match pipe {
            Some(pipe) if !is_log => return Ok(Source::Pipe(path.to_owned(), Some(pipe.clone()))),
            Some(_) => {
                return Err(Failure::new(
                    "the system is either a log or a program: --pipe excludes --data and --model",
                ));
            }
            None => {}
        }
        if is_log && (self.real_steps.is_some() || self.warmup_rollouts.is_some() || self.rollout_len.is_some()) {
            return Err(Failure::new("--real-steps and similar options do not apply to a log")
                .hint("leave them out, or use a log with fewer rows"));
        }
        let log = match (&self.data, &self.model) {
            (Some(log), _) => {
                // Settings do not depend on the control interval.
                let config = TrainConfig::defaults(&*declared(path, 1.0)?.task());
                identified(path, log, &self.over(config)?)?
            }
            (None, Some(directory)) => {
                if self.identification != IdentificationOptions::default() {
                    return Err(Failure::new(
                        "options of identification do not apply to --model, which is identified already",
                    )
                    .hint("leave them out, or identify again"));
                }
                LogSource::of_model(directory)?
            }
            (None, None) => return Ok(Source::File(path.to_owned())),
        };
        Ok(Source::Log(path.to_owned(), log))
    }

    /// The paper's terms are over what is observed: cos θ, sin θ and ω are three states there. Whoever asks for its
    /// library gets these, unless coordinates are asked for as well.
    fn settle_coordinates(&self, config: &mut TrainConfig) {
        let is = |given: &str, key: &str| given == key || key.split_once('.').is_some_and(|(_, name)| given == name);
        let overridden = |key: &str| self.overrides.iter().any(|text| is(self::key(text), key));
        let library = self.identification.library.is_some() || overridden("identification.library");
        let coordinates = self.coordinates.is_some() || overridden("identification.coordinates");
        if library && !coordinates && config.identification.library != LibraryName::Auto {
            config.identification.coordinates = CoordinatesName::Raw;
        }
    }

    fn apply(&self, config: &mut TrainConfig) -> Result<(), Failure> {
        set(&mut config.seed, &self.seed);
        set(&mut config.controller, &self.controller);
        set(&mut config.simulator, &self.simulator);
        set(&mut config.noise, &self.noise);
        set(&mut config.warmup.rollouts, &self.warmup_rollouts);
        set(&mut config.warmup.rollout_len, &self.rollout_len);
        set(&mut config.warmup.explorer, &self.explorer);
        if let Some(steps) = self.real_steps {
            let rollouts = config.warmup.rollouts.max(1);
            if !steps.is_multiple_of(rollouts) {
                return Err(Failure::new(format!("--real-steps {steps} cannot be shared by {rollouts} rollouts"))
                    .hint("give a multiple, or set --rollout-len"));
            }
            config.warmup.rollout_len = steps / rollouts;
        }
        self.identification.apply(&mut config.identification);
        set(&mut config.identification.coordinates, &self.coordinates);
        set(&mut config.imagination.rollouts_per_real, &self.imagined_rollouts);
        set(&mut config.imagination.refit, &self.refit);
        if self.max_real_steps.is_some() {
            config.imagination.max_real_steps = self.max_real_steps;
        }
        set(&mut config.optimality.max_updates, &self.max_updates);
        set(&mut config.sac.learning_rate, &self.learning_rate);
        set(&mut config.sac.discount, &self.discount);
        set(&mut config.sac.batch_size, &self.batch_size);
        if self.isa.is_some() {
            config.isa = self.isa;
        }
        set(&mut config.evaluation_episodes, &self.episodes);
        Ok(())
    }
}

/// What a run is made from, wherever its configuration came from: one that a run can have, and the problem with the noise it says.
fn settled(config: TrainConfig, source: &Source) -> Result<(TrainConfig, Arc<dyn Problem>), Failure> {
    config.check()?;
    let problem = source.problem(config.simulator, config.noise)?;
    Ok((config, problem))
}

/// The configuration in the file `path`, and what it is about.
fn recorded(path: &Path, pipe: Option<&PipeSource>) -> Result<(TrainConfig, Source), Failure> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read {}", path.display()))
        .map_err(|e| Failure::from(e).hint("a run directory holds a config.toml"))?;
    let config =
        TrainConfig::parse(&text).with_context(|| format!("{} is not a run's configuration", path.display()))?;
    let source = Source::of(&config, path.parent().unwrap_or(Path::new("")), pipe);
    Ok((config, source))
}

/// Refuses a file that is for another task than the one named.
fn same_task(named: Option<&str>, task: &str, path: &Path) -> Result<(), Failure> {
    match named.filter(|name| *name != task) {
        None => Ok(()),
        Some(name) => Err(Failure::new(format!("{} is for `{task}`, not for `{name}`", path.display()))),
    }
}
