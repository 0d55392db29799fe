//! Who turns recorded rollouts into dynamics.

use std::convert::Infallible;

use crate::{Dataset, Diverged, Dynamics, Rng};

/// Why no model could be made from the data.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// Too few rows to say anything.
    #[error("{got} usable rows are too few to identify {unknowns}; at least {needed} are needed")]
    TooFewRows {
        /// Usable rows.
        got: usize,
        /// Rows wanted.
        needed: usize,
        /// What was to be identified.
        unknowns: String,
    },
    /// The data do not have the shape the learner was made for.
    #[error("{what}: expected {expected}, got {got}")]
    Shape {
        /// What was counted.
        what: &'static str,
        /// Number wanted.
        expected: usize,
        /// Number found.
        got: usize,
    },
    /// The regression itself failed.
    #[error("{reason}")]
    Regression {
        /// What the solver said.
        reason: String,
    },
    /// It was told to stop.
    #[error("interrupted before the equations were found")]
    Interrupted,
}

/// Learns dynamics over the task's state x from rollouts of observations.
pub trait DynamicsLearner: Send + Sync {
    /// What is learned: a [`Dynamics`] over the task's state.
    type Model: Dynamics;

    /// Fits a model to `data`; `None` for learners that have none. `previous` is the model before the new data came.
    ///
    /// # Errors
    /// [`FitError`] when the data cannot support a model.
    fn fit(
        &self,
        data: &Dataset,
        previous: Option<&Self::Model>,
        rng: &mut Rng,
    ) -> Result<Option<Self::Model>, FitError>;

    /// Steps of `data` that went into `model`; all of them unless the learner leaves some out.
    fn rows(&self, _model: &Self::Model, data: &Dataset) -> usize {
        data.n_steps()
    }

    /// The model in lines a person reads; nothing for models nobody can read.
    fn describe(&self, _model: &Self::Model) -> Vec<String> {
        Vec::new()
    }
}

/// No model at all: learning from real data only.
#[derive(Debug, Clone, Copy)]
pub struct NoModel;

impl Dynamics for Infallible {
    fn step(&self, _x: &[f64], _u: &[f64], _rng: &mut Rng, _next: &mut [f64]) -> Result<(), Diverged> {
        match *self {}
    }
}

impl DynamicsLearner for NoModel {
    type Model = Infallible;

    fn fit(
        &self,
        _data: &Dataset,
        _previous: Option<&Infallible>,
        _rng: &mut Rng,
    ) -> Result<Option<Infallible>, FitError> {
        Ok(None)
    }
}
