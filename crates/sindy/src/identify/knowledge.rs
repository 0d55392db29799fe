//! What an identification tells whoever uses its model.

use std::sync::Arc;

use sindyna_core::{Certainty, Channel, Kind, Knowledge, Spec};

use super::report::{Identified, Noise};
use crate::Model;
use crate::estimate::Doubt;

impl Identified {
    /// How well the equations explain the data.
    #[must_use]
    pub fn certainty(&self) -> Certainty {
        let equations = &self.report.equations;
        if !equations.iter().all(|e| e.reached_floor || e.doubt.is_some_and(Doubt::is_of_rivals)) {
            Certainty::Doubted
        } else if !equations.iter().all(|e| e.reached_floor) {
            Certainty::Ambiguous
        } else if self.report.noise == Noise::Rounding {
            Certainty::Exact
        } else {
            Certainty::Adequate
        }
    }

    /// Standard deviation of the sensors' noise, one per observation channel of `spec` and in its unit, as far as the data tell: the
    /// cosine and the sine of an angle have that of the angle. `None` where it was not estimated.
    #[must_use]
    pub fn sensor_noise(&self, spec: &Spec) -> Option<Vec<f64>> {
        if self.certainty() == Certainty::Exact {
            return Some(vec![0.0; spec.observation_dim()]);
        }
        let state = |channel: &Channel| match channel.kind {
            Kind::CosOf(i) | Kind::SinOf(i) => Some(i),
            _ => spec.state.iter().position(|s| s.name == channel.name),
        };
        let deviation = |channel: &Channel| self.report.noise_deviations.get(state(channel)?).copied();
        spec.observation.iter().map(deviation).collect()
    }

    /// The model and what is known of its errors, for whoever plans or learns with it in the system of `spec`.
    #[must_use]
    pub fn knowledge(self, spec: &Spec) -> Knowledge<Model> {
        let (certainty, sensor_noise) = (self.certainty(), self.sensor_noise(spec));
        let models = self.models.filter(|_| certainty < Certainty::Exact);
        let posterior = models.map(|models| Arc::new(models) as Arc<dyn sindyna_core::Posterior>);
        Knowledge { model: Arc::new(self.model), certainty, posterior, sensor_noise }
    }
}
