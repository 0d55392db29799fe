//! Algorithm 1 of Arora, da Silva and Moss (2022): collect a little real data, identify, improve a policy inside the
//! identified model, and check it on the system.
//!
//! This crate depends on [`sindyna_core`] and nothing else of ours, so the loop cannot know whether its model is a
//! handful of equations, a neural ensemble, or none.
//!
//! Not here: names, files, clocks, terminals; what a model or an agent is made of.

mod algorithm;
mod base;
mod belief;
mod collect;
mod curious;
mod cycle;
mod error;
mod evaluate;
mod explore;
mod gap;
mod imagine;
mod lockstep;
#[cfg(test)]
mod one_state;
mod online;
mod optimality;
mod predict;
mod real;
mod run;
mod schedule;
mod surprise;
mod tried;
mod trust;

pub use algorithm::{Dyna, Learned};
pub use cycle::{Loop, Phase};
pub use error::DynaError;
pub use evaluate::evaluate;
pub use explore::{Alternating, Gentle, Swings, Uniform};
pub use gap::Gap;
pub use online::{Branches, Check, Checks, Online, OnlineLoop, OnlinePhase, OnlineSchedule, Practised};
pub use optimality::Optimality;
pub use predict::Prediction;
pub use real::Confirmation;
pub use schedule::{Refit, Rollouts, Schedule, ScheduleError};
pub use trust::Trust;
