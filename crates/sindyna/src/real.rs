//! The real system of a run: ours, or one in a simulator found at run time.

use sindyna_core::Environment;
use sindyna_envs::System;
use sindyna_mujoco::{Library, Search, inverted_pendulum_of};

use crate::failure::Failure;
use crate::problem::Problem;
use crate::registry::unknown;
use crate::task_file::TaskFile;

/// Names a simulator can have.
pub(crate) const SIMULATORS: [&str; 2] = ["native", "mujoco"];

/// Where the real system lives.
#[derive(Clone)]
pub(crate) enum Real {
    /// In this program.
    Native(System),
    /// In MuJoCo; only the inverted pendulum has a model there.
    Mujoco(Library, System),
    /// In MuJoCo, with the model of a task file.
    TaskFile(Box<TaskFile>),
}

impl Real {
    /// The real system behind `problem` in the simulator called `simulator`.
    pub(crate) fn new(problem: &Problem, simulator: &str) -> Result<Self, Failure> {
        let system = match (problem, simulator) {
            (Problem::Ours(system), _) => system,
            (Problem::File(file), "mujoco") => return Ok(Self::TaskFile(file.clone())),
            (Problem::File(_), _) => {
                return Err(Failure::new(format!("a task file is for `mujoco`, not for simulator `{simulator}`")));
            }
        };
        match simulator {
            "native" => Ok(Self::Native(system.clone())),
            "mujoco" if system.name() == "inverted-pendulum" => {
                Ok(Self::Mujoco(Library::load(&Search::from_environment())?, system.clone()))
            }
            "mujoco" => Err(Failure::new(format!("`{}` has no model in MuJoCo", system.name()))
                .hint("`inverted-pendulum` has; leave --simulator out for the others")),
            _ => Err(unknown("simulator", simulator, &SIMULATORS)),
        }
    }

    /// One such system; the first call must be a reset.
    pub(crate) fn environment(&self) -> Result<Box<dyn Environment>, Failure> {
        Ok(match self {
            Self::Native(system) => Box::new(system.environment()),
            Self::Mujoco(library, system) => Box::new(inverted_pendulum_of(library, system)?),
            Self::TaskFile(file) => file.environment()?,
        })
    }

    /// Refuses to go on after a reward that was no finite number.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        match self {
            Self::Native(_) | Self::Mujoco(..) => Ok(()),
            Self::TaskFile(file) => file.check(),
        }
    }
}
