//! SINDy as a learner whose models remember how they were found.

use sindyna_core::{Dataset, Diverged, Dynamics, DynamicsLearner, FitError, Rng};
use sindyna_sindy::{Identified, Identifier};

/// Fits by [`Identifier::identify`].
pub(crate) struct Learner(pub(crate) Identifier);

/// An identified model together with the report on it.
#[derive(Debug, Clone)]
pub(crate) struct Fitted(pub(crate) Identified);

impl Dynamics for Fitted {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        self.0.model.step(x, u, rng, next)
    }
}

impl DynamicsLearner for Learner {
    type Model = Fitted;

    fn fit(&self, data: &Dataset, _previous: Option<&Fitted>, _rng: &mut Rng) -> Result<Option<Fitted>, FitError> {
        self.0.identify(data).map(|identified| Some(Fitted(identified)))
    }

    fn rows(&self, model: &Fitted, _data: &Dataset) -> usize {
        model.0.report.rows
    }

    fn describe(&self, model: &Fitted) -> Vec<String> {
        model.0.model.equations()
    }
}
