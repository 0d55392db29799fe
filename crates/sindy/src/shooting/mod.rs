//! Coefficients by the prediction error of whole trajectories: multiple shooting with continuity.

mod eliminate;
mod fit;
mod flow;
mod tableau;

pub(crate) use fit::{Bounds, Fit, PARTS, fit, opinion};
pub(crate) use flow::{Flow, Scratch, Stage};
