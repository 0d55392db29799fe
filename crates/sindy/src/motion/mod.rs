//! Equations of motion, identified together with the way they are stepped.
//!
//! States that are declared to be rates are believed: ẋ = v is not fitted, but asked how the system steps it. Then each
//! remaining equation is a best-subset regression on whitened rows; where the steps are those of a continuous system,
//! the terms are averaged along the path that the equations found so far take between two samples, again and again until
//! they agree. At last the coefficients are fitted to whole trajectories.

mod averages;
mod choice;
mod fitting;
mod found;
mod mechanics;
mod polish;
mod runs;
mod search;
mod settling;
mod stepping;
mod strays;
mod tilt;
mod unseen;
mod untangle;

pub(crate) use averages::System;
pub(crate) use found::{Found, Search};
pub(crate) use mechanics::Mechanical;
pub(crate) use polish::polished;
pub(crate) use runs::{Run, at_limit, runs, written};
pub(crate) use stepping::{MOST_SEMI_IMPLICIT, Stepping, shown, simulators};
