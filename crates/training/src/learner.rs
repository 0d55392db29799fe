//! SINDy as a learner whose models remember how they were found.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sindyna_core::{
    CheckpointError, Dataset, Diverged, Dynamics, DynamicsLearner, FitError, Jacobians, Knowledge, Rng, decode, encode,
};
use sindyna_sindy::{Identified, Identifier, Watch};

use crate::shown::shown_in;

/// Fits by [`Identifier::identify_watched`], unless that was done before, until `stop` is set.
pub struct Learner {
    /// How equations are found.
    pub identifier: Identifier,
    /// What was identified before: nothing is fitted then.
    pub given: Option<Identified>,
    /// Set where fits are to end.
    pub stop: Arc<AtomicBool>,
}

/// An identified model together with the report on it.
#[derive(Debug, Clone)]
pub struct Fitted(pub Identified);

impl Dynamics for Fitted {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        self.0.model.step(x, u, rng, next)
    }

    fn linearize(&self, x: &[f64], u: &[f64], rng: &mut Rng) -> Result<Jacobians, Diverged> {
        self.0.model.linearize(x, u, rng)
    }

    fn coarse(&self) -> Option<Arc<dyn Dynamics>> {
        self.0.model.coarse()
    }
}

impl Learner {
    fn knowledge(&self, identified: Identified) -> Knowledge<Fitted> {
        let Knowledge { certainty, posterior, sensor_noise, .. } = identified.clone().knowledge(self.identifier.spec());
        Knowledge { model: Arc::new(Fitted(identified)), certainty, posterior, sensor_noise }
    }
}

impl DynamicsLearner for Learner {
    type Model = Fitted;

    fn fit(
        &self,
        data: &Dataset,
        previous: Option<&Fitted>,
        _rng: &mut Rng,
    ) -> Result<Option<Knowledge<Fitted>>, FitError> {
        if let Some(given) = &self.given {
            return Ok(Some(self.knowledge(given.clone())));
        }
        let go_on = || !self.stop.load(Ordering::SeqCst);
        let identifier = self.identifier.clone().with_previous(previous.map(|before| &before.0.model));
        let data = shown_in(data, identifier.spec().observation_dim())?;
        Ok(Some(self.knowledge(identifier.identify_watched(&data, &Watch::going_on(&go_on))?)))
    }

    fn goes_on(&self) -> bool {
        true
    }

    fn save(&self, knowledge: &Knowledge<Fitted>) -> Option<Vec<u8>> {
        Some(encode(&knowledge.model.0))
    }

    fn read(&self, saved: &[u8]) -> Result<Knowledge<Fitted>, CheckpointError> {
        decode(saved).map(|identified| self.knowledge(identified))
    }

    fn rows(&self, model: &Fitted, _data: &Dataset) -> usize {
        model.0.report.rows
    }

    fn describe(&self, model: &Fitted) -> Vec<String> {
        model.0.model.equations()
    }
}
