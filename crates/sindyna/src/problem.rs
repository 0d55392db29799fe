//! What is to be learned: one of our systems, or one that a task file describes.

use std::path::Path;
use std::sync::Arc;

use sindyna_core::{Sensors, Spec, Task};
use sindyna_envs::System;

use crate::config::TrainConfig;
use crate::failure::Failure;
use crate::registry;
use crate::task_file::TaskFile;

/// A system to be learned, with the task on it.
#[derive(Clone)]
pub(crate) enum Problem {
    /// In the registry.
    Ours(System),
    /// In a task file.
    File(Box<TaskFile>),
}

impl Problem {
    /// The registered problem called `name`.
    pub(crate) fn named(name: &str) -> Result<Self, Failure> {
        registry::system(name).map(Self::Ours)
    }

    /// The problem that the task file at `path` describes.
    pub(crate) fn from_file(path: &Path) -> Result<Self, Failure> {
        TaskFile::load(path).map(|file| Self::File(Box::new(file)))
    }

    /// The problem of a run, whose record lies in `directory`.
    pub(crate) fn of(config: &TrainConfig, directory: &Path) -> Result<Self, Failure> {
        match &config.task_file {
            Some(file) => Self::from_file(&directory.join(file)),
            None => Self::named(&config.task),
        }
    }

    /// The same problem with Gaussian noise on the sensors of its system: `fraction` of every observation channel's
    /// scale. It is declared, so the learner may know of it; reward and termination know nothing of it.
    pub(crate) fn with_noise(self, fraction: f64) -> Result<Self, Failure> {
        if !(0.0..=1.0).contains(&fraction) {
            return Err(Failure::new(format!("--noise must be between 0 and 1, got {fraction}"))
                .hint("it is a fraction of every observation's scale: 0.01 is one per cent"));
        }
        Ok(match self {
            Self::Ours(system) => Self::Ours(system.with_noise(fraction)),
            Self::File(file) => Self::File(Box::new(file.with_noise(fraction))),
        })
    }

    /// Name of the task.
    pub(crate) fn name(&self) -> &str {
        &self.spec().name
    }

    /// What is declared about the system.
    pub(crate) fn spec(&self) -> &Spec {
        match self {
            Self::Ours(system) => system.spec(),
            Self::File(file) => file.spec(),
        }
    }

    /// The task: all the agent may know.
    pub(crate) fn task(&self) -> Arc<dyn Task> {
        match self {
            Self::Ours(system) => system.task(),
            Self::File(file) => file.task(),
        }
    }

    /// The sensors the spec declares.
    pub(crate) fn sensors(&self) -> Sensors {
        match self {
            Self::Ours(system) => system.sensors(),
            Self::File(file) => file.sensors(),
        }
    }

    /// The equations of motion, where they are known.
    pub(crate) fn true_equations(&self) -> &'static [&'static str] {
        match self {
            Self::Ours(system) => system.true_equations(),
            Self::File(_) => &[],
        }
    }

    /// The files of a run's record that hold what the registry does not.
    pub(crate) fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Failure> {
        match self {
            Self::Ours(_) => Ok(Vec::new()),
            Self::File(file) => file.files(),
        }
    }
}
