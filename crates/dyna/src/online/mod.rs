//! Learning while acting on the system: model-free, or with a model that adds to the data.

mod algorithm;
mod branch;
mod run;
mod schedule;
mod turns;

pub use algorithm::{Check, Online, Practised};
pub use schedule::{Branches, Checks, OnlineSchedule};
pub use turns::{OnlineLoop, OnlinePhase};
