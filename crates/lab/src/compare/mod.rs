//! Methods side by side: who needs how many real steps.

mod asked;
mod method;
mod outcome;
mod pace;
mod presets;
mod run;
mod store;

pub(crate) use asked::Asked;
pub(crate) use method::{Method, is_anchor, learns_on_the_real_system};
pub(crate) use outcome::{Outcome, mean};
pub(crate) use pace::Pace;
pub(crate) use presets::first_check;
pub(crate) use run::Job;
pub(crate) use store::{Store, read_asked, read_seconds};
