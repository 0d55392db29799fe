//! Probabilistic ensembles: neural networks that predict how an observation moves, and how uncertain that is.
//!
//! [`EnsembleTrainer`] fits an [`Ensemble`] to rows of numbers; [`EnsembleLearner`] makes one of recorded rollouts and
//! wraps it as [`EnsembleModel`], a [`Dynamics`](sindyna_core::Dynamics) over the task's state: x → o → networks →
//! o' → x'. It is the model of MBPO. [`EnsembleConfig::janner`] and [`EnsembleConfig::paper`] are its known settings.
//!
//! Not here: when to refit, how long to imagine, what to mix into replay (the loop's `Schedule`); reward and termination,
//! which are the task's.
//!
//! # References
//! Chua et al. (2018), arXiv:1805.12114 (PETS). Janner et al. (2019), arXiv:1906.08253 (MBPO).

mod activation;
mod config;
mod coordinates;
mod likelihood;
mod model;
mod networks;
mod pass;
mod rows;
mod run;
mod standard;
mod step;
mod stopping;
#[cfg(test)]
mod tests;
mod trainer;

pub use activation::Activation;
pub use config::{EnsembleConfig, EnsembleError, RewardHead, TargetScale};
pub use model::{EnsembleLearner, EnsembleModel};
pub use networks::{Ensemble, Prediction};
pub use stopping::FitReport;
pub use trainer::EnsembleTrainer;
