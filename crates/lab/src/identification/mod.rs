//! Equations from data: settings, and the account a user reads.

mod account;
mod config;
mod equation;
mod model;
mod stepping;

pub(crate) use account::{Account, Offset};
pub(crate) use config::IdentificationConfig;
pub(crate) use equation::Summand;
pub(crate) use model::read_model;
pub(crate) use stepping::Stepping;
