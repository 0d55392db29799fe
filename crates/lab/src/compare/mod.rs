//! Methods side by side: who needs how many real steps.

mod method;
mod outcome;
mod presets;
mod run;
mod store;
mod table;

pub(crate) use method::Method;
pub(crate) use outcome::Outcome;
pub(crate) use run::Job;
pub(crate) use store::Store;
pub(crate) use table::{Group, groups, markdown};
