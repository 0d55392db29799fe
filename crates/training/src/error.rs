//! Why something could not be done.

use std::path::PathBuf;

use sindyna_control::ControlError;
use sindyna_core::{EnvError, FitError};
use sindyna_dyna::DynaError;
use sindyna_logs::LogError;
use sindyna_mujoco::MujocoError;
use sindyna_record::RecordError;
use sindyna_rl::{IsaError, SacError};
use sindyna_sindy::{EquationConstraintError, InvalidParam, LibraryError, SignalsError};

/// Why something could not be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A name that names nothing.
    #[error("no {what} named `{name}`; known: {}", known.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", "))]
    UnknownName {
        /// What was looked for.
        what: &'static str,
        /// The name.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// A setting that no run can have.
    #[error("{name} must be {wanted}, got {got}")]
    Setting {
        /// The setting as `config.toml` names it.
        name: &'static str,
        /// What it may be.
        wanted: String,
        /// What it is.
        got: String,
    },
    /// `KEY=VALUE` that changes no setting.
    #[error("{text}: {why}")]
    Override {
        /// The text.
        text: String,
        /// What is wrong with it.
        why: String,
    },
    /// A configuration that cannot be read or written.
    #[error("not a configuration: {why}")]
    Configuration {
        /// What is wrong with it.
        why: String,
    },
    /// The warm-up is too short for the candidate terms.
    #[error("{steps} real steps are too few: `{task}` needs at least {needed}")]
    TooFewSteps {
        /// Name of the task.
        task: String,
        /// Steps of the warm-up.
        steps: usize,
        /// Steps needed.
        needed: usize,
    },
    /// What is known of an equation has another form than it should.
    #[error("{option} takes `{form}`, got `{text}`")]
    ConstraintForm {
        /// The setting.
        option: &'static str,
        /// The form of its texts.
        form: &'static str,
        /// The text.
        text: String,
    },
    /// What is known of an equation contradicts the candidate terms.
    #[error("{option} `{text}`")]
    Constraint {
        /// The setting.
        option: &'static str,
        /// The text.
        text: String,
        /// Why it cannot be.
        source: Box<EquationConstraintError>,
    },
    /// A system of one's own that is not declared in full.
    #[error("the system `{name}` is not valid: {why}")]
    System {
        /// Its name.
        name: String,
        /// What is missing or contradicts itself.
        why: String,
    },
    /// A task that the simulator does not have.
    #[error("`{task}` has no model in {simulator}")]
    NoSimulator {
        /// The task.
        task: String,
        /// The simulator.
        simulator: &'static str,
    },
    /// A task file that describes no task.
    #[error("task file {}", path.display())]
    TaskFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// What was identified in a log cannot be read.
    #[error("{}: {why}", path.display())]
    NotIdentified {
        /// The file, or the directory.
        path: PathBuf,
        /// Why not.
        why: String,
    },
    /// A program that is no system as the task file declares it.
    #[error("the program `{command}`: {why}")]
    Pipe {
        /// The program and its arguments.
        command: String,
        /// What is wrong.
        why: String,
    },
    /// The system of a run was a program, and none is named.
    #[error("its system was a program, which is not started from a record")]
    NoPipe,
    /// The system of a run is no log, but a simulator or a program.
    #[error("the run is not one on a log, so its system is not replaced by equations")]
    NoLog,
    /// A model whose parts do not fit each other.
    #[error(transparent)]
    Model(#[from] sindyna_sindy::ModelError),
    /// A numeric setting of a solver out of its range.
    #[error(transparent)]
    Parameter(#[from] InvalidParam),
    /// Candidate terms that cannot be.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// Arrays declared as signals they cannot be.
    #[error(transparent)]
    Signals(#[from] SignalsError),
    /// A log that cannot be read.
    #[error(transparent)]
    Log(Box<LogError>),
    /// A record that cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// No equations were found.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Training ended without a result.
    #[error(transparent)]
    Train(#[from] DynaError),
    /// The system failed.
    #[error(transparent)]
    Environment(#[from] EnvError),
    /// An agent that cannot be.
    #[error(transparent)]
    Agent(#[from] SacError),
    /// A planner that cannot be.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// Instructions that the machine does not have.
    #[error(transparent)]
    Isa(#[from] IsaError),
    /// MuJoCo is not there or refuses a model.
    #[error(transparent)]
    Mujoco(#[from] MujocoError),
}

impl From<LogError> for Error {
    fn from(error: LogError) -> Self {
        Self::Log(Box::new(error))
    }
}

impl Error {
    /// The setting `name` must be `wanted`, not `got`.
    pub fn setting(name: &'static str, wanted: impl Into<String>, got: impl ToString) -> Self {
        Self::Setting { name, wanted: wanted.into(), got: got.to_string() }
    }
}
