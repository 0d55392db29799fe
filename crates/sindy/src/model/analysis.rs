//! What engineers ask of a model: simulation, prediction, linearisation.

use ndarray::{Array2, ArrayView2, s};
use sindyna_core::{Dynamics as _, Seed};

use super::inputs::Inputs;
use super::slopes::Room;
use super::{Form, Model};

/// Why a model could not be simulated, compared or linearised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// Arrays that do not fit the model.
    #[error("{what}: expected {expected}, got {got}")]
    Shape {
        /// What was counted.
        what: &'static str,
        /// Number wanted.
        expected: usize,
        /// Number found.
        got: usize,
    },
    /// The states left the finite numbers.
    #[error("the model diverges in step {step}")]
    Diverged {
        /// The first step that is not finite, from 0.
        step: usize,
    },
    /// A map is not stepped by any other interval than its own.
    #[error("samples {got} s apart do not match the step of the model, {expected} s")]
    Interval {
        /// The model's interval \[s\].
        expected: f64,
        /// The samples' interval \[s\].
        got: f64,
    },
    /// Inputs with first-order hold, and a model that is not continuous in time.
    #[error("first-order hold needs a model that is continuous in time; this one takes inputs that are held")]
    Held,
    /// The equations cannot be solved for the rates there.
    #[error("the equations are singular there")]
    Singular,
    /// The model lives in other coordinates than the states it is asked about.
    #[error("a model in raw coordinates (cosines and sines) has steps only")]
    Raw,
}

fn shape(what: &'static str, expected: usize, got: usize) -> Result<(), AnalysisError> {
    if expected == got { Ok(()) } else { Err(AnalysisError::Shape { what, expected, got }) }
}

impl Model {
    /// The states (T + 1, n) from `x0` (n) on under the inputs `u` (T, k), each over one interval [`Self::dt`].
    ///
    /// # Errors
    /// [`AnalysisError`] for arrays that do not fit, or where the model diverges.
    pub fn simulate<'a>(&self, x0: &[f64], u: impl Into<Inputs<'a>>) -> Result<Array2<f64>, AnalysisError> {
        let u = u.into();
        self.simulate_at(x0, u, &vec![self.dt(); u.start.nrows()])
    }

    /// The same with an interval of its own for every step, `dt` \[s\] (T).
    ///
    /// # Errors
    /// As [`Self::simulate`]; [`AnalysisError::Interval`] if the model is a map, [`AnalysisError::Held`] if inputs are not held and the model is not continuous in
    /// time.
    pub fn simulate_at<'a>(
        &self,
        x0: &[f64],
        u: impl Into<Inputs<'a>>,
        dt: &[f64],
    ) -> Result<Array2<f64>, AnalysisError> {
        let Inputs { start: u, end, intersample } = u.into();
        if self.readings().is_some() {
            return Err(AnalysisError::Raw);
        }
        shape("states", self.states().len(), x0.len())?;
        shape("inputs", self.controls().len(), u.ncols())?;
        shape("intervals", u.nrows(), dt.len())?;
        if let Some(end) = &end {
            shape("rows of inputs at the ends of steps", u.nrows(), end.nrows())?;
            shape("inputs at the ends of steps", u.ncols(), end.ncols())?;
        }
        let mut x = Array2::zeros((u.nrows() + 1, x0.len()));
        x.row_mut(0).iter_mut().zip(x0).for_each(|(slot, v)| *slot = *v);
        let mut rng = Seed::new(0).stream("no randomness", 0);
        let mut next = vec![0.0; x0.len()];
        for (t, (u, &dt)) in u.rows().into_iter().zip(dt).enumerate() {
            let (now, u) = (x.row(t).to_vec(), u.to_vec());
            let own = (dt - self.dt()).abs() <= 1e-9 * self.dt();
            let ramp: Option<Vec<f64>> = end.map(|end| end.row(t).iter().zip(&u).map(|(end, u)| end - u).collect());
            let stepped = match (self.form(), ramp) {
                (Form::Continuous(scheme), Some(ramp)) => match intersample.switch() {
                    None => self.ramped((scheme, dt), &now, (&u, &ramp, intersample), &mut rng, &mut next),
                    Some(part) => {
                        let after: Vec<f64> = u.iter().zip(&ramp).map(|(u, by)| u + by).collect();
                        let mut between = now.clone();
                        self.held((scheme, part * dt), &now, &u, &mut rng, &mut between).and_then(|()| {
                            self.held((scheme, (1.0 - part) * dt), &between, &after, &mut rng, &mut next)
                        })
                    }
                },
                (_, Some(_)) => return Err(AnalysisError::Held),
                (Form::Continuous(scheme), None) if !own => self.held((scheme, dt), &now, &u, &mut rng, &mut next),
                _ if own => self.step(&now, &u, &mut rng, &mut next),
                _ => return Err(AnalysisError::Interval { expected: self.dt(), got: dt }),
            };
            stepped.map_err(|_| AnalysisError::Diverged { step: t })?;
            x.row_mut(t + 1).iter_mut().zip(&next).for_each(|(slot, v)| *slot = *v);
        }
        Ok(x)
    }

    /// ∂f/∂x (n, n) and ∂f/∂u (n, k) of the right-hand side f at a state and input: of ẋ = f for a continuous or semi-implicit
    /// model, of (x⁺ − x)/Δt = f or x⁺ = f for the others. Exact, from the terms.
    ///
    /// # Errors
    /// [`AnalysisError`] for slices that do not fit, or where the equations cannot be solved for the rates.
    pub fn jacobians(&self, x: &[f64], u: &[f64]) -> Result<(Array2<f64>, Array2<f64>), AnalysisError> {
        if self.readings().is_some() {
            return Err(AnalysisError::Raw);
        }
        let (n, k) = (self.states().len(), self.controls().len());
        shape("states", n, x.len())?;
        shape("inputs", k, u.len())?;
        let mut room = Room::default();
        self.with_slopes(x, u, &mut room).ok_or(AnalysisError::Singular)?;
        let part = |first: usize, width: usize| {
            Array2::from_shape_fn((n, width), |(i, j)| room.slopes[i * (n + k) + first + j])
        };
        Ok((part(0, n), part(n, k)))
    }

    /// Predictions of the samples `x` (T + 1, n), each from the sample `horizon` steps before it, or for the first ones from the first
    /// sample; from the first sample alone without a horizon. Under the inputs `u` (T, k), `dt` \[s\] apart (T).
    ///
    /// # Errors
    /// As [`Self::simulate_at`].
    pub fn predict<'a>(
        &self,
        x: ArrayView2<'_, f64>,
        u: impl Into<Inputs<'a>>,
        dt: &[f64],
        horizon: Option<usize>,
    ) -> Result<Array2<f64>, AnalysisError> {
        let u = u.into();
        let steps = u.start.nrows();
        shape("rows of states", steps + 1, x.nrows())?;
        let Some(horizon) = horizon.filter(|h| *h < steps) else { return self.simulate_at(&x.row(0).to_vec(), u, dt) };
        let mut predicted = x.to_owned();
        for from in 0..=steps - horizon {
            let to = from + horizon;
            let ahead = self.simulate_at(&x.row(from).to_vec(), u.part(from, to), &dt[from..to]);
            let ahead = ahead.map_err(|e| match e {
                AnalysisError::Diverged { step } => AnalysisError::Diverged { step: from + step },
                other => other,
            })?;
            if from == 0 {
                predicted.slice_mut(s![..=horizon, ..]).assign(&ahead);
            }
            predicted.row_mut(to).assign(&ahead.row(horizon));
        }
        Ok(predicted)
    }
}
