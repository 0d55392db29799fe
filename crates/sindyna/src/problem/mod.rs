//! Systems with a task on them: what a controller can be trained for.
//!
//! [`named`] gives those that come along, a task file those of MuJoCo, [`OwnSystem`] one's own. All of them are a
//! [`Problem`].

mod mujoco;
mod native;
mod own;
mod task_builder;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sindyna_core::{Environment, Sensors, Spec, Task};
use sindyna_envs::System;

use crate::Error;
use crate::settings::{SimulatorName, TrainConfig};
use crate::task_file::TaskFile;
use mujoco::OnMujoco;
use native::Native;
pub use own::{OwnSystem, Plant, PlantError, ode};
pub use task_builder::{OwnTask, TaskBuilder};

/// A system with a task on it.
pub trait Problem: Send + Sync {
    /// Names, units and bounds of the channels, control interval, horizon.
    fn spec(&self) -> &Spec;

    /// Start states, reward and termination: all the agent may know.
    fn task(&self) -> Arc<dyn Task>;

    /// The sensors that [`Self::spec`] declares.
    fn sensors(&self) -> Sensors;

    /// One such system; the first call must be a reset.
    ///
    /// # Errors
    /// [`Error`] if the system cannot be had.
    fn environment(&self) -> Result<Box<dyn Environment>, Error>;

    /// How many of it there can be at a time: 1 for hardware.
    fn copies(&self) -> usize {
        usize::MAX
    }

    /// The equations of motion, where they are known.
    fn true_equations(&self) -> Vec<String> {
        Vec::new()
    }

    /// Refuses to go on where the task left the finite numbers.
    ///
    /// # Errors
    /// [`Error::Reward`] with the first such reward.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Files that a record of a run needs to run it again: name and contents.
    ///
    /// # Errors
    /// [`Error`] if they cannot be made.
    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        Ok(Vec::new())
    }
}

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

/// The system that comes along under `name`.
pub(crate) fn system(name: &str) -> Result<System, Error> {
    sindyna_envs::find(name).ok_or_else(|| Error::UnknownName {
        what: "task",
        name: name.to_owned(),
        known: names().into_iter().map(String::from).collect(),
    })
}

/// Where a problem comes from.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    /// It comes along under this name.
    Named(String),
    /// A task file describes it.
    File(PathBuf),
}

impl Source {
    /// The source of the run with these settings, whose record lies in `directory`.
    pub(crate) fn of(config: &TrainConfig, directory: &Path) -> Self {
        match &config.task_file {
            Some(file) => Self::File(directory.join(file)),
            None => Self::Named(config.task.clone()),
        }
    }

    /// What is declared about it, and on which simulator it lives if nothing else is said.
    pub(crate) fn spec(&self) -> Result<(Spec, SimulatorName), Error> {
        Ok(match self {
            Self::Named(name) => (system(name)?.spec().clone(), SimulatorName::Native),
            Self::File(path) => (TaskFile::load(path)?.spec().clone(), SimulatorName::Mujoco),
        })
    }

    /// The problem on `simulator`, with Gaussian noise on the sensors of its system: `noise` is a fraction of every
    /// observation channel's scale. It is declared, so the learner may know of it; reward and termination know nothing of it.
    pub(crate) fn problem(&self, simulator: SimulatorName, noise: f64) -> Result<Arc<dyn Problem>, Error> {
        if !(0.0..=1.0).contains(&noise) {
            return Err(Error::setting("noise", "between 0 and 1", noise));
        }
        match (self, simulator) {
            (Self::Named(name), SimulatorName::Native) => Ok(Native::shared(system(name)?.with_noise(noise))),
            (Self::Named(name), SimulatorName::Mujoco) => {
                Ok(Arc::new(OnMujoco::new(Native::new(system(name)?.with_noise(noise)))?))
            }
            (Self::File(path), SimulatorName::Mujoco) => Ok(Arc::new(TaskFile::load(path)?.with_noise(noise))),
            (Self::File(_), other) => {
                Err(Error::setting("simulator", "`mujoco` for a task file", format!("`{other}`")))
            }
        }
    }
}
