//! Systems with a task, settings, and training of controllers in identified equations.
//!
//! - [`problem`]: what a controller can be trained for, by name, from a task file, from a log, behind a pipe, or your own;
//! - [`settings`]: the settings of `config.toml`;
//! - [`Training`]: from a few steps on the system to equations, a controller and its evaluation. The command puts a run together from the same
//!   parts ([`Plan`], [`watched_evaluation`], [`summary`]) and keeps a record of it.

mod error;
mod evaluation;
mod improvable;
mod in_model;
mod known;
mod learner;
mod plan;
mod planned;
mod predicting;
pub mod problem;
mod reach;
mod rollout;
pub mod settings;
mod shown;
mod summary;
mod task_file;
mod training;

pub use error::Error;
pub use evaluation::{episode, evaluation, predictions, timed, watched_evaluation};
pub use in_model::{InModel, in_model};
pub use known::{identified_bytes, identified_of};
pub use learner::{Fitted, Learner};
pub use plan::{Plan, agent_of};
pub use planned::{Timed, planner};
pub use predicting::Predicting;
pub use summary::of as summary;
pub use task_file::RECORDED_TASK;
pub use training::{Trained, Training, Verdict};

/// The commit this is built from; `unknown` outside a repository.
pub const COMMIT: &str = env!("SINDYNA_COMMIT");
