//! Who turns recorded rollouts into dynamics.

use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;

use crate::{CheckpointError, Dataset, Diverged, Dynamics, Rng};

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

/// Models that explain the data about as well as the likeliest one, in proportion to their probability.
pub trait Posterior: Send + Sync {
    /// Draws one.
    fn draw(&self, rng: &mut Rng) -> Arc<dyn Dynamics>;
}

/// How well a model explains the data it was fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Certainty {
    /// Something speaks against it, or nothing is known of its errors.
    Doubted,
    /// It leaves nothing but noise, and other models do or may do too.
    Ambiguous,
    /// It leaves nothing but noise, and no other model is as good.
    Adequate,
    /// It leaves nothing but rounding: more data of the same kind would not change it.
    Exact,
}

/// What a learner knows of a system after a fit.
#[derive(Clone)]
pub struct Knowledge<M> {
    /// The likeliest model.
    pub model: Arc<M>,
    /// How well it explains the data.
    pub certainty: Certainty,
    /// The models that the data allow; none if there is only one, or if the learner does not say.
    pub posterior: Option<Arc<dyn Posterior>>,
    /// Standard deviation of the sensors' noise, one per observation channel and in its unit, as estimated from the data; none if the
    /// learner does not estimate it.
    pub sensor_noise: Option<Vec<f64>>,
}

impl<M: fmt::Debug> fmt::Debug for Knowledge<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, certainty, posterior, sensor_noise } = self;
        let mut shown = f.debug_struct("Knowledge");
        shown.field("model", model).field("certainty", certainty).field("posterior", &posterior.is_some());
        shown.field("sensor_noise", sensor_noise).finish()
    }
}

impl<M> Knowledge<M> {
    /// A model that is believed as it is: the equations of the system itself, say.
    pub fn certain(model: M) -> Self {
        Self { model: Arc::new(model), certainty: Certainty::Exact, posterior: None, sensor_noise: None }
    }

    /// A model that is no more than an approximation, with nothing known of its errors.
    pub fn approximate(model: M) -> Self {
        Self { certainty: Certainty::Doubted, ..Self::certain(model) }
    }
}

/// Learns dynamics over the task's state x from rollouts of observations.
pub trait DynamicsLearner: Send + Sync {
    /// What is learned: a [`Dynamics`] over the task's state.
    type Model: Dynamics + 'static;

    /// Whether a fit goes on from the model before, and depends on it.
    fn goes_on(&self) -> bool {
        false
    }

    /// Fits a model to `data`; `None` for learners that have none. `previous` is the model before the new data came.
    ///
    /// # Errors
    /// [`FitError`] when the data cannot support a model.
    fn fit(
        &self,
        data: &Dataset,
        previous: Option<&Self::Model>,
        rng: &mut Rng,
    ) -> Result<Option<Knowledge<Self::Model>>, FitError>;

    /// Bytes from which [`Self::read`] has `knowledge` again; `None` for learners that fit again instead, from the same data and the same random numbers.
    fn save(&self, _knowledge: &Knowledge<Self::Model>) -> Option<Vec<u8>> {
        None
    }

    /// What [`Self::save`] wrote, of a fit to the same kind of data.
    ///
    /// # Errors
    /// [`CheckpointError`] if the bytes are something else.
    fn read(&self, _saved: &[u8]) -> Result<Knowledge<Self::Model>, CheckpointError> {
        Err(CheckpointError::new("this learner writes nothing down"))
    }

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
    ) -> Result<Option<Knowledge<Infallible>>, FitError> {
        Ok(None)
    }
}
