//! Systems with a task on them: what a controller can be trained for.
//!
//! [`named`] gives those that come along, [`OwnSystem`] one's own. All of them are a [`Problem`].

mod mujoco;
mod native;
mod own;
mod recorded;
mod source;
mod task_builder;
mod traits;

pub use own::{OwnSystem, Plant, PlantError, ode, stepped};
pub(crate) use recorded::{LogSource, RECORDED_LOG, RECORDED_MODELS, Replayed, Sampling};
pub(crate) use source::{Source, system};
pub use source::{named, names};
pub use task_builder::{OwnTask, TaskBuilder};
pub use traits::Problem;
