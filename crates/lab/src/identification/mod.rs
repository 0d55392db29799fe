//! Equations from data: settings, and the account a user reads.

mod account;
mod config;
mod standard_errors;

pub(crate) use account::Account;
pub(crate) use config::IdentificationConfig;
