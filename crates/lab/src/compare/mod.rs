//! Methods side by side: who needs how many real steps.

mod chart;
mod curve;
mod method;
mod outcome;
mod page;
mod presets;
mod run;
mod store;
mod table;

pub(crate) use method::Method;
pub(crate) use outcome::Outcome;
pub(crate) use page::page;
pub(crate) use run::Job;
pub(crate) use store::Store;
pub(crate) use table::{Group, groups, markdown};
