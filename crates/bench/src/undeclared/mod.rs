//! Identification from data whose noise nobody declares.
//!
//! Two sets of systems: *development* ones, on which methods may be tuned, and *reported* ones, on which they never are. A run is
//! one [`generate`]d log, given to [`crate::method`], and a [`Verdict`] over the equations that come back.

mod development;
mod export;
mod generate;
mod inputs;
mod judge;
mod reported;
mod run;
mod system;

pub use export::export;
pub use generate::generate;
pub use judge::{Judge, Judged, Verdict};
pub use run::{Case, Run};
pub use system::System;

/// Which systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Set {
    /// Results are reported on these.
    Reported,
    /// So are they on these, whose terms have parameters inside.
    Functions,
    /// And on these, whose states are far from zero.
    Absolute,
    /// Methods are developed on these.
    Development,
}

/// The systems of `set`.
#[must_use]
pub fn systems(set: Set) -> Vec<System> {
    match set {
        Set::Reported => reported::systems(),
        Set::Functions => reported::functions(),
        Set::Absolute => reported::absolute(),
        Set::Development => development::systems(),
    }
}

/// The system called `name`, of whatever set.
#[must_use]
pub fn find(name: &str) -> Option<System> {
    [Set::Reported, Set::Functions, Set::Absolute, Set::Development]
        .into_iter()
        .flat_map(systems)
        .find(|s| s.name() == name)
}
