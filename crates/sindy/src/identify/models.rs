//! Models that the data allow.

use std::sync::Arc;

use rand_distr::{Distribution as _, StandardNormal};
use serde::{Deserialize, Serialize};
use sindyna_core::{Dynamics, Rng};

use crate::estimate::Posterior;
use crate::model::{Model, as_text};
use crate::motion::Stepping;
use crate::regression::{Space, Summands, of_equations};

/// Models that the data allow: each set of terms that explains them about as well as the best, by its odds, with coefficients drawn from
/// their joint distribution.
///
/// The distribution is that of the fit to whole trajectories, linearised at the best coefficients: its covariance is the inverse of the Fisher
/// information. It speaks of the candidate terms alone: that the true ones are not among them is no part of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Models {
    posterior: Posterior,
    space: Space,
    stepping: Stepping,
    dt: f64,
    /// What inputs act through, if anything.
    actuators: Option<Actuators>,
    /// By how much the coefficients of the likeliest model change with a standard error of something else, if there is such.
    slopes: Vec<f64>,
    /// The likeliest model.
    #[serde(with = "as_text")]
    best: Model,
}

/// Actuators: their time constant \[s\], and the names of what they deliver (k).
type Actuators = (f64, Vec<String>);

impl Models {
    pub(super) fn new(posterior: Posterior, space: Space, stepping: Stepping, dt: f64, best: &Model) -> Self {
        Self { posterior, space, stepping, dt, actuators: None, slopes: Vec::new(), best: best.clone() }
    }

    /// The same of inputs that act through `actuators`; the likeliest one is `best`.
    pub(super) fn with_actuators(self, actuators: Actuators, best: &Model) -> Self {
        Self { actuators: Some(actuators), best: best.clone(), ..self }
    }

    /// The same where coefficients change by `slopes` with a standard error of something else.
    pub(super) fn depending(self, slopes: &[f64]) -> Self {
        Self { slopes: slopes.to_vec(), ..self }
    }

    /// The same over control intervals of `dt` \[s\]; `None` where only what one interval leads to is known.
    pub(super) fn over_intervals(self, dt: f64) -> Option<Self> {
        Some(Self { best: self.best.over_intervals(dt)?, ..self })
    }

    /// Draws a model; where the data do not determine its coefficients, the likeliest one.
    pub fn draw(&self, rng: &mut Rng) -> Arc<Model> {
        let model = self.posterior.draw(rng).and_then(|(terms, equations)| {
            let equations: Vec<Summands<'_>> = equations.iter().map(|(s, xi)| (&s[..], &xi[..])).collect();
            let model = of_equations(self.space.clone(), &terms, &equations, self.stepping.form(), self.dt).ok()?;
            let model = if self.slopes.is_empty() { model } else { moved(model, &self.slopes, rng) };
            let model = match &self.actuators {
                Some((tau, names)) => model.with_actuators(*tau, names).ok()?,
                None => model,
            };
            model.over_intervals(self.best.dt())
        });
        Arc::new(model.unwrap_or_else(|| self.best.clone()))
    }
}

/// `model` with coefficients that are moved along `slopes`, where it has as many.
fn moved(model: Model, slopes: &[f64], rng: &mut Rng) -> Model {
    let by: f64 = StandardNormal.sample(rng);
    let xi = model.fitted();
    if xi.len() != slopes.len() {
        return model;
    }
    let xi: Vec<f64> = xi.iter().zip(slopes).map(|(xi, slope)| xi + by * slope).collect();
    model.with_fitted(&xi)
}

impl sindyna_core::Posterior for Models {
    fn draw(&self, rng: &mut Rng) -> Arc<dyn Dynamics> {
        self.draw(rng)
    }
}
