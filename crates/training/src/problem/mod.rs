//! Systems with a task on them: what a controller can be trained for.
//!
//! [`named`] gives those that come along, [`OwnSystem`] one's own. All of them are a [`Problem`].

mod actuators;
mod condition;
mod formula_task;
mod late;
mod log_source;
mod mujoco;
mod native;
mod own;
mod pipe;
mod recorded;
mod replay;
mod source;
mod starts;
mod task_builder;
mod traits;
mod turning;

pub use crate::settings::{RECORDED_LOG, RECORDED_MODELS};
pub use formula_task::{FormulaTask, Names};
pub use late::Late;
pub use log_source::LogSource;
pub use own::{OwnSystem, Plant, PlantError, ode, stepped};
pub use pipe::PipeSource;
pub use recorded::{declared, read_logs};
pub use replay::{Played, Replayed};
pub use source::{Source, of_file, of_model, on_log, on_twin, system};
pub use source::{named, names};
pub use starts::Start;
pub use task_builder::{OwnTask, TaskBuilder};
pub use traits::Problem;
