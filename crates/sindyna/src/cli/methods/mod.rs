//! Methods side by side: who needs how many real steps.

mod catalog;
mod method;
mod pace;
mod paper;
mod presets;
mod run;
mod store;
mod variant;

pub(crate) use catalog::Known;
pub(crate) use method::Method;
pub(crate) use pace::Pace;
pub(crate) use presets::first_check;
pub(crate) use run::Job;
pub(crate) use store::Store;
pub(crate) use variant::{Contender, Variant};
