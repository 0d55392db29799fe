//! Planners: policies that look for the best controls in a model, step by step.

mod agent;
mod course;
mod expected;
mod filter;
mod front;
mod goal;
mod guess;
mod ilqr;
mod improvable;
mod mppi;
mod objective;
mod plant;
mod policy;
mod rest;
mod search;
mod slopes;
mod small;

pub use agent::Planners;
pub use improvable::{Rollout, improved};
pub use policy::{Method, Planner};
