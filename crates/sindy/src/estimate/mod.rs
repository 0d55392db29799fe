//! Equations of motion from noisy data: structure, coefficients and noise together.
//!
//! A hypothesis is a set of terms for each equation and a way of stepping. Linear regressions along a path propose; the prediction
//! error of whole trajectories, with one penalty for every term, decides.

mod constancy;
mod hypothesis;
mod propose;
mod search;
mod white;

pub use search::Doubt;
pub(crate) use search::{Estimate, Problem, estimate, finish};
