//! Equations of motion from noisy data: structure, coefficients and noise together.
//!
//! A hypothesis is a set of terms for each equation and a way of stepping. Linear regressions along a path propose; the prediction
//! error of whole trajectories, with one penalty for every term, decides.

mod account;
mod alone;
mod between;
mod constancy;
mod constraints;
mod exchange;
mod hypothesis;
mod implicit;
mod inputs;
mod inside;
mod instead;
mod jointly;
mod measured;
mod mechanics;
mod mirror;
mod near;
mod positions;
mod posterior;
mod problem;
mod propose;
mod prune;
mod quotients;
mod regression;
mod rounds;
mod scheme;
mod search;
mod searched;
mod series;
mod simpler;
mod simplest;
mod size;
mod still;
mod strays;
mod substitution;
mod tied;
mod white;

pub use account::Doubt;
pub(crate) use account::Estimate;
pub(crate) use constraints::Constraints;
pub(crate) use hypothesis::budget;
pub(crate) use posterior::Posterior;
pub(crate) use problem::{OfPart, Problem, Structure};
pub(crate) use search::{completed, estimate};
pub(crate) use still::still;
pub(crate) use tied::{Judged, judged, leaves_noise};
