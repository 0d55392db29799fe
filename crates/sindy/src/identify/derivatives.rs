//! Equations from derivatives that were measured.

use ndarray::Array2;
use sindyna_core::{Channel, Dataset, FitError, Precision, Prior, Scheme, Spec};

use super::Identifier;
use super::report::{Identified, Noise};
use crate::Watch;
use crate::model::{Form, Model, ModelParts};

/// Samples that equations are found in first.
const FIRST: usize = 80;

/// Part of the usual effort, with which only what rounding explains is found.
const EFFORT: f64 = 0.02;

/// Runge–Kutta steps per control interval of the model.
const SUBSTEPS: usize = 8;

/// Samples with the derivatives of their states.
#[derive(Debug, Clone, Copy)]
pub struct Derived<'a> {
    /// States (T, n).
    pub states: &'a Array2<f64>,
    /// Controls at the same time (T, k).
    pub controls: &'a Array2<f64>,
    /// Derivatives of the states (T, n).
    pub derivatives: &'a Array2<f64>,
}

impl Identifier {
    /// Equations that explain measured derivatives up to rounding errors; `None` if there are none. They say nothing of what is between samples.
    ///
    /// x + ẋ is where one step of Euler of 1 s leads from x: derivatives are samples of such steps, with all that is known of those of simulators.
    ///
    /// # Errors
    /// [`FitError::Interrupted`] if `watch` said so, and if values are not finite.
    pub fn identify_derivatives(&self, of: Derived<'_>, watch: &Watch<'_>) -> Result<Option<Identified>, FitError> {
        // x + ẋ is no state of the system, and may be beyond its limits.
        let channel = |c: &Channel| Channel { prior: Prior::of_scale(c.prior.scale), ..c.clone() };
        let state: Vec<Channel> = self.spec.state.iter().map(channel).collect();
        let spec = Spec {
            observation: state.clone(),
            state,
            dt: 1.0,
            noise: 0.0,
            precision: Precision::F64,
            ..self.spec.clone()
        };
        let identifier = Self { spec, ..self.clone() };
        let explained = |rows: &[usize]| {
            let found = identifier.clone().with_effort(EFFORT).identify_watched(&steps(of, rows)?, watch);
            match found {
                Ok(found)
                    if found.report.noise == Noise::Rounding
                        && found.report.equations.iter().all(|e| e.reached_floor) =>
                {
                    Ok(Some(found))
                }
                Err(FitError::Interrupted) => Err(FitError::Interrupted),
                _ => Ok(None),
            }
        };
        let rows = of.states.nrows();
        let few: Vec<usize> = (0..rows.min(FIRST)).map(|i| i * rows / rows.min(FIRST)).collect();
        let found = match explained(&few)? {
            Some(found) if few.len() == rows => Some(found),
            Some(_) => explained(&(0..rows).collect::<Vec<_>>())?,
            None => None,
        };
        Ok(found.and_then(|found| Some(Identified { model: in_continuous_time(&found.model, self.spec.dt)?, ..found })))
    }
}

/// A step of Euler of 1 s from each of the samples number `rows`.
fn steps(of: Derived<'_>, rows: &[usize]) -> Result<Dataset, FitError> {
    let failed = |e: sindyna_core::DatasetError| FitError::Regression { reason: e.to_string() };
    let mut data = Dataset::new(of.states.ncols(), of.controls.ncols(), of.controls.ncols(), 1.0);
    for &t in rows {
        let (x, u) = (of.states.row(t), of.controls.row(t).to_vec());
        let next: Vec<f64> = x.iter().zip(of.derivatives.row(t)).map(|(x, rate)| x + rate).collect();
        data.begin(&x.to_vec()).map_err(failed)?;
        data.push(&u, &u, 0.0, &next).map_err(failed)?;
    }
    Ok(data)
}

/// The equations of `model` in continuous time, for control intervals of `dt` \[s\].
fn in_continuous_time(model: &Model, dt: f64) -> Option<Model> {
    let form = Form::Continuous(Scheme::Rk4 { substeps: SUBSTEPS });
    Model::new(ModelParts { form, dt, ..model.parts().clone() }).ok()
}
