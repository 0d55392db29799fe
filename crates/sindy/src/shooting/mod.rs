//! Coefficients by the prediction error of whole trajectories: multiple shooting with continuity.

mod checks;
mod eliminate;
mod expansion;
mod fit;
mod flow;
mod inputs;
mod lanes;
mod passes;
mod scratch;
mod slack;
mod state;
mod step;
mod switches;
mod tableau;
mod turn;
mod work;

pub(crate) use checks::{Contribution, Place};
pub(crate) use fit::{Fit, fit, innovations, linearised};
pub(crate) use flow::{Flow, Given, Stage};
pub(crate) use inputs::{Told, inputs, is_held};
pub(crate) use passes::Samples;
pub(crate) use scratch::Scratch;
pub(crate) use slack::PARTS;
pub(crate) use state::Bounds;
pub(crate) use step::Inputs;
pub(crate) use work::Work;
