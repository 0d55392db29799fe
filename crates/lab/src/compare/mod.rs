//! Methods side by side: who needs how many real steps.

mod method;
mod outcome;
mod presets;
mod run;
mod store;

pub(crate) use method::{Method, is_anchor};
pub(crate) use outcome::{Outcome, mean};
pub(crate) use run::Job;
pub(crate) use store::Store;
