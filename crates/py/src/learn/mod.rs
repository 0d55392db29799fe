//! Controllers: systems that Python steps, tasks that it gives, policies and learned models handed back.

mod batch;
mod data;
mod outside;
mod policy;
mod problem;
mod system;
mod task;
mod task_file;
mod training;

pub(crate) use batch::{Batch, builtin, learned, learned_builtin, written};
pub(crate) use data::Data;
pub(crate) use policy::Policy;
pub(crate) use system::states;
pub(crate) use task_file::{learned_file, train_file};
pub(crate) use training::{Outcome, collect, paid, train};
