//! Where problems come from: by name, or from a task file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sindyna_core::Task;
use sindyna_envs::System;
use sindyna_sindy::Expr;

use super::Problem;
use super::log_source::LogSource;
use super::mujoco::OnMujoco;
use super::native::Native;
use super::own::OwnSystem;
use super::pipe::{PipeSource, Piped};
use super::recorded::{self, Recorded};
use crate::Error;
use crate::settings::{SimulatorName, TrainConfig};
use crate::task_file::TaskFile;

/// Names of the problems that come along.
#[must_use]
pub fn names() -> Vec<&'static str> {
    sindyna_envs::systems().iter().map(System::name).collect()
}

/// The problem that comes along under `name`, such as `pendulum` or `Pendulum-v1`.
///
/// # Errors
/// [`Error::UnknownName`] with those there are.
pub fn named(name: &str) -> Result<Arc<dyn Problem>, Error> {
    system(name).map(Native::shared)
}

/// The problem that the task file at `path` describes, on its own simulator (a MuJoCo model or equations).
///
/// # Errors
/// [`Error::TaskFile`] if it describes none, or has no simulator.
pub fn of_file(path: &Path) -> Result<Arc<dyn Problem>, Error> {
    Ok(Arc::new(TaskFile::with_simulator(path)?))
}

/// The problem that the task file at `path` describes, on what `sindyna identify` left in `directory`: a log, and equations found in it.
///
/// # Errors
/// [`Error::TaskFile`] if it describes none, [`Error::NotIdentified`] if nothing was left there.
pub fn of_model(path: &Path, directory: &Path) -> Result<Arc<dyn Problem>, Error> {
    on_log(path, &LogSource::of_model(directory)?)
}

/// The problem that the task file at `path` describes, on a log with the equations found in it.
///
/// # Errors
/// [`Error::TaskFile`] if it describes none, [`Error::System`] if it is one of another system.
pub fn on_log(path: &Path, source: &LogSource) -> Result<Arc<dyn Problem>, Error> {
    Ok(Arc::new(Recorded::load(path, source)?))
}

/// The system that comes along under `name`.
pub fn system(name: &str) -> Result<System, Error> {
    sindyna_envs::find(name).ok_or_else(|| Error::UnknownName {
        what: "task",
        name: name.to_owned(),
        known: names().into_iter().map(String::from).collect(),
    })
}

/// Where a problem comes from.
#[derive(Debug, Clone)]
pub enum Source {
    /// It comes along under this name.
    Named(String),
    /// A task file describes it.
    File(PathBuf),
    /// A task file describes the task on it, and there is a log of it in which equations were found.
    Log(PathBuf, LogSource),
    /// A task file describes the task on it, and a program is it; which one no record tells.
    Pipe(PathBuf, Option<PipeSource>),
}

impl Source {
    /// The source of the run with these settings, whose record lies in `directory`; `pipe` is the program that is its system, if it is one.
    pub fn of(config: &TrainConfig, directory: &Path, pipe: Option<&PipeSource>) -> Self {
        match (&config.task_file, &config.data) {
            (Some(file), None) if config.simulator == SimulatorName::Pipe => {
                Self::Pipe(directory.join(file), pipe.cloned())
            }
            (Some(file), Some(data)) => Self::Log(directory.join(file), LogSource::of_record(data, directory)),
            (Some(file), None) => Self::File(directory.join(file)),
            (None, _) => Self::Named(config.task.clone()),
        }
    }

    /// The task, and on which simulator its system lives if nothing else is said.
    pub fn task(&self) -> Result<(Arc<dyn Task>, SimulatorName), Error> {
        Ok(match self {
            Self::Named(name) => (system(name)?.task(), SimulatorName::Native),
            Self::File(path) => {
                let file = TaskFile::with_simulator(path)?;
                (file.task(), simulator_of(&file))
            }
            Self::Log(path, source) => (recorded::of(path, source, source.dt())?.task(), SimulatorName::None),
            Self::Pipe(path, _) => (TaskFile::without_simulator(path)?.task(), SimulatorName::Pipe),
        })
    }

    /// Observed values of the task that are formulas of its states, by the names of their channels.
    pub fn formulas(&self) -> Result<Vec<(String, Expr)>, Error> {
        match self {
            Self::Named(_) => Ok(Vec::new()),
            // No formula of states holds the control interval.
            Self::File(path) | Self::Log(path, _) | Self::Pipe(path, _) => {
                Ok(TaskFile::load(path, Some(1.0))?.formulas().to_vec())
            }
        }
    }

    /// The problem on `simulator`, with Gaussian noise on the sensors of its system: `noise` is a fraction of every
    /// observation channel's scale. It is declared, so the learner may know of it; reward and termination know nothing of it.
    pub fn problem(&self, simulator: SimulatorName, noise: f64) -> Result<Arc<dyn Problem>, Error> {
        if !(0.0..=1.0).contains(&noise) {
            return Err(Error::setting("noise", "between 0 and 1", noise));
        }
        match (self, simulator) {
            (Self::Named(name), SimulatorName::Native) => Ok(Native::shared(system(name)?.with_noise(noise))),
            (Self::Named(name), SimulatorName::Mujoco) => {
                Ok(Arc::new(OnMujoco::new(Native::new(system(name)?.with_noise(noise)))?))
            }
            (Self::Log(path, source), SimulatorName::None) => Ok(Arc::new(Recorded::load(path, source)?)),
            (Self::Pipe(path, Some(source)), SimulatorName::Pipe) => Ok(Arc::new(Piped::open(path, source, noise)?)),
            (Self::Pipe(_, None), SimulatorName::Pipe) => Err(Error::NoPipe),
            (Self::Named(_) | Self::Log(..) | Self::Pipe(..), other) => {
                let wanted = match self {
                    Self::Log(..) => "`none` for a log",
                    Self::Pipe(..) => "`pipe` for a program",
                    _ => "`native` or `mujoco`",
                };
                Err(Error::setting("simulator", wanted, format!("`{other}`")))
            }
            (Self::File(path), simulator) => {
                let file = TaskFile::with_simulator(path)?;
                let own = simulator_of(&file);
                if own != simulator {
                    let wanted = format!("`{own}` for {}", path.display());
                    return Err(Error::setting("simulator", wanted, format!("`{simulator}`")));
                }
                Ok(Arc::new(file.with_noise(noise)))
            }
        }
    }
}

/// The problem of a run on a log, `source`, on the equations that `sindyna identify` found in other logs of the same system and left in `directory`; `noise` as in [`Source::problem`].
///
/// # Errors
/// [`Error::NoLog`] if the run is not one on a log, and as [`of_model`].
pub fn on_twin(source: &Source, directory: &Path, noise: f64) -> Result<Arc<dyn Problem>, Error> {
    let Source::Log(path, own) = source else { return Err(Error::NoLog) };
    let (task, plant) = recorded::on_twin(path, &LogSource::of_model(directory)?, own)?;
    let task = task.with_noise(noise);
    let twin = OwnSystem::driven(task.task(), task.sensors(), move || plant.clone());
    Ok(Arc::new(match task.protocol().solved_at {
        Some(mean_return) => twin.solved_at(mean_return),
        None => twin,
    }))
}

/// Where the system of a task file lives.
fn simulator_of(file: &TaskFile) -> SimulatorName {
    if file.is_mujoco() { SimulatorName::Mujoco } else { SimulatorName::Native }
}
